//! What a mission must come to, seen before it runs.

use super::super::{Fault, load_mission};
use super::{GOOD, PATH, robot, written};

/// What is said of a task for a robot with so many hands.
fn said(hands: usize, task: &str) -> Vec<String> {
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    let declared = "\
behaviors:
  open: {claims: all, potential: 1, effects: [{set: door_open}]}
  close: {claims: all, potential: 1, effects: [{clear: door_open}]}
  enter: {claims: all, potential: 1, precondition: [{not_fact: door_open}]}
  stay: {claims: {hand: {type: gripper}}, potential: 1, precondition: [{at: shelf}]}
  hold: {claims: {base: {type: base, shared: at shelf}}, potential: 1, precondition: [{at: shelf}]}
  scan: {claims: {hand: {type: gripper}}, potential: {constant: 2, scale_by: griper}}
  guard: {claims: {base: {type: base, keep: physical}}, potential: 1}
  watch: {claims: {base: {type: base, shared: watch, keep: physical}}, potential: 1}
  wave: {claims: {hand: {type: gripper}}, potential: 1}
  carry: {claims: {base: {type: base}, hand: {type: gripper, keep: physical}}, potential: 1}
  brace: {claims: {base: {type: base, keep: physical}, one: {type: gripper}, two: {type: gripper}}, potential: 1}
";
    let files = written(format!("{head}{declared}task:\n  {task}\n"), &robot(hands));
    let faults = match load_mission(&files, PATH.as_ref(), None, &[]) {
        Ok(loaded) => loaded.warnings,
        Err(error) => error.faults().to_vec(),
    };
    let kind = |fault: &Fault| if fault.is_warning() { "warning" } else { "error" };
    faults.iter().map(|fault| format!("{} {fault}", kind(fault))).collect()
}

/// Most tasks here do not drive, and that is told by itself.
const NO_DRIVE: &str = "it can never run: the base does not stand at";

fn check(hands: usize, task: &str, expected: &[&str]) {
    let mut said = said(hands, task);
    said.retain(|said| !said.contains(NO_DRIVE));
    assert_eq!(said.len(), expected.len(), "{task}: {said:#?}");
    for (said, expected) in said.iter().zip(expected) {
        assert!(said.contains(expected), "{task}: {said} without `{expected}`");
    }
}

#[test]
fn moves_that_nobody_inherits() {
    let loose = "warning move to shelf: nobody inherits what it keeps";
    check(2, "and: [{move: shelf}, {close: }]", &[loose]);
    check(2, "or: [{move: shelf}, {close: }]", &[loose]);
    check(2, "then: [{close: }, {move: shelf}]", &[]);
    check(2, "then: [{or: [{move: shelf}, {move: table}]}, {pick: cup}]", &[]);
    check(2, "move: shelf", &[]);
}

#[test]
fn hands_that_must_run_out() {
    let out = |needed, has| format!("it must run out: {needed} of `gripper` would be in use, and the robot has {has}");
    let [three, two] = [out(3, 2), "`pick cup` and `pick pot` can only ever exclude each other".to_owned()];
    let one = "it must run out: 2 of `hand` would be in use, and the robot has 1";
    check(2, "then: [{move: shelf}, {pick: cup}, {pick: pot}, {move: table}, {place: cup}, {place: pot}]", &[]);
    check(2, "then: [{move: shelf}, {pick: cup}, {pick: pot}, {pick: cup}]", &[&three]);
    check(2, "and: [{pick: cup}, {pick: pot}, {then: [{pick: cup}, {place: {object: cup, at: table}}]}]", &[]);
    check(2, "and: [{pick: cup}, {pick: pot}, {then: [{pick: cup}, {close: }]}]", &[&three]);
    check(1, "then: [{move: shelf}, {pick: cup}, {pick: pot}]", &[one]);
    check(1, "then: [{move: shelf}, {pick: cup}, {place: {object: cup, at: table}}, {pick: pot}]", &[]);
    check(1, "and: [{pick: cup}, {pick: pot}]", &[&two]);
    check(1, "and: [{then: [{pick: cup}, {place: {object: cup, at: table}}]}, {pick: pot}]", &[]);
    check(1, "or: [{pick: cup}, {pick: pot}]", &[]);
    check(1, "then: [{or: [{pick: cup}, {close: }]}, {pick: pot}]", &[]);
    check(2, "and: [{guard: }, {guard: }]", &["error and: `guard` and `guard #2` can only ever exclude each other"]);
    let beside = "and: [{then: [{move: shelf}, {pick: cup}, {place: {object: cup, at: shelf}}]}, {guard: }, {then: [{close: }, {guard: }]}]";
    check(2, beside, &["`guard` and `guard #2` can only ever exclude each other"]);
}

#[test]
fn what_is_kept_serves_again_where_it_is_inherited_or_shared() {
    check(2, "then: [{guard: }, {guard: }, {guard: }]", &[]);
    check(2, "and: [{watch: }, {watch: }]", &[]);
    check(1, "then: [{move: shelf}, {pick: cup}, {wave: }]", &[]);
}

#[test]
fn behaviors_that_exclude_each_other_in_every_order() {
    let stuck =
        "warning and: it can be finished in no order: `brace` needs 3 at once, and in the end hand is kept by `carry`";
    check(2, "and: [{carry: }, {brace: }]", &[stuck]);
    check(3, "and: [{carry: }, {brace: }]", &[]);
    check(2, "or: [{carry: }, {brace: }]", &[]);
    check(2, "and: [{wave: }, {brace: }]", &[]);
    check(2, "then: [{carry: }, {brace: }]", &[]);
}

#[test]
fn facts_that_nobody_brings() {
    check(2, "enter:", &["warning enter: it can never run: no behavior that can run clears \"door_open\""]);
    check(2, "then: [{close: }, {enter: }]", &[]);
    check(2, "then: [{open: }, {enter: }]", &["no behavior that can run clears \"door_open\""]);
}

#[test]
fn what_nothing_makes_so() {
    assert_eq!(said(2, "pick: cup"), ["warning pick cup: it can never run: the base does not stand at shelf"]);
    assert_eq!(said(2, "and: [{pick: cup}, {then: [{move: shelf}, {close: }]}]"), [] as [&str; 0]);
    let placed = "warning place cup: it can never run: cup is not held by this branch of the task";
    check(2, "then: [{move: table}, {place: {object: cup, at: table}}]", &[placed]);
}

#[test]
fn a_type_that_scales_nothing() {
    let nothing = "warning scale_by: the robot has no resource of type `griper`, so nothing is scaled";
    check(2, "then: [{scan: }, {scan: }]", &[nothing]);
}

#[test]
fn a_base_that_may_leave() {
    let leaves = "warning stay: it must stand somewhere and does not claim the base";
    check(2, "then: [{move: shelf}, {stay: }]", &[leaves]);
    check(2, "then: [{close: }, {stay: }]", &[]);
    check(2, "then: [{move: shelf}, {hold: }]", &[]);
}

#[test]
fn a_hand_that_takes_and_does_not_reach() {
    let said = |robot: &str, surface: &str| {
        let table = format!("table: {{stand: [3, 2], surface: {surface}}}");
        let text = GOOD.replace("table: {stand: [3, 2]}", &table);
        let loaded = load_mission(&written(text, robot), PATH.as_ref(), None, &[]).expect("it is legal");
        loaded.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(said(&robot(1), "[0.5, 0, 0.75]"), "");
    assert_eq!(
        said(&robot(1), "[1.5, 0, 0.75]"),
        "pick cup: it can never run: nothing that could take cup reaches what place cup asks of it later; \
         place cup: it can never run: no hand that can take cup reaches table"
    );
    let other = |robot: String| {
        robot.replacen("shoulder: [0, 0, 0.8], tuck: [0.3, 0, 0.9]", "shoulder: [1, 0, 0.8], tuck: [1, 0, 0.9]", 1)
    };
    assert_eq!(said(&other(robot(2)), "[1.5, 0, 0.75]"), "");
    assert_eq!(said(&other(robot(2)), "[-0.7, 0, 0.75]"), "");
}
