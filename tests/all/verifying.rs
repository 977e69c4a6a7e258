//! `verify`, and what is computed again of a log: the same as what would have been written, and no log breaks it.

use std::fs;
use std::path::Path;

use ambidex::files::{Disk, load_mission, load_source};
use ambidex::model::Record;
use ambidex::record::{History, Reader};
use ambidex::replay::Replay;
use ambidex::tree::Settings;

use crate::driver::Rng;
use crate::fixtures::{experiment_file, file, load, simulate};
use crate::home::Home;

/// Simulates a mission and gives the text of its log.
fn logged(home: &Home, mission: &Path, name: &str, more: &[&str]) -> String {
    let log = home.path(name);
    let args = ["simulate".as_ref(), "--quiet".as_ref(), mission.as_os_str(), "--log".as_ref(), log.as_os_str()];
    home.start(args.into_iter().chain(more.iter().map(AsRef::as_ref))).ends(0);
    fs::read_to_string(log).expect("a log")
}

fn check(home: &Home, log: &str, code: i32, said: &str) {
    let path = home.write("checked.jsonl", log);
    let finished = home.start(["verify".as_ref(), path.as_os_str()]).ends(code);
    let all = finished.stdout.clone() + &finished.words();
    assert!(all.contains(said), "{finished:#?}");
}

#[test]
fn a_log_that_was_changed_is_told_with_its_line() {
    let home = Home::new();
    let log = logged(&home, &experiment_file(1), "run.jsonl", &[]);
    check(&home, &log, 0, "same: 23 decisions computed again from");
    let lines: Vec<&str> = log.lines().collect();
    let at = |word: &str| lines.iter().position(|line| line.contains(word)).expect("such a line");
    let without = |line: usize| [&lines[..line], &lines[line + 1..]].concat().join("\n") + "\n";
    let decided = at("\"record\":\"decided\"");
    let other = lines[decided].replacen("0.50", "0.51", 1);
    let changed = log.replacen(lines[decided], &other, 1);
    check(&home, &changed, 1, &format!("different at line {}", decided + 1));
    let released = at("\"record\":\"released\"");
    check(&home, &without(released), 1, &format!("different at line {}", released + 1));
    check(&home, &without(at("\"record\":\"told\",\"at\":6580000")), 1, "different at line");
    let last = lines.iter().rposition(|line| line.contains("\"turn\"")).expect("a turn");
    check(&home, &(lines[..=last].join("\n") + "\n{\"rec"), 0, "its last line was cut off");
    check(&home, "mission: x\n", 2, "is no journal");
    let source = lines[0].find(",\"source\":").expect("the files");
    let bare = format!("{}}}\n", &lines[0][..source]);
    check(&home, &bare, 2, "does not carry the files of its mission");
    home.is_empty();
}

#[test]
fn what_is_not_written_is_computed_again() {
    let home = Home::new();
    for mission in ["config/missions/experiment-1.yaml", "config/missions/hand-over.yaml"] {
        logged(&home, &file(mission), "all.jsonl", &["--messages", "all"]);
        logged(&home, &file(mission), "none.jsonl", &["--messages", "none"]);
        let printed = |verb: &str, log: &str, more: &[&str]| {
            let log = home.path(log);
            let args = [verb.as_ref(), log.as_os_str()];
            let finished = home.start(args.into_iter().chain(more.iter().map(AsRef::as_ref))).ends(0);
            // Messages are computed turn by turn; their order within one is that of no clock.
            let mut lines: Vec<String> = finished.stdout.lines().map(str::to_owned).collect();
            if verb == "trace" {
                lines.sort();
            }
            lines
        };
        for (verb, more) in [("explain", &["*"][..]), ("trace", &["--feedback"]), ("timeline", &[]), ("verify", &[])] {
            let (all, none) = (printed(verb, "all.jsonl", more), printed(verb, "none.jsonl", more));
            match verb {
                "verify" => assert!(none[0].starts_with("same: ")),
                _ => assert_eq!(all, none, "{verb} {mission}"),
            }
        }
        let size = |log: &str| fs::metadata(home.path(log)).expect("a log").len();
        assert!(size("none.jsonl") < size("all.jsonl"));
    }
    home.is_empty();
}

#[test]
fn a_mission_is_made_again_of_what_its_log_carries() {
    let folder = fs::read_dir(file("config/missions")).expect("the shipped missions");
    for path in folder.map(|entry| entry.expect("an entry").path()) {
        let loaded = load_mission(&Disk, &path, None, &[]).expect("a sound mission").mission;
        let source = loaded.source.as_ref().expect("it was loaded from files");
        assert!(source.files.iter().all(|file| !file.path.starts_with('/')), "{path:?}");
        assert_eq!(*load_source(source).expect("the same files").mission, *loaded, "{path:?}");
    }
}

#[test]
fn a_file_may_have_several_names() {
    let home = Home::new();
    let lib = "library: mine\nsubtrees:\n  nothing:\n    task: {move: shelf}\n";
    home.write("lib.yaml", lib);
    std::os::unix::fs::symlink(home.path("lib.yaml"), home.path("same.yaml")).expect("a link");
    let text = fs::read_to_string(experiment_file(1)).expect("a mission");
    let robot = file("config/robots/pr2.yaml");
    let text = text.replace("../robots/pr2.yaml", robot.to_str().expect("a path"));
    let mission = home.write("mission.yaml", &format!("{text}\ninclude: [lib.yaml, ./lib.yaml, same.yaml]\n"));
    let loaded = load_mission(&Disk, &mission, None, &[]).expect("a sound mission").mission;
    assert_eq!(*load_source(loaded.source.as_ref().expect("files")).expect("the same files").mission, *loaded);
    check(&home, &logged(&home, &mission, "run.jsonl", &[]), 0, "same: ");
}

#[test]
fn what_was_forged_is_told() {
    let home = Home::new();
    let log = logged(&home, &experiment_file(2), "run.jsonl", &[]);
    let turn = log.find("{\"record\":\"turn\"").expect("a turn");
    for change in
        ["{\"object\":[99999,\"unknown\"]}", "{\"emptied\":4294967295}", "{\"object\":[0,{\"at\":4294967295}]}"]
    {
        let observed = format!("{{\"record\":\"observed\",\"at\":0,\"change\":{change}}}\n");
        check(&home, &[&log[..turn], &observed, &log[turn..]].concat(), 1, "different at line");
        for origin in ["\"operator\"", "\"script\"", "{\"controller\":4294967295}"] {
            let input = format!("{{\"kind\":\"world\",\"change\":{change},\"origin\":{origin}}}");
            let told = format!("{{\"record\":\"told\",\"at\":0,\"input\":{input}}}\n");
            check(&home, &[&log[..turn], &told, &log[turn..]].concat(), 1, "different at line");
        }
    }
    check(&home, &log.replacen("\"nodes\":[\"root\"", "\"nodes\":[\"boot\"", 1), 1, "different at line 1");
    let late = "{\"record\":\"turn\",\"at\":18446744073709551615}\n";
    check(&home, &[&log[..turn], late, &log[turn..]].concat(), 2, "later than any run lasts");
    let rounds =
        home.write("rounds.jsonl", &log.replacen("\"round\":3,\"granted\"", "\"round\":4294967295,\"granted\"", 1));
    home.start(["explain".as_ref(), rounds.as_os_str(), "*".as_ref()]).ends(0);
}

/// Lines that are lost, doubled, swapped or from elsewhere: the replay refuses or takes them, and nothing panics.
#[test]
fn no_log_breaks_what_reads_it() {
    let mission = load(&experiment_file(2));
    let (records, _) = simulate(&mission, &Settings::default(), Vec::new());
    let (other, _) = simulate(&load(&experiment_file(3)), &Settings::default(), Vec::new());
    let Some(Record::Header(header)) = records.first() else { panic!("a header") };
    let mut differences = 0;
    for seed in 0..400 {
        let mut rng = Rng::of(&[seed]);
        let mut forged = records.clone();
        for _ in 0..1 + rng.below(4) {
            let at = 1 + rng.below(forged.len() - 1);
            match rng.below(4) {
                0 => drop(forged.remove(at)),
                1 => forged.insert(at, forged[at].clone()),
                2 => forged.swap(at, 1 + rng.below(records.len() - 2)),
                _ => forged[at] = other[1 + rng.below(other.len() - 1)].clone(),
            }
        }
        let mut replay = Replay::new(&mission, &Settings::default());
        differences += u32::from(forged.iter().any(|record| replay.take(record).is_err()));
        let mut history = History::with_past(header);
        forged.iter().for_each(|record| history.apply(record));
        history.report();
    }
    assert!(differences > 50, "{differences}");
}

#[test]
fn a_log_of_real_processes_is_the_same() {
    let home = Home::new();
    let (mission, log) = (experiment_file(4), home.path("run.jsonl"));
    let args = ["run".as_ref(), "--quiet".as_ref(), "--speed".as_ref(), "20".as_ref(), mission.as_os_str()];
    home.start(args.into_iter().chain(["--log".as_ref(), log.as_os_str()])).ends(0);
    assert!(Reader::open(&log).is_ok());
    check(&home, &fs::read_to_string(&log).expect("a log"), 0, "same: ");
    home.is_empty();
}
