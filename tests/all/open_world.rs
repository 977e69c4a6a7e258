//! Whole missions of an open world, in simulation and with processes: what can never run, what takes too long, what others
//! did, what is waited for, what lies elsewhere now. The situations are those of bug reports about other executives.

use std::sync::Arc;

use ambidex::model::{Location, MissionEnd, MissionSpec, Record};
use ambidex::tree::Settings;

use rustix::process::Signal;

use crate::fixtures::{history, load, mission, simulate_failures, simulate_wrongs, steps};
use crate::home::{Home, flat};

/// A mission with failures, its end and its steps; every decision follows from its log.
fn told(home: &Home, objects_and_task: &str, failures: &str) -> (Arc<MissionSpec>, MissionEnd, String) {
    let mission = load(&home.write("mission.yaml", &mission(objects_and_task)));
    let (end, records) = simulate_wrongs(&mission, &Settings::default(), failures);
    let steps = steps(&mission, &records);
    (mission, end, steps)
}

const DOOR: &str = "facts: {door open: false, entered: false}
behaviors:
  enter:
    claims: {base: {type: base}}
    potential: 3
    precondition: [{fact: door open}]
    effects: [{set: entered}]
    takes: 2 s
  open: {claims: {hand: {type: gripper}}, potential: 1, effects: [{set: door open}], takes: 1 s}
";

fn door(outside: bool, task: &str) -> String {
    let (facts, behaviors) = DOOR.split_once('\n').expect("two lines");
    let facts = if outside { facts.replace("door open: false", "door open: {outside: true}") } else { facts.into() };
    format!("{facts}\n{behaviors}task:\n  {task}")
}

#[test]
fn a_precondition_that_nothing_makes_true() {
    let home = Home::new();
    let (_, end, steps) = told(&home, &door(false, "then: [{move: table}, {enter: }]"), "");
    assert_eq!((matches!(end, MissionEnd::Failed(_)), steps.as_str()), (true, ""), "it fails before the robot moves");
    let path = home.write("never.yaml", &mission(&door(false, "then: [{move: table}, {enter: }]")));
    let finished = home.start(["simulate".as_ref(), path.as_os_str()]).ends(1);
    let said = flat(&finished.stderr);
    assert!(said.contains("enter can never run: \"door open\" does not hold"), "{said}");
    assert!(!said.contains("goal is met"), "only causes are told: {said}");
    let checked = home.start(["check".as_ref(), path.as_os_str()]).ends(0);
    assert!(flat(&checked.stderr).contains("no behavior that can run sets \"door open\""), "{}", checked.stderr);
    // Whoever makes it true, wherever in the task.
    let (_, end, steps) = told(&home, &door(false, "and: [{then: [{move: table}, {enter: }]}, {open: }]"), "");
    assert_eq!((end, steps.as_str()), (MissionEnd::Done, "move to table + open, enter"));
}

#[test]
fn a_fact_that_others_set_is_waited_for() {
    let home = Home::new();
    let task = door(true, "then: [{move: table}, {enter: }]");
    let (_, end, steps) = told(&home, &task, "\n  - {at: 20 s, set: door open}");
    assert_eq!((end, steps.as_str()), (MissionEnd::Done, "move to table, enter"));
    // In a simulation in which nothing comes any more that is a stall, and it says what it waits for.
    let (_, end, _) = told(&home, &task, "");
    assert_eq!(end, MissionEnd::Stalled);
    let path = home.write("waits.yaml", &mission(&task));
    let mut run = home.start(["run".as_ref(), path.as_os_str(), "--speed".as_ref(), "20".as_ref()]);
    run.says("nothing can go on before others change \"door open\"");
    run.signal(Signal::INT);
    let finished = run.ends(130);
    assert!(finished.stderr.contains("canceled"), "{}", finished.stderr);
    home.is_empty();
}

#[test]
fn any_two_of_three_parts_with_one_arm() {
    let home = Home::new();
    let way = |part: u32| {
        format!("{{then: [{{move: shelf}}, {{pick: part {part}}}, {{move: table}}, {{place: part {part}}}]}}")
    };
    let any = format!("{{or: [{}, {}, {}]}}", way(1), way(2), way(3));
    let parts = "objects: {part 1: {at: shelf}, part 2: {at: shelf}, part 3: {at: shelf}}";
    let (mission, end, _) = told(&home, &format!("{parts}\ntask: {{and: [{any}, {any}]}}"), "");
    assert_eq!(end, MissionEnd::Done);
    let (_, records) = simulate_failures(&mission, &Default::default());
    let picks = records.iter().filter_map(|record| match record {
        Record::Decided { granted, .. } => {
            Some(granted.iter().map(|grant| mission.names.node(grant.leaf()).to_owned()))
        }
        _ => None,
    });
    let picks: Vec<_> = picks.flatten().filter(|name| name.starts_with("pick")).collect();
    assert_eq!(picks.len(), 2, "{picks:?}");
    let history = history(&records);
    let world = history.state_of_run().world();
    let brought = world.objects.iter().filter(|at| **at == Location::At(1.into())).count();
    assert_eq!(brought, 2, "{picks:?}: two parts and not one twice");
}

#[test]
fn a_sequence_that_must_end_within_some_seconds() {
    let home = Home::new();
    let task = |limits: &str| {
        format!(
            "objects: {{cup: {{at: shelf}}}}\ntask:\n  {{name: quick, {limits}, then: [{{move: shelf}}, {{move: table}}]}}"
        )
    };
    let (mission, end, steps) = told(&home, &task("timeout: 3 s"), "");
    let MissionEnd::Failed(node) = end else { panic!("{end:?}") };
    assert_eq!((mission.names.node(node), steps.as_str()), ("quick", "move to shelf"));
    let path = home.write("late.yaml", &super::fixtures::mission(&task("timeout: 3 s")));
    let log = home.path("late.jsonl");
    let args = ["run".as_ref(), path.as_os_str(), "--speed".as_ref(), "10".as_ref(), "--log".as_ref(), log.as_os_str()];
    let finished = home.start(args).ends(1);
    assert!(finished.stderr.contains("took too long"), "{}", finished.stderr);
    let verified = home.start(["verify".as_ref(), log.as_os_str()]).ends(0);
    assert!(verified.stdout.starts_with("same: "), "{}", verified.stdout);
    // Tried again it has its time anew.
    let (_, end, steps) = told(&home, &task("timeout: 3 s, retries: 1"), "");
    assert!(matches!(end, MissionEnd::Failed(_)));
    assert_eq!(steps, "move to shelf, move to table", "it stands near enough to the shelf when it is canceled");
    let (_, end, _) = told(&home, &task("timeout: 1 min"), "");
    assert_eq!(end, MissionEnd::Done);
    home.is_empty();
}

#[test]
fn a_dropped_object_is_fetched_from_where_it_lies() {
    let home = Home::new();
    let task = |to: &str| {
        format!(
            "objects: {{cup: {{at: shelf}}}}\ntask: {{then: [{{move: {to}}}, {{pick: cup}}, {{move: table}}, {{place: cup}}]}}"
        )
    };
    let (_, end, steps) = told(&home, &task("cup"), "\n  - {behavior: move to table, drops: cup}");
    assert_eq!(end, MissionEnd::Done);
    assert_eq!(steps, "move to cup, pick cup, move to table, move to cup, pick cup, move to table, place cup");
    // What the task tells of it counts wherever the object lies.
    let once = task("cup").replace("{move: cup}", "{move: cup, retries: 0}");
    let failures =
        "\n  - {behavior: move to cup, hangs: true}\n  - {at: 100 ms, lose: base}\n  - {at: 1 s, return: base}";
    let (mission, end, steps) = told(&home, &once, failures);
    let MissionEnd::Failed(node) = end else { panic!("{end:?}") };
    assert_eq!((mission.names.node(node), steps.as_str()), ("move to cup", "move to cup"));
    // Driven to a fixed place it says what it lacks, unless others have brought it where it was to go.
    let moved = "\n  - {at: 1 s, lies: {object: cup, at: table}}";
    let (_, end, steps) = told(&home, &task("shelf"), moved);
    assert_eq!((end, steps.as_str()), (MissionEnd::Done, "move to shelf"), "others have done it");
    let elsewhere = task("shelf").replace("{place: cup}", "{move: shelf}, {place: cup}");
    let (mission, end, _) = told(&home, &elsewhere, moved);
    let MissionEnd::Failed(node) = end else { panic!("{end:?}") };
    assert_eq!(mission.names.node(node), "pick cup");
}

#[test]
fn an_or_leaves_the_way_in_which_nothing_goes_on() {
    let home = Home::new();
    // What it holds goes on with the other way.
    let stuck = "{then: [{move: shelf}, {pick: cup}, {enter: }]}";
    let task = door(true, &format!("or: [{stuck}, {{then: [{{move: table}}, {{place: cup}}]}}]"));
    let task = task.replacen('\n', "\n  objects: {cup: {at: shelf}}\n", 1);
    let (_, end, steps) = told(&home, &task, "");
    assert_eq!((end, steps.as_str()), (MissionEnd::Done, "move to shelf, pick cup, move to table, place cup"));
    let path = home.write("leaves.yaml", &mission(&task));
    let finished = home.start(["run".as_ref(), path.as_os_str(), "--speed".as_ref(), "20".as_ref()]).ends(0);
    assert!(finished.stderr.contains("in which nothing can go on"), "{}", finished.stderr);
    home.is_empty();
}
