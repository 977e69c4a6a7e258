//! Declared behaviors, subtrees and libraries: what they become, and what is said of the mistakes in them.

use std::sync::Arc;

use std::path::Path;
use std::time::Duration;

use super::super::{Checked, FilesError, InMemory, check, load_mission};
use super::{PATH, ROBOT};
use ambidex_model::{
    Access, ChannelId, Condition, EffectTerm, FactId, MissionSpec, Mode, NodeId, ObjectId, PlaceId, Potential,
    ResourceId, Retention, Selector, Task, TypeId,
};

const MISSION: &str = "\
mission: own
robot: robot.yaml
include: [library.yaml]
behaviors:
  scan:
    parameters: {area: place, with: {type: type, default: gripper}, effort: {type: number, default: 2}}
    claims:
      eye: {type: $with, shared: at $area}
      other: {type: antenna, optional: true}
    potential: {table: {by: $area, values: {shelf: 3}, otherwise: 1}, scale_by: $with}
    goal: [{fact: clean $area}, {not_fact: dusty}]
    precondition: [{at: $area}, {lies: {object: cup, at: shelf}}]
    effects: [{set: clean $area}, {clear: dusty}]
    commands: [{claim: other, maintain: {look_at: $area}}]
    label: scan $area with effort $effort
    takes: 3 s
    timeout: 5 s
    retries: 1
subtrees:
  twice:
    parameters: {first: place, second: {type: place, default: table}}
    task:
      and:
        - {scan: $first, name: one of $second}
        - scan: {area: $second, with: wheel}
world:
  robot: {at: [0, 0]}
  places: {shelf: {stand: [1, 2]}, table: {stand: [3, 2]}}
  objects: {cup: {at: shelf}, pot: {at: shelf}}
  facts: {clean shelf: false, clean table: false, dusty: true}
task:
  then:
    - use: {twice: shelf}
    - {use: {twice: {first: table, second: shelf}}, name: again}
    - {rest: , timeout: 1 min}
";
const LIBRARY: &str = "\
library: small
behaviors:
  rest:
    claims: all
    potential: 0.5
    takes: 10 s
";

/// A mission, a library and a robot.
fn written(mission: &str, library: &str) -> InMemory {
    let robot = ROBOT.replace("  base: {type: base}\n", "  base: {type: base}\n  wheel: {type: wheel}\n");
    let mut files = super::written(mission, &robot);
    files.insert("library.yaml", library);
    files
}

fn load(mission: &str, library: &str) -> Result<Arc<MissionSpec>, FilesError> {
    load_mission(&written(mission, library), PATH.as_ref(), None, &[]).map(|loaded| loaded.mission)
}

#[test]
fn a_declared_behavior_is_bound_with_its_arguments() {
    let spec = load(MISSION, LIBRARY).unwrap_or_else(|error| panic!("{:?}", error.faults()));
    let names = ["root", "then", "twice shelf", "one of table", "scan table with effort 2"];
    assert_eq!(spec.names.nodes.to_vec()[..5], names);
    assert_eq!(spec.names.nodes.to_vec()[5..], ["again", "one of shelf", "scan shelf with effort 2", "rest"]);
    let shelf = spec.tree.behavior(NodeId(3)).unwrap();
    let (wanted, at_shelf) = (Selector::Named(ResourceId(0)), Access::Shared(ChannelId(0)));
    assert_eq!((shelf.claims.len(), shelf.claims[0].selector, shelf.claims[0].access), (1, wanted, at_shelf));
    assert_eq!(shelf.claims[0].keep, Retention::Release);
    assert_eq!(shelf.potential, Potential::Scaled { value: 3.0, by: TypeId(0) });
    let clean = |fact, holds| Condition::Fact(FactId(fact), holds);
    assert_eq!(shelf.satisfied, Condition::All(vec![clean(0, true), clean(2, false)]));
    let Condition::All(parts) = &shelf.precondition else { panic!("{:?}", shelf.precondition) };
    assert_eq!(parts[1], Condition::Lies(ObjectId(0), PlaceId(0)));
    assert_eq!(shelf.effects, [EffectTerm::Fact(FactId(0), true), EffectTerm::Fact(FactId(2), false)]);
    assert_eq!(shelf.commands, [], "the robot has no antenna");
    assert_eq!((shelf.takes, shelf.timeout, shelf.retries), (Duration::from_secs(3), Duration::from_secs(5), 1));
    let table = spec.tree.behavior(NodeId(4)).unwrap();
    assert_eq!(table.claims[0].selector, Selector::Named(ResourceId(2)));
    assert_eq!(table.potential, Potential::Scaled { value: 1.0, by: TypeId(2) });
    let rest = spec.tree.behavior(NodeId(8)).unwrap();
    assert_eq!((rest.claims.len(), rest.timeout), (3, Duration::from_secs(60)));
    assert!(rest.claims.iter().all(|claim| claim.access == Access::Exclusive && claim.keep == Retention::Release));
}

/// What is replaced by what, in which file, and the line and words expected.
type Mistake<'a> = (&'a str, &'a str, &'a str, usize, &'a str);

const MISTAKES: &[Mistake<'_>] = &[
    ("mission.yaml", "include: [library.yaml]", "include: [libary.yaml]", 3, "cannot read"),
    ("mission.yaml", "include: [library.yaml]", "include: library.yaml", 3, "instead of a list of paths"),
    (
        "mission.yaml",
        "  scan:\n",
        "  move:\n",
        5,
        "there is a behavior `move` already `move`, `pick` and `place` are those of the paper",
    ),
    (
        "mission.yaml",
        "  scan:\n",
        "  then:\n",
        5,
        "cannot be called `then` what a node of the task can say already: `and`, `or`",
    ),
    ("mission.yaml", "  scan:\n", "  use:\n", 5, "`use`, `name`, `retries`, `backoff`, `timeout`"),
    ("mission.yaml", "  scan:\n", "  rest:\n", 5, "there is a behavior `rest` already each name is declared once"),
    ("mission.yaml", "  scan:\n", "  $scan:\n", 5, "`$scan` stands for an argument"),
    ("mission.yaml", "  twice:\n", "  $twice:\n", 20, "`$twice` stands for an argument"),
    ("mission.yaml", "dusty: true", "$dusty: true", 30, "`$dusty` stands for an argument, and there is none here"),
    ("mission.yaml", "pot: {", "$before: {", 29, "`$before` stands for an argument"),
    ("mission.yaml", "values: {shelf: 3}", "values: {shlef: 3}", 10, "there is no place `shlef` did you mean `shelf`?"),
    ("mission.yaml", "values: {shelf: 3}", "values: {cup: 3}", 10, "there is no place `cup` allowed: `shelf`, `table`"),
    (
        "mission.yaml",
        "{clear: dusty}",
        "{clear: foggy}",
        13,
        "no fact `foggy` add `foggy: false` under `facts:` of the `world:`",
    ),
    (
        "mission.yaml",
        "  facts: {clean shelf: false, clean table: false, dusty: true}\n",
        "",
        13,
        "add `facts: {dusty: false}` under `world:`",
    ),
    ("mission.yaml", "area: place,", "area: plaice,", 6, "did you mean `place`?"),
    (
        "mission.yaml",
        "effort: {type: number, default: 2}",
        "effort: {type: number, default: two}",
        6,
        "`two` instead of",
    ),
    ("mission.yaml", "{type: $with, shared", "{type: $width, shared", 8, "no parameter `width` did you mean `with`?"),
    ("mission.yaml", "{type: $with, shared", "{type: $area, shared", 8, "`$area` is a place, not a type"),
    ("mission.yaml", "{type: $with, shared", "{typ: $with, shared", 8, "no key `typ` did you mean `type`?"),
    ("mission.yaml", "eye: {type: $with,", "eye: {", 8, "does not say what it is"),
    ("mission.yaml", "otherwise: 1}", "otherwise: -1}", 10, "out of bounds"),
    ("mission.yaml", "values: {shelf: 3}", "values: {shelf: .nan}", 10, "`.nan` instead of a number"),
    ("mission.yaml", "{fact: clean $area}", "{fakt: clean $area}", 11, "did you mean `fact`?"),
    ("mission.yaml", "{not_fact: dusty}", "{not_fact: rusty}", 11, "no fact `rusty` did you mean `dusty`?"),
    ("mission.yaml", "{object: cup, at: shelf}", "{object: cub, at: shelf}", 12, "did you mean `cup`?"),
    ("mission.yaml", "claim: other", "claim: othr", 14, "no claim `othr` did you mean `other`?"),
    ("mission.yaml", "maintain: {look_at", "maintain: {drive_to", 14, "cannot be maintained"),
    ("mission.yaml", "claim: other, maintain", "claim: eye, achieve", 14, "moves an arm, which can grasp"),
    ("mission.yaml", "takes: 3 s", "takes: 3 m", 16, "instead of a time"),
    ("mission.yaml", "takes: 3 s", "takes: 6 s", 16, "its timeout is 5 s"),
    (
        "mission.yaml",
        "other: {type: antenna, optional: true}",
        "other: {type: antenna}",
        24,
        "no resource of type `antenna`",
    ),
    (
        "mission.yaml",
        "other: {type: antenna, optional: true}",
        "other: {type: gripper}",
        5,
        "it claims 2 of type `gripper`; the robot has 1",
    ),
    ("mission.yaml", "- {scan: $first,", "- {scan: $fist,", 24, "no parameter `fist` here did you mean `first`?"),
    ("mission.yaml", "first: place, second", "first: resource, second", 24, "`$first` is a resource, not a place"),
    ("mission.yaml", "area: $second, with: wheel", "area: $second, by: wheel", 25, "`scan` has no parameter `by`"),
    ("mission.yaml", "with: wheel", "with: weel", 25, "did you mean `wheel`?"),
    ("mission.yaml", "    - use: {twice: shelf}", "    - use: {thrice: shelf}", 33, "no subtree `thrice`"),
    (
        "mission.yaml",
        "    - use: {twice: shelf}",
        "    - use: {twice: {second: shelf}}",
        33,
        "`twice` lacks its parameter `first`",
    ),
    ("mission.yaml", "    - use: {twice: shelf}", "    - use: {twice: shell}", 33, "did you mean `shelf`?"),
    ("mission.yaml", "- {rest: ,", "- {rest: now,", 35, "nothing: `rest` has no parameters"),
    (
        "mission.yaml",
        "clean table: false,",
        "",
        13,
        "no fact `clean table` add `clean table: false` under `facts:` of the `world:`; the node on line 25",
    ),
    (
        "mission.yaml",
        "- {scan: $first, name: one of $second}",
        "- use: {twice: $first}",
        24,
        "`twice` uses itself: twice → twice",
    ),
    ("library.yaml", "potential: 0.5", "potential: much", 5, "`much` instead of a number"),
    ("library.yaml", "potential: 0.5", "potential: .inf", 5, "out of bounds"),
    ("library.yaml", "claims: all", "claims: everything", 4, "instead of a map of claims"),
    ("library.yaml", "library: small", "libary: small", 1, "did you mean `library`?"),
];

#[test]
fn mistakes_in_declarations_are_found() {
    for (file, old, new, line, words) in MISTAKES {
        let (mut mission, mut library) = (MISSION.to_owned(), LIBRARY.to_owned());
        let text = if *file == "mission.yaml" { &mut mission } else { &mut library };
        assert!(text.contains(old) && !words.is_empty(), "{old}");
        *text = text.replacen(old, new, 1);
        let error = load(&mission, &library).expect_err(new);
        let said = |fault: &super::super::Fault| {
            format!(
                "{}:{}: {fault} {}",
                fault.file(),
                fault.position().map_or(0, |at| at.0),
                fault.help().unwrap_or("")
            )
        };
        let all: Vec<_> = error.faults().iter().map(said).collect();
        let is_there = |said: &String| said.contains(&format!("{file}:{line}: ")) && said.contains(words);
        assert!(all.iter().any(is_there), "`{new}`: expected {file}:{line} and `{words}` in {all:#?}");
    }
}

#[test]
fn what_uses_itself_on_the_way_is_told_once_and_a_bomb_of_uses_is_refused() {
    let head = &MISSION[..MISSION.find("subtrees:").unwrap()];
    let world = &MISSION[MISSION.find("world:").unwrap()..MISSION.find("task:\n  then:").unwrap()];
    let with = |subtrees: &str, task: &str| load(&format!("{head}subtrees:\n{subtrees}{world}task: {task}\n"), LIBRARY);
    let ring = "  a: {task: {and: [{use: b}, {use: a}]}}\n  b: {task: {use: c}}\n  c: {task: {use: a}}\n";
    let error = with(ring, "{use: a}").unwrap_err();
    let said: Vec<_> = error.faults().iter().map(super::super::Fault::message).collect();
    assert_eq!(said, ["`a` uses itself: a → a"]);
    let bomb: String =
        (0..20).map(|n| format!("  u{n}: {{task: {{and: [{{use: u{0}}}, {{use: u{0}}}]}}}}\n", n + 1)).collect();
    let error = with(&format!("{bomb}  u20: {{task: {{rest: }}}}\n"), "{use: u0}").unwrap_err();
    assert!(error.faults()[0].message().contains("more than 100000 nodes"), "{error:?}");
    let ladder: String = (0..80).map(|n| format!("  u{n}: {{task: {{and: [{{use: u{}}}]}}}}\n", n + 1)).collect();
    let error = with(&format!("{ladder}  u80: {{task: {{rest: }}}}\n"), "{use: u0}").unwrap_err();
    assert!(error.faults()[0].message().contains("more than 64 nodes one in another"), "{error:?}");
}

#[test]
fn a_library_may_speak_of_what_a_mission_does_not_have() {
    let said = |values: &str| {
        let library = format!(
            "library: small\nbehaviors:\n  rest: {{claims: all, potential: 0.5}}\n  lay: {{parameters: {{what: object}}, \
             potential: {{table: {{by: $what, values: {values}, otherwise: 1}}}}}}\n"
        );
        let loaded = load_mission(&written(MISSION, &library), PATH.as_ref(), None, &[]).expect("it is legal");
        let said = loaded.warnings.iter().map(|fault| format!("{fault}; {}", fault.help().unwrap_or_default()));
        said.filter(|said| !said.contains("it can never run")).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(said("{cup: 2, bowl: 3}"), "");
    assert_eq!(said("{cub: 2, bowl: 3}"), "cub: there is no object `cub`; did you mean `cup`?");
}

#[test]
fn a_library_is_checked_by_itself() {
    let mut files = written(MISSION, LIBRARY);
    let path = Path::new("library.yaml");
    let Checked::Library(names, _) = check(&files, path, &[]).unwrap() else { panic!("it is a library") };
    assert_eq!(names, ["rest"]);
    files.insert(path, format!("{LIBRARY}subtrees:\n  a:\n    parameters: {{x: number}}\n    task: {{move: $x}}\n"));
    let error = check(&files, path, &[]).unwrap_err();
    assert_eq!(error.faults()[0].message(), "`$x` is a number, not a place");
}

#[test]
fn an_object_stands_for_its_place_in_a_subtree_too() {
    let place_of = |task: &str| {
        let bring = "  bring:\n    parameters: {what: object}\n    task: {then: [{move: $what}, {pick: $what}]}\n";
        let text = MISSION.replace("subtrees:\n", &format!("subtrees:\n{bring}"));
        let task_at = text.find("task:\n  then").unwrap();
        load(&format!("{}task: {task}\n", &text[..task_at]), LIBRARY).unwrap().tree.behavior(NodeId(2)).unwrap().clone()
    };
    let (used, plain) = (place_of("{use: {bring: cup}}"), place_of("{then: [{move: cup}, {pick: cup}]}"));
    assert_eq!(used, plain);
    assert_eq!(used.elsewhere.map(|elsewhere| elsewhere.object), Some(ObjectId(0)));
}

#[test]
fn a_resource_can_be_claimed_while_it_is_empty() {
    let one =
        MISSION.replace("eye: {type: $with, shared: at $area}", "eye: {resource: hand, reaches: pot, keep: physical}");
    let one = one.replace(", with: {type: type, default: gripper}", "").replace("scale_by: $with", "scale_by: gripper");
    let one = one
        .replace(", with: wheel", "")
        .replace("    - {use: {twice: {first: table, second: shelf}}, name: again}\n", "");
    let one = one.replace("      and:\n", "      or:\n");
    let spec = load(&one, LIBRARY).unwrap_or_else(|error| panic!("{:?}", error.faults()));
    let scan = spec.tree.behavior(NodeId(3)).unwrap();
    assert_eq!(scan.claims[0].selector, Selector::Empty { resource: ResourceId(0), reaches: Some(ObjectId(1)) });
    assert_eq!(scan.claims[0].keep, Retention::Physical(Access::Exclusive));
}

#[test]
fn a_table_of_commands_fits_its_controllers() {
    let grasp = MISSION.replace("claim: other, maintain: {look_at: $area}", "claim: eye, achieve: {grasp: cup}");
    let grasp = grasp.replace("with: wheel", "with: gripper");
    let spec = load(&grasp, LIBRARY).unwrap_or_else(|error| panic!("{:?}", error.faults()));
    let command = &spec.tree.behavior(NodeId(3)).unwrap().commands[0];
    assert_eq!((command.claim, command.mode, &command.task), (0, Mode::Achieve, &Task::Grasp(ObjectId(0))));
}

/// What is said of a kind and a task with the robot of the missions.
fn check_kind(kind: &str, task: &str, expected: Option<&str>) {
    let head = &super::GOOD[..super::GOOD.find("task:").unwrap()];
    let loaded = super::load(&format!("{head}behaviors:\n  {kind}\ntask: {task}\n"), super::ROBOT);
    let said = loaded.err().map(|error| error.faults().iter().map(ToString::to_string).collect::<Vec<_>>().join("; "));
    match (said, expected) {
        (None, None) => {}
        (Some(said), Some(expected)) => assert!(said.contains(expected), "{kind}: {said}"),
        (said, expected) => panic!("{kind}: expected {expected:?}, found {said:?}"),
    }
}

#[test]
fn what_a_behavior_could_never_do_is_refused() {
    let think = "think: {claims: {b: {type: base}}, potential: 1, takes: 10 s}";
    check_kind(think, "{think: , timeout: 11 s}", None);
    check_kind(think, "{think: , timeout: 2 s}", Some("timeout: it takes 10 s, and its timeout is 2 s"));
    let twice = "go: {claims: {b: {type: base}}, potential: 1, commands: \
                 [{claim: b, achieve: {drive_to: shelf}}, {claim: b, maintain: stand}]}";
    check_kind(twice, "{go: }", Some("maintain: `b` has a command already"));
    let by_start = "see: {parameters: {o: {type: object, default: $start}}, claims: {}, potential: 1, label: see $o}";
    let still = "wait: {claims: {h: {resource: hand}}, potential: 1, commands: [{claim: h, maintain: stand}]}";
    check_kind(still, "wait", None);
    let drive = still.replace("maintain: stand", "achieve: {drive_to: shelf}");
    check_kind(&drive, "wait", Some("achieve: controller `arm` moves an arm, which can grasp, put, stand"));
    check_kind(&still.replace(", commands: [{claim: h, maintain: stand}]", ""), "wait", None);
    check_kind(by_start, "{see: cup}", Some("default: `$start` cannot be the default of an object"));
    let by_other = "see: {parameters: {p: place, q: {type: place, default: $p}}, claims: {}, potential: 1, \
                    goal: [{at: $p}, {at: $q}]}";
    check_kind(by_other, "{see: {p: shelf, q: shelf}}", Some("default: `$p` cannot be the default of a place"));
}

#[test]
fn a_kind_that_needs_nothing_is_a_node_by_its_word() {
    let rest = "rest: {potential: 1}";
    check_kind(rest, "rest", None);
    check_kind(rest, "{then: [rest, {move: shelf}, rest]}", None);
    check_kind("rest: {parameters: {p: {type: number, default: 1}}, potential: $p}", "{or: [rest]}", None);
    check_kind(
        "rest: {parameters: {p: number}, potential: $p}",
        "{or: [rest]}",
        Some("`rest` lacks its parameter `p`"),
    );
    check_kind("rest: {potential: much}", "{or: [rest]}", Some("potential: found `much`"));
    check_kind(rest, "{and: [{use: go}, go]}\nsubtrees: {go: {task: rest}}", Some("there is no kind of node `go`"));
}

#[test]
fn defaults_of_subtrees_are_plain() {
    for default in ["$before", "[shelf, table]"] {
        let entry = format!("go: {{parameters: {{to: {{type: place, default: {default}}}}}, task: {{move: $to}}}}");
        let head = &super::GOOD[..super::GOOD.find("task:").unwrap()];
        let error = super::load(&format!("{head}subtrees:\n  {entry}\ntask: {{use: go}}\n"), super::ROBOT).unwrap_err();
        let said: Vec<_> = error.faults().iter().map(ToString::to_string).collect();
        assert_eq!(said, ["default: a subtree has one plain value as a default"]);
    }
}

#[test]
fn what_takes_can_hold() {
    let robot = super::ROBOT.replace("{type: base}", "{type: base, controller: wheels}").replace(
        "controllers:\n",
        "controllers:\n  wheels:\n    base: {speed: 1, acceleration: 1, turn_speed: 1, turn_acceleration: 1}\n",
    );
    let head = &super::GOOD[..super::GOOD.find("task:").unwrap()];
    let kind = "haul: {claims: {b: {type: base}}, potential: 1, effects: [{taken: {object: cup, by: b}}]}";
    let error = super::load(&format!("{head}behaviors:\n  {kind}\ntask: {{haul: }}\n"), &robot).unwrap_err();
    assert!(error.faults()[0].message().contains("cannot hold what is taken"), "{error:?}");
}

#[test]
fn what_holds_is_commanded_however_it_is_named() {
    for (claim, hand) in [("type: $hand", "type"), ("resource: $hand", "resource"), ("type: gripper", "text")] {
        let put = format!(
            "  rest:\n    label: rest $hand\n    parameters: {{hand: {hand}}}\n    claims: {{hand: {{{claim}, holds: pot}}}}\n    \
             potential: 1\n    commands: [{{claim: hand, achieve: {{put: {{object: pot, at: table}}}}}}]\n"
        );
        let library = format!("library: small\nbehaviors:\n{put}");
        let value = if hand == "resource" { "hand" } else { "gripper" };
        let mission = MISSION.replace("- {rest: , timeout: 1 min}", &format!("- rest: {value}"));
        let spec = load(&mission, &library).unwrap_or_else(|error| panic!("{:?}", error.faults()));
        let commands = &spec.tree.behavior(NodeId(8)).unwrap().commands;
        assert_eq!(commands.len(), 1, "{claim}");
    }
}
