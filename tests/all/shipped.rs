//! The shipped missions that are not four times pick-and-place, declared twins of the paper's behaviors, and schemas.

use std::path::PathBuf;
use std::sync::Arc;

use ambidex::files::{self, Format};
use ambidex::model::{Location, MissionSpec, Record, ResourceId};
use ambidex::record::{Journal, LeafState};
use ambidex::tree::{Serial, Settings};
use serde_json::Value;

use crate::fixtures::{experiment_file, file, history, load, simulate};
use crate::home::Home;

fn mission(name: &str) -> PathBuf {
    file(&format!("config/missions/{name}.yaml"))
}

/// What each mission must come to, step by step.
const STEPS: &[(&str, &[&str])] = &[
    (
        "set-the-table",
        &[
            "fetch placemat",
            "pick placemat",
            "bring placemat",
            "place placemat",
            "fetch can",
            "pick can + pick plate",
            "bring can",
            "place can + place plate",
            "fetch bowl",
            "pick bowl",
            "bring bowl",
            "place bowl",
            "fetch spoon",
            "pick fork + pick spoon",
            "bring spoon",
            "place fork + place spoon",
            "fetch knife",
            "pick knife",
            "bring knife",
            "place knife",
        ],
    ),
    (
        "search",
        &["fetch mail + look at shelf", "look at sofa", "look at bench", "pick mail", "bring mail", "place mail"],
    ),
    ("read-a-label", &["fetch cup", "pick cup + pick mug", "bring cup", "place cup + place mug + read at counter"]),
    (
        "hand-over",
        &[
            "move to left shelf",
            "pick bottle with left_gripper",
            "place bottle",
            "pick bottle with right_gripper",
            "place bottle #2",
        ],
    ),
    (
        "island",
        &[
            "go for the pan",
            "pick loaf + pick pan",
            "bring the pan",
            "place loaf + place pan",
            "go for the jug",
            "pick jug",
            "bring the jug",
            "place jug",
        ],
    ),
    (
        "three-hands",
        &[
            "fetch 1 + look at back door + look at front door",
            "pick 1 + pick 2 + pick 3",
            "bring 1",
            "place 1 + place 2 + place 3",
        ],
    ),
    (
        "tray",
        &[
            "look at window + move to kitchen",
            "look at table",
            "pick tray with both hands",
            "move to table",
            "place tray with both hands",
            "fetch cup",
            "pick cup",
            "bring cup",
            "place cup",
        ],
    ),
    (
        "pass-on",
        &[
            "move to left shelf",
            "pick bottle with left_gripper",
            "take over bottle with right_gripper",
            "leave bottle to right_gripper",
            "move to right shelf",
            "place bottle",
        ],
    ),
    (
        "crate",
        &[
            "move to depot",
            "pick red",
            "stow red",
            "pick green",
            "stow green",
            "pick blue",
            "move to door #3",
            "place blue",
            "unstow red",
            "place red",
            "unstow green",
            "place green",
        ],
    ),
    (
        "two-hands",
        &[
            "go to the jam",
            "pick jam",
            "open jam",
            "pick honey + put down jam",
            "open honey",
            "bring honey",
            "put down honey",
        ],
    ),
];

#[test]
fn the_shipped_missions_come_out_as_they_must() {
    for (name, expected) in STEPS {
        let spec = load(&mission(name));
        let (_, report) = simulate(&spec, &Settings::default(), Vec::new());
        assert_eq!(report.outcome.word(), "done", "{name}");
        let steps: Vec<String> = report.steps.iter().map(|step| step.join(" + ")).collect();
        assert_eq!(steps, *expected, "{name}");
        let serial = Settings { allocator: std::sync::Arc::new(Serial), ..Settings::default() };
        let (_, one_by_one) = simulate(&spec, &serial, Vec::new());
        assert_eq!(one_by_one.outcome.word(), "done", "{name}, serial");
        assert!(one_by_one.steps.iter().all(|step| step.len() == 1), "{name}");
    }
}

#[test]
fn a_mission_is_told_where_the_mail_goes() {
    let home = Home::new();
    let path = mission("search");
    let bench = ["--set".as_ref(), "to=bench".as_ref()];
    let finished =
        home.start([&["simulate".as_ref(), path.as_os_str(), "--json".as_ref()], &bench[..]].concat()).ends(0);
    let report: Value = serde_json::from_str(&finished.stdout).expect("a report");
    let steps: Vec<String> = report["steps"].as_array().expect("steps").iter().map(ToString::to_string).collect();
    assert_eq!(
        steps,
        [
            r#"["fetch mail","look at shelf"]"#,
            r#"["look at sofa"]"#,
            r#"["look at bench"]"#,
            r#"["pick mail"]"#,
            r#"["bring mail"]"#,
            r#"["place mail"]"#
        ]
    );
    for (verb, setting, words) in [
        ("simulate", "to=bnech", "--set to=bnech: there is no place `bnech` help: did you mean `bench`?"),
        ("run", "too=bench", "the mission has no parameter `too` help: did you mean `to`?"),
        ("daemon", "to", "write NAME=VALUE, such as object=cup"),
        ("tree", "to=", "a name cannot be empty"),
    ] {
        let finished = home.start([verb.as_ref(), path.as_os_str(), "--set".as_ref(), setting.as_ref()]).ends(2);
        assert!(finished.words().contains(words), "{words}: {}", finished.stderr);
    }
    home.is_empty();
}

#[test]
fn the_table_is_set_in_its_order() {
    let (records, report) = simulate(&load(&mission("set-the-table")), &Settings::default(), Vec::new());
    let at = |name: &str| report.steps.iter().position(|step| step.iter().any(|behavior| behavior == name));
    let first = at("place placemat").expect("the placemat is laid");
    let later = ["pick spoon", "pick fork", "pick knife", "pick plate", "pick bowl"];
    assert!(later.iter().all(|name| at(name).is_some_and(|step| step > first)));
    assert!(at("place plate") < at("pick bowl"));
    let drinks = ["place glass", "place cup", "place can"].iter().filter(|name| at(name).is_some());
    assert_eq!(drinks.count(), 1);
    let ended = records.iter().any(|record| matches!(record, Record::Ended { .. }));
    assert!(ended);
}

#[test]
fn the_shipped_missions_run_with_processes() {
    let home = Home::new();
    for (name, expected) in STEPS {
        let finished = home.carry("run", &mission(name), &["--json", "--quiet", "--speed", "100"]).ends(0);
        let report: Value = serde_json::from_str(&finished.stdout).expect("a report");
        assert_eq!(report["outcome"], "done", "{name}");
        let all: Vec<&str> = expected.iter().flat_map(|step| step.split(" + ")).collect();
        let steps = report["steps"].as_array().expect("steps").iter().flat_map(|step| step.as_array().expect("names"));
        let mut ran: Vec<&str> = steps.map(|name| name.as_str().expect("a name")).collect();
        let mut all = all.clone();
        ran.sort_unstable();
        all.sort_unstable();
        assert_eq!(ran, all, "{name}");
        assert_eq!(finished.stderr, "", "{name}");
    }
    home.is_empty();
}

/// Experiments with the paper's behaviors under other names, declared in the mission file.
fn with_twins(number: u32) -> String {
    const TWINS: [(&str, &str); 3] = [("move", "drive"), ("pick", "take"), ("place", "put_down")];
    let paper = std::fs::read_to_string(file("config/behaviors/paper.yaml")).expect("it is shipped");
    let mut declared = paper[paper.find("behaviors:\n").expect("behaviors")..].to_owned();
    let mut text = std::fs::read_to_string(experiment_file(number)).expect("it is shipped");
    text = text.replace("../robots/pr2.yaml", file("config/robots/pr2.yaml").to_str().expect("a path in UTF-8"));
    for (kind, twin) in TWINS {
        let label = if kind == "move" { "" } else { &format!("    label: {kind} $object\n") };
        declared = declared.replace(&format!("\n  {kind}:\n"), &format!("\n  {twin}:\n{label}"));
        text = text.replace(&format!("- {kind}: "), &format!("- {twin}: "));
    }
    // The paper's offsets and names stand beside the kind.
    for (kind, twin) in TWINS {
        text = text.replace(&format!("{{{kind}: "), &format!("{{{twin}: "));
    }
    text.replace("\nworld:\n", &format!("\n{declared}\nworld:\n"))
}

#[test]
fn declared_twins_of_the_papers_behaviors_give_the_same_journal() {
    let home = Home::new();
    for number in 1..=4 {
        let journal = |path: &std::path::Path| {
            // The files themselves are not the same.
            let mission = Arc::new(MissionSpec { source: None, ..(*load(path)).clone() });
            let (records, _) = simulate(&mission, &Settings::default(), Vec::new());
            let mut journal = Journal::new(Vec::new());
            records.iter().for_each(|record| journal.write(record).expect("memory takes all"));
            String::from_utf8(journal.into_inner()).expect("JSON")
        };
        let (own, twins) = (journal(&experiment_file(number)), journal(&home.write("twins.yaml", &with_twins(number))));
        assert!(twins.contains("\"kind\":\"drive\"") && !twins.contains("\"kind\":\"move\""));
        let mut renamed = twins;
        for (kind, twin) in [("move", "drive"), ("pick", "take"), ("place", "put_down")] {
            renamed = renamed.replace(&format!("\"kind\":\"{twin}\""), &format!("\"kind\":\"{kind}\""));
        }
        assert_eq!(own, renamed, "experiment {number}");
    }
}

#[test]
fn a_way_that_an_or_did_not_take_is_not_called_skipped() {
    let (records, report) = simulate(&load(&mission("read-a-label")), &Settings::default(), Vec::new());
    assert_eq!(report.skipped, ["fetch mug", "bring mug", "go and read"]);
    let history = history(&records);
    let ways = history.leaves().filter(|leaf| history.state(*leaf) == LeafState::NotNeeded);
    assert!(ways.count() > 0, "the ways that were not taken");
}

fn formats() -> [(&'static str, Format); 6] {
    [
        ("mission", Format::Mission),
        ("world", Format::World),
        ("task", Format::Task),
        ("robot", Format::Robot),
        ("behaviors", Format::Behaviors),
        ("failures", Format::Failures),
    ]
}

#[test]
fn the_shipped_schemas_are_those_of_the_code() {
    let home = Home::new();
    for (name, format) in formats() {
        let printed = home.start(["schema", name]).ends(0).stdout;
        let shipped = std::fs::read_to_string(file(&format!("config/schemas/{name}.json"))).expect("it is shipped");
        assert_eq!(printed, shipped, "config/schemas/{name}.json: write it anew with `ambidex schema {name}`");
        let schema: Value = serde_json::from_str(&printed).expect("JSON");
        assert_eq!(schema, files::schema(format));
        jsonschema::meta::validate(&schema).expect("a schema of its draft");
    }
}

#[test]
fn the_shipped_files_are_as_their_schemas_say() {
    for (folder, (_, format)) in ["missions", "worlds", "tasks", "robots", "behaviors"].into_iter().zip(formats()) {
        let validator = jsonschema::validator_for(&files::schema(format)).expect("a schema");
        for entry in std::fs::read_dir(file("config").join(folder)).expect("a folder") {
            let path = entry.expect("an entry").path();
            let text = std::fs::read_to_string(&path).expect("a file");
            assert!(text.starts_with("# yaml-language-server: $schema=../schemas/"), "{}", path.display());
            let value: Value = serde_saphyr::from_str(&text).expect("YAML");
            let wrong: Vec<String> = validator.iter_errors(&value).map(|error| error.to_string()).collect();
            assert!(wrong.is_empty(), "{}: {wrong:?}", path.display());
            for (old, new) in [("  stand:", "  stnad:"), ("claims:", "claim:"), ("type:", "typ:"), ("at:", "ta:")] {
                if !text.contains(old) {
                    continue;
                }
                let value: Value = serde_saphyr::from_str(&text.replacen(old, new, 1)).expect("YAML");
                // A node of a task may be a behavior that only the reader knows.
                let is_seen = !validator.is_valid(&value) || old == "at:";
                assert!(is_seen, "{}: {old} -> {new}", path.display());
            }
        }
    }
}

/// The YAML blocks of a text.
fn yaml(text: &str) -> impl Iterator<Item = &str> {
    text.split("```yaml\n").skip(1).filter_map(|rest| rest.split("```").next())
}

#[test]
fn the_examples_of_the_docs_are_sound() {
    let home = Home::new();
    let robot = file("config/robots/pr2.yaml");
    let here = |text: &str| text.replace("../robots/pr2.yaml", robot.to_str().expect("a path in UTF-8"));
    let readme = std::fs::read_to_string(file("README.md")).expect("it is there");
    let tea = home.write("tea.yaml", &here(yaml(&readme).next().expect("an example")));
    let (_, report) = simulate(&load(&tea), &Settings::default(), Vec::new());
    assert_eq!((report.outcome.word(), report.steps.len()), ("done", 5));
    let told = home.start([std::ffi::OsStr::new("simulate"), tea.as_os_str()]).ends(0).stderr;
    assert!(told.contains("step 1: move to shelf (base)") && !told.contains("attached"), "{told}");
    let docs = std::fs::read_to_string(file("docs/missions.md")).expect("it is there");
    let examples: [&str; 13] = yaml(&docs).collect::<Vec<_>>().try_into().expect("thirteen examples");
    let [mission, island, limits, parameters, behaviors, calls, hands, busy, subtrees, room, errand, desk, failures] =
        examples;
    home.start(["check".as_ref(), home.write("desk.yaml", desk).as_os_str()]).ends(0);
    let failures = home.write("failures.yaml", failures);
    let desk = file("config/missions/desk.yaml");
    let args = ["simulate".as_ref(), desk.as_os_str(), "--fail".as_ref(), failures.as_os_str()];
    let told = home.start(args).ends(0).stderr;
    assert_eq!(told.matches("on purpose: ").count(), 5, "{told}");
    let household = file("config/behaviors/household.yaml");
    let household = household.to_str().expect("a path in UTF-8");
    let mission = here(mission).replace("../behaviors/household.yaml", household);
    load(&home.write("mission.yaml", &mission));
    let robot_key = format!("mission: island\nrobot: {}\n", robot.display());
    load(
        &home.write("island.yaml", &format!("{robot_key}{island}task: {{then: [{{move: island}}, {{pick: pan}}]}}\n")),
    );
    let plain = &mission[..mission.find("task:").expect("a task")];
    let limited = format!("{plain}{limits}").replace("  objects:\n", "  objects:\n    pot: {at: shelf}\n");
    let (_, report) = simulate(&load(&home.write("limited.yaml", &limited)), &Settings::default(), Vec::new());
    assert_eq!((report.outcome.word(), report.steps.len()), ("done", 4));
    let busy = load(&home.write("busy.yaml", &format!("{plain}{busy}")));
    assert_eq!(simulate(&busy, &Settings::default(), Vec::new()).1.outcome.word(), "done");
    let told = home.write("told.yaml", &format!("{plain}{parameters}"));
    let finished = home.start(["check", told.to_str().expect("UTF-8"), "--set", "to=table"]).ends(0);
    assert_eq!(finished.stderr, "");
    assert!(home.start(["check".as_ref(), told.as_os_str()]).ends(2).words().contains("tell it with `--set to=PLACE`"));
    let room = home.write("room.yaml", &room.replace("../behaviors/household.yaml", household));
    let errand = home.write("errand.yaml", errand);
    home.start(["check".as_ref(), "--strict".as_ref(), room.as_os_str(), errand.as_os_str()]).ends(0);
    let args = ["check".as_ref(), "--strict".as_ref(), "--robot".as_ref(), robot.as_os_str(), "--world".as_ref()];
    let finished = home.start([&args[..], &[room.as_os_str(), errand.as_os_str()]].concat()).ends(0);
    assert!(finished.stdout.contains("task tidy up, 7 nodes (5 behaviors) in world room"), "{}", finished.stdout);
    // The same world with what the other two need of it.
    let head = &mission[..mission.find("include:").expect("an include")];
    let world = &mission[mission.find("world:").expect("a world")..mission.find("task:").expect("a task")];
    let world = world.replace("  objects:\n", "  objects:\n    pot: {at: shelf}\n    sponge: {at: table}\n");
    let world = world.replace("    table:", "    sink: {stand: [0 m, 6 m]}\n    table:");
    let world = world.replace("{kettle on: false}", "{clean table: false}");
    let task = "task: {then: [{move: table}, {pick: sponge}, {wipe: table}, {place: sponge}]}\n";
    let wiping = load(&home.write("wiping.yaml", &format!("{head}{behaviors}{world}{task}")));
    assert_eq!(simulate(&wiping, &Settings::default(), Vec::new()).1.outcome.word(), "done");
    let delivering = load(&home.write("delivering.yaml", &format!("{head}{world}{subtrees}")));
    assert_eq!(simulate(&delivering, &Settings::default(), Vec::new()).1.outcome.word(), "done");
    let passing = load(&home.write("passing.yaml", &format!("{head}{hands}{world}task: {{hand_over: pen}}\n")));
    let (records, report) = simulate(&passing, &Settings::default(), Vec::new());
    assert_eq!(report.outcome.word(), "done");
    let pen = passing.names.objects.iter().position(|name| name == "pen").expect("a pen");
    assert_eq!(history(&records).world().objects[pen], Location::held(ResourceId(1)));
    let lab = file("config/robots/lab.yaml").display().to_string();
    let bench = "world: {robot: {at: [0, 0]}, places: {bench: {stand: [0, 0]}}, objects: {tube: {at: bench}}, \
                 facts: {scanned tube: false}}\ntask: {scan: tube}\n";
    let scanning = load(&home.write("scanning.yaml", &format!("mission: scanning\nrobot: {lab}\n{calls}{bench}")));
    assert_eq!(simulate(&scanning, &Settings::default(), Vec::new()).1.outcome.word(), "done");
}
