//! What can never run, ways that are left, task nodes that are tried again, and work that others did (`semantics` 2, 6).

use std::time::Duration;

use ambidex::model::{
    BehaviorSpec, Change, Condition, EffectTerm, FactId, Limits, Location, MissionSpec, ObjectId, PlaceId, Reason,
    ResourceId, Selector,
};
use ambidex::tree::Settings;

use super::Event::{self, Fails, Ok, Wait, World};
use super::words::*;
use super::{FREE, Run, and, leaf, or, robot, then};
use crate::support::{self, Tree, WING, blank, claim, fact, mission};

/// Nobody but behaviors sets facts here.
fn closed(tree: &Tree) -> MissionSpec {
    let objects = [0, 0, 1].map(|place| Location::At(PlaceId(place))).to_vec();
    mission(robot(2, 2), PLACES, objects, vec![false; 4], tree)
}

fn check(tree: &Tree, events: &[Event], expected: &str) -> Run {
    check_mission(closed(tree), events, expected)
}

fn check_mission(mission: MissionSpec, events: &[Event], expected: &str) -> Run {
    let run = Run::new(mission, Settings::default(), events);
    assert_eq!(run.steps(), expected);
    run
}

/// A tree of which one node has limits.
fn limited(tree: &Tree, name: &str, limits: Limits) -> MissionSpec {
    let mut mission = closed(tree);
    let node = mission.names.nodes.iter().position(|other| other == name).expect("it is there");
    mission.tree.limits.insert(node.into(), limits);
    mission
}

fn setting(spec: BehaviorSpec, fact: u32) -> BehaviorSpec {
    BehaviorSpec { effects: vec![EffectTerm::Fact(FactId(fact), true)], ..spec }
}

fn stuck() -> Tree {
    leaf("stuck", needing(blank("stuck"), 0))
}

/// Fails for good at once.
fn once(name: &str) -> Tree {
    leaf(name, BehaviorSpec { retries: 0, ..blank(name) })
}

const RETRY: Limits = Limits { timeout: None, retries: 1, backoff: Duration::ZERO };

#[test]
fn what_nothing_makes_so_fails_before_anything_runs() {
    let run = check(&then([free("a"), stuck()]), &[], "never stuck, failed at stuck");
    assert_eq!(run.reason("stuck"), Some(Reason::Fact { fact: FactId(0), holds: true }));
    // Somebody makes it so, wherever he stands, even behind it: order does not matter.
    check(&then([stuck(), leaf("sets", setting(blank("sets"), 0))]), &[], "stalled");
    // Not one who could never run himself.
    let sets = BehaviorSpec { precondition: Condition::Fact(FactId(1), true), ..setting(blank("sets"), 0) };
    check(&and([free("a"), stuck(), leaf("sets", sets)]), &[Ok("a")], "never stuck, never sets, a, failed at stuck");
    // Two who need each other make nothing so.
    let each = |name: &str, needs, makes| leaf(name, needing(setting(blank("each"), makes), needs));
    check(&and([each("x", 0, 1), each("y", 1, 0)]), &[], "never x, never y, failed at x");
    // A goal that is met needs no precondition, and one that others reach.
    let met = leaf("met", needing(fact(FactId(2)), 0));
    check(&and([met, leaf("sets", setting(blank("sets"), 2))]), &[Ok("sets")], "sets, done");
}

#[test]
fn what_the_robot_lacks_fails_before_anything_runs() {
    let wings = BehaviorSpec { claims: vec![claim(Selector::Any(WING), EXCLUSIVE, FREE)], ..blank("fly") };
    let run = check(&then([free("a"), leaf("fly", wings)]), &[], "never fly, failed at fly");
    assert_eq!(run.reason("fly"), Some(Reason::Missing { of: WING }));
    let both = [0, 1, 0].map(|gripper| claim(Selector::Named(ResourceId(gripper)), EXCLUSIVE, FREE));
    let run = check(&leaf("it", BehaviorSpec { claims: both.to_vec(), ..blank("it") }), &[], "never it, failed at it");
    assert!(matches!(run.reason("it"), Some(Reason::TooFew { wanted: 3, free: 2, .. })));
}

#[test]
fn what_becomes_impossible_fails_then() {
    // The object is nowhere any more, and nobody puts it there again.
    let carry = then([go("move a", 0), grab("pick 0", 0, 0)]);
    let lost = World(Change::Object(ObjectId(0), Location::Unknown));
    let gone = World(Change::Object(ObjectId(0), Location::At(PlaceId(3))));
    check(&carry, &[lost], "move a, never pick 0");
    check(&carry, &[lost, Ok("move a")], "move a, never pick 0, failed at pick 0");
    let run = check(&carry, &[Ok("move a"), gone], "move a, pick 0");
    assert_eq!(run.reason("pick 0"), None);
    // What holds since somebody did it is lost with what undoes it.
    let clears = BehaviorSpec { effects: vec![EffectTerm::Fact(FactId(0), false)], ..blank("clears") };
    let tree = and([
        then([leaf("sets", setting(blank("sets"), 0)), free("between")]),
        then([leaf("clears", clears), stuck()]),
    ]);
    let events = [Ok("sets"), Ok("between"), Ok("clears")];
    check(&tree, &events, "sets + clears, between, never stuck, failed at stuck");
}

#[test]
fn an_or_never_chooses_a_way_that_cannot_be_gone() {
    let dead = || leaf("dead", with_potential(needing(blank("dead"), 0), 9.0));
    check(&or([then([free("a"), dead()]), free("b")]), &[Ok("b")], "never dead, b, done");
    check(
        &or([then([free("a"), dead()]), then([free("b"), stuck()])]),
        &[],
        "never dead, never stuck, failed at stuck",
    );
    // The way that it has chosen fails, and the next one inherits.
    let lost = World(Change::Object(ObjectId(1), Location::Unknown));
    let one = then([go("move a", 0), grab("pick 0", 0, 0), free("between"), grab("pick 1", 1, 0)]);
    let tree = or([one, then([go("move b", 1), drop_at("place 0", 0, 1, 0)])]);
    let events = [Ok("move a"), Ok("pick 0"), lost, Event::Ends("between"), Ok("move b")];
    let steps = "move a, pick 0, between, never pick 1, move b, place 0";
    let run = check(&tree, &events, steps);
    assert!(run.table().contains("gripper#1: place 0"), "{}", run.table());
}

#[test]
fn an_or_leaves_a_way_in_which_nothing_goes_on() {
    let open = |tree: &Tree| MissionSpec {
        world: ambidex::model::WorldSpec { outside: vec![true; 4], ..closed(tree).world },
        ..closed(tree)
    };
    let way = || then([leaf("a", with_potential(blank("a"), 9.0)), stuck()]);
    check_mission(open(&or([way(), free("b")])), &[Ok("a"), Ok("b")], "a, leaves then2, b, done");
    // What is done there stays done, and it may be chosen again.
    let holds = World(Change::Fact(FactId(0), true));
    let tree = or([way(), leaf("b", needing(blank("b"), 1))]);
    check_mission(open(&tree), &[Ok("a")], "a, leaves then2, waits");
    check_mission(open(&tree), &[Ok("a"), holds], "a, leaves then2, stuck");
    check_mission(open(&tree), &[Ok("a"), holds, Ok("stuck")], "a, leaves then2, stuck, done");
    // Without another way it stays, and says what it lacks; once for each way in each progress.
    check_mission(open(&or([way()])), &[Ok("a")], "a, waits");
    // A full gripper goes to the OR, whose next way inherits it.
    let carry = then([go("move a", 0), grab("pick 0", 0, 0), stuck()]);
    let tree = or([carry, then([go("move b", 1), drop_at("place 0", 0, 1, 0)])]);
    let events = [Ok("move a"), Ok("pick 0"), Ok("move b")];
    let run = check_mission(open(&tree), &events, "move a, pick 0, leaves then2, move b, place 0");
    assert!(run.table().contains("gripper#1: place 0"), "{}", run.table());
    // The last OR in tree order comes first.
    let inner = or([way(), free("c")]);
    let tree = or([then([inner, stuck2()]), free("b")]);
    let events = [Ok("a"), Ok("c"), Ok("b")];
    check_mission(open(&tree), &events, "a, leaves then4, c, leaves then2, b, done");
}

fn stuck2() -> Tree {
    leaf("stuck2", needing(blank("stuck2"), 1))
}

#[test]
fn a_task_node_is_tried_again() {
    // A THEN begins behind what was done and still holds; drives never count.
    let carry = then([go("move a", 0), grab("pick 0", 0, 0), go("move b", 1), once("fragile"), free("end")]);
    let before = [Ok("move a"), Ok("pick 0"), Ok("move b"), Fails("fragile")];
    let steps = "move a, pick 0, move b, fragile, again then1";
    let run = check_mission(limited(&carry, "then1", RETRY), &before, &format!("{steps}, fragile"));
    assert!(run.table().contains("gripper#1: then1"), "{}", run.table());
    let events = [&before[..], &[Fails("fragile")]].concat();
    check_mission(limited(&carry, "then1", RETRY), &events, &format!("{steps}, fragile, failed at fragile"));
    // An AND keeps its complete children and cancels the others.
    let both = and([free("a"), once("fragile"), then([free("b"), free("c")])]);
    let events = [Ok("a"), Fails("fragile"), Ok("b"), Ok("fragile")];
    check_mission(limited(&both, "and1", RETRY), &events, "a + fragile + b, again and1, fragile + b");
    // An OR has all its ways again.
    let either = or([once("x"), once("y")]);
    let events = [Fails("x"), Fails("y"), Fails("x"), Ok("y")];
    check_mission(limited(&either, "or1", RETRY), &events, "x, y, again or1, x, y, done");
    // Leaves begin anew, with all their retries.
    let twice = then([leaf("twice", BehaviorSpec { retries: 1, ..blank("twice") })]);
    let events = [Fails("twice"); 4];
    let steps = "twice, twice, again then1, twice, twice, failed at twice";
    check_mission(limited(&twice, "then1", RETRY), &events, steps);
    // What can never run is not tried again.
    check_mission(limited(&then([stuck()]), "then1", RETRY), &[], "never stuck, failed at stuck");
    // It waits before that.
    let wait = Limits { backoff: Duration::from_secs(2), ..RETRY };
    let run = check_mission(limited(&then([once("x")]), "then1", wait), &[Fails("x")], "x, again then1, x");
    assert_eq!(run.driver.now.seconds(), 3.0);
}

#[test]
fn a_task_node_takes_only_so_long() {
    let timeout = |seconds, retries| Limits { timeout: Some(Duration::from_secs(seconds)), retries, ..RETRY };
    let both = || then([free("a"), free("b")]);
    // From the first grant below it; what runs is canceled first.
    let run = check_mission(limited(&both(), "then1", timeout(5, 0)), &[Ok("a"), Wait(10)], "a, b, late then1");
    assert_eq!(run.reason("a"), Some(Reason::OutOfTime { node: run.node("then1") }));
    check_mission(
        limited(&both(), "then1", timeout(5, 0)),
        &[Ok("a"), Wait(10), Event::Ends("b")],
        "a, b, late then1, failed at then1",
    );
    // Done in time.
    check_mission(limited(&both(), "then1", timeout(5, 0)), &[Ok("a"), Ok("b")], "a, b, done");
    // Each attempt has its own time.
    let events = [Ok("a"), Wait(10), Event::Ends("b"), Ok("a"), Ok("b")];
    check_mission(limited(&both(), "then1", timeout(5, 1)), &events, "a, b, late then1, again then1, a, b, done");
    // An OR takes another way.
    let tree = or([then([leaf("a", with_potential(blank("a"), 9.0))]), free("c")]);
    let events = [Wait(10), Event::Ends("a"), Ok("c")];
    check_mission(limited(&tree, "then2", timeout(5, 0)), &events, "a, late then2, c, done");
    // Where nothing runs, it has failed at once.
    let mut mission = limited(&then([free("a"), stuck()]), "then1", timeout(5, 0));
    mission.world.outside = vec![true; 4];
    check_mission(mission, &[Ok("a"), Wait(10)], "a, late then1, failed at then1");
}

#[test]
fn what_others_did_is_not_done() {
    // Somebody else has put the object where it was to go.
    let carry = || then([go("move a", 0), grab("pick 0", 0, 0), go("move b", 1), drop_at("place 0", 0, 1, 1)]);
    let there = World(Change::Object(ObjectId(0), Location::At(PlaceId(1))));
    check(&carry(), &[there, Ok("move a")], "move a, others place 0, done");
    let more = then([carry(), free("end")]);
    check(&more, &[there, Ok("move a"), Ok("end")], "move a, others place 0, end, done");
    // What is passed over puts it elsewhere: that is still to be done.
    let via = then([
        go("move a", 0),
        grab("pick 0", 0, 0),
        go("move c", 2),
        drop_at("place c", 0, 2, 1),
        grab("pick c", 0, 2),
        go("move b", 1),
        drop_at("place b", 0, 1, 1),
    ]);
    check(&via, &[there, Ok("move a")], "move a, never pick 0, failed at pick 0");
    // What is passed over is about something else.
    let other = leaf("other", setting(blank("other"), 3));
    let tree = then([go("move a", 0), grab("pick 0", 0, 0), other, go("move b", 1), drop_at("place 0", 0, 1, 1)]);
    check(&tree, &[there, Ok("move a")], "move a, never pick 0, failed at pick 0");
    // Of a fact likewise.
    let needs = needing(setting(blank("first"), 1), 0);
    let tree = and([
        free("begin"),
        then([
            leaf("first", needs),
            leaf("last", BehaviorSpec { satisfied: Condition::Fact(FactId(1), true), ..blank("last") }),
            free("end"),
        ]),
    ]);
    let mut mission = closed(&tree);
    mission.world.outside = vec![true; 4];
    let holds = World(Change::Fact(FactId(1), true));
    check_mission(mission, &[holds, Ok("begin"), Ok("end")], "begin, others last, end, done");
}

#[test]
fn what_rejects_a_behavior_is_no_candidate() {
    let spec = support::pick(body(), ObjectId(0), PlaceId(0), PLACES);
    let tree = then([go("move a", 0), leaf("pick 0", BehaviorSpec { retries: 9, ..spec })]);
    // One arm after the other, each once; then it has failed for good, whatever retries are left.
    let run = check(&tree, &[Ok("move a"), Event::Rejects("pick 0")], "move a, pick 0, pick 0");
    assert!(run.table().starts_with("gripper#0: pick 0"), "{}", run.table());
    let events = [Ok("move a"), Event::Rejects("pick 0"), Event::Rejects("pick 0")];
    check(&tree, &events, "move a, pick 0, pick 0, failed at pick 0");
    // A node that is tried again is as new in that too.
    let events = [Ok("move a"), Event::Rejects("pick 0"), Event::Rejects("pick 0"), Ok("pick 0")];
    check_mission(limited(&tree, "then1", RETRY), &events, "move a, pick 0, pick 0, again then1, pick 0, done");
}
