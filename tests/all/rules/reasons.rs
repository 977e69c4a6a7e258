//! One row for each reason that the core gives; `NotItsTurn` is said of leaves that are not asked.

use std::sync::Arc;

use ambidex::model::{
    Access, BehaviorSpec, Change, ChannelId, Clash, Condition, ControllerKind, EffectTerm, FactId, HeldBy, Hold,
    Location, MissionSpec, NodeId, ObjectId, Obstacle, PlaceId, Potential, Reason, ResourceId, Retention, Selector,
};
use ambidex::tree::{Serial, Settings};
use ambidex::world::{Compatible, Use, View};
use nalgebra::Point3;

use super::Event::{Fails, Ok as Succeeds, World};
use super::{Event, FREE, Run, and, leaf, or, robot, then};
use crate::support::{self, BASE, Body, GRIPPER, HEAD, TOOL, Tree, WING, blank, claim, fact, mission, move_to, pick};

const PLACES: usize = 4;
const X: Access = Access::Exclusive;
const TOOL_4: ResourceId = ResourceId(4);
/// Lies at place 0.
const LYING: ObjectId = ObjectId(0);
/// Is in a gripper that nobody holds.
const GRIPPED: ObjectId = ObjectId(1);

fn run(tree: Tree, settings: Settings, events: &[Event]) -> Run {
    let objects = vec![Location::At(PlaceId(0)), Location::held(ResourceId(1))];
    let mut mission = mission(robot(2, 1), PLACES, objects, vec![false; 2], &tree);
    mission.world.outside = vec![true; 2];
    let walled = mission.world.places[3].stand.at;
    let corner = |by: f64| Point3::new(walled.x + by, walled.y + by, by + 0.4);
    mission.world.obstacles.push(Obstacle::between(corner(-0.4), corner(0.4)));
    Run::new(mission, settings, events)
}

/// The sentence that the leaf `it` ends with.
fn check(tree: Tree, events: &[Event], expected: &str) {
    check_with(Settings::default(), tree, events, expected);
}

fn check_with(settings: Settings, tree: Tree, events: &[Event], expected: &str) {
    let run = run(tree, settings, events);
    let reason = run.reason("it");
    let reason = reason.map(|reason| reason.sentence(&run.mission.names));
    assert_eq!(reason.as_deref(), Some(expected));
}

fn wants(selector: Selector) -> BehaviorSpec {
    BehaviorSpec { claims: vec![claim(selector, X, FREE)], ..blank("wants") }
}

fn it(spec: BehaviorSpec) -> Tree {
    leaf("it", spec)
}

fn needs(precondition: Condition) -> Tree {
    it(BehaviorSpec { precondition, ..blank("needs") })
}

fn unlikely() -> BehaviorSpec {
    BehaviorSpec { potential: Potential::Constant(0.1), ..blank("unlikely") }
}

fn first(spec: BehaviorSpec) -> Tree {
    leaf("first", BehaviorSpec { potential: Potential::Constant(5.0), ..spec })
}

/// All arms but some are too short for anything.
fn reach_only(mission: &mut MissionSpec, arms: &[usize]) {
    for (index, controller) in mission.robot.controllers.iter_mut().enumerate() {
        if let ControllerKind::Arm(arm) = &mut controller.kind
            && !arms.contains(&index)
        {
            arm.reach_m = 0.1;
        }
    }
}

#[test]
fn of_the_world() {
    let (place, stand) = (PlaceId(1), support::place(1, PLACES).stand);
    let at = Condition::At { place, stands: vec![stand], tolerance_m: 0.25 };
    check(needs(at.clone()), &[], "the base does not stand at place1");
    let drive = leaf("move", move_to(robot(2, 1), place, PLACES));
    check(and([drive, needs(at)]), &[World(Change::Fact(FactId(0), true))], "the base is being driven by move");
    let walled = it(move_to(robot(2, 1), PlaceId(3), PLACES));
    check(walled, &[], "no free path leads to place3");
    check(needs(Condition::Fact(FactId(0), true)), &[], "\"fact0\" does not hold");
    check(needs(Condition::Held(LYING.into())), &[], "object0 is not held by this branch of the task");
    check(needs(Condition::Free(GRIPPED)), &[], "object1 is in gripper#1 already");
    check(needs(Condition::Lies(LYING, place)), &[], "object0 is not at place1");
    let tree = and([it(fact(FactId(0))), leaf("other", blank("other"))]);
    let late = |tree| then([leaf("begin", blank("begin")), tree]);
    let set = World(Change::Fact(FactId(0), true));
    check(late(tree), &[set, Succeeds("begin")], "its goal is met already");
}

#[test]
fn of_resources() {
    let any = |of| Selector::Any(of);
    check(
        and([first(wants(Selector::Named(TOOL_4))), it(wants(Selector::Named(TOOL_4)))]),
        &[],
        "tool#4 is held by first",
    );
    check(and([first(wants(any(TOOL))), it(wants(any(TOOL)))]), &[], "every tool is held or full");
    check(it(wants(any(WING))), &[], "the robot has no wing");
    let empty = |resource, reaches| wants(Selector::Empty { resource: ResourceId(resource), reaches });
    check(it(empty(0, Some(LYING))), &[], "no free resource reaches object0");
    check(it(empty(1, None)), &[], "every gripper is held or full");
    let both = and([first(wants(Selector::Named(ResourceId(0)))), it(empty(0, None))]);
    check(both, &[], "gripper#0 is held by first");
    let never = BehaviorSpec { potential: Potential::Constant(0.0), ..blank("never") };
    check(it(never), &[], "its potential is 0, which means that it is not to run");
    let holding = Selector::Holding { object: LYING, of: GRIPPER, resource: None };
    check(it(wants(holding)), &[], "object0 is not held by this branch of the task");
    let far = Selector::AnyEmpty { of: GRIPPER, reaches: Some(LYING) };
    check(it(wants(far)), &[], "no free resource reaches object0");
    // Of claims that cannot be served together the type that is short is named.
    let three = [Selector::Any(HEAD), Selector::Any(HEAD), Selector::Any(BASE)];
    let claims = three.map(|selector| claim(selector, X, FREE)).to_vec();
    check(it(BehaviorSpec { claims, ..blank("three") }), &[], "needs 2 heads, 1 free");
    // Both grippers are held: a move that counts them has nothing to go there for.
    let claims = [0, 1].map(|id| claim(Selector::Named(ResourceId(id)), X, FREE)).to_vec();
    let holds = first(BehaviorSpec { claims, ..blank("holds") });
    let late = then([leaf("begin", blank("begin")), it(move_to(robot(2, 1), PlaceId(0), PLACES))]);
    check(and([holds, late]), &[Succeeds("begin")], "no gripper would be available to it there");
}

#[test]
fn of_holders() {
    let changing =
        |effect, claims| BehaviorSpec { effects: vec![effect], changes: vec![GRIPPED], claims, ..blank("it") };
    let gripper = claim(Selector::Named(ResourceId(1)), X, FREE);
    let put = EffectTerm::Lies(GRIPPED, PlaceId(0));
    // Whoever puts it down claims all that hold it, and tells them.
    let kept = "object1 is in gripper#1 too, which would not let go of it";
    check(it(changing(put, Vec::new())), &[], kept);
    check(it(changing(put, vec![gripper])), &[], kept);
    let last = EffectTerm::LetGo(GRIPPED, 0);
    check(it(changing(last, vec![gripper])), &[], "nothing else holds object1, which must not fall");
    let two = Hold { object: GRIPPED, by: HeldBy::Any, hands: 2, alone: false };
    let few = "object1 is held by 1 of this branch of the task, and has to be by 2";
    check(needs(Condition::Held(two)), &[], few);
    let other = Hold { object: GRIPPED, by: HeldBy::Resource(ResourceId(0)), hands: 1, alone: false };
    let with = "object1 is not held by this branch of the task with gripper#0";
    check(needs(Condition::Held(other)), &[], with);
    let tool = Hold { object: GRIPPED, by: HeldBy::Type(TOOL), hands: 1, alone: false };
    check(needs(Condition::Held(tool)), &[], "object1 is in no tool of this branch of the task");
    let holding = Selector::Holding { object: GRIPPED, of: GRIPPER, resource: None };
    let claims = vec![claim(holding, X, FREE); 2];
    let short = "object1 is held by 1 gripper of this branch of the task, and has to be by 2";
    check(it(BehaviorSpec { claims, ..blank("both") }), &[], short);
}

#[test]
fn of_grippers_that_would_reach() {
    // Of those that would reach the one that runs is named: it is worth waiting for.
    let keep = Retention::Physical(X);
    let kept = BehaviorSpec { claims: vec![claim(Selector::Named(ResourceId(0)), X, keep)], ..blank("kept") };
    let body = Body { grippers: 3, ..robot(2, 1) };
    let near = Selector::AnyEmpty { of: GRIPPER, reaches: Some(LYING) };
    let tree = and([
        then([leaf("keeps", kept), leaf("waits", blank("waits"))]),
        then([leaf("go", blank("go")), leaf("runs", wants(Selector::Named(ResourceId(1)))), leaf("end", blank("end"))]),
        then([leaf("begin", blank("begin")), it(wants(near))]),
    ]);
    let there = World(Change::Base(support::place(0, PLACES).stand));
    let events = [there, Succeeds("keeps"), Succeeds("go"), Succeeds("begin")];
    let objects = vec![Location::At(PlaceId(0)), Location::Unknown];
    let mut mission = mission(body, PLACES, objects, vec![false; 2], &tree);
    reach_only(&mut mission, &[0, 1]);
    let run = Run::new(mission, Settings::default(), &events);
    let reason = run.reason("it").map(|reason| reason.sentence(&run.mission.names));
    assert_eq!(reason.as_deref(), Some("gripper#1 is held by runs"));
}

#[test]
fn of_other_behaviors() {
    let changing = || BehaviorSpec { changes: vec![LYING], ..blank("changing") };
    check(and([first(changing()), it(changing())]), &[], "first changes object0 too");
    // In the round that grants both there is no following one that says otherwise: a THEN's retry hides it.
    let run =
        run(and([first(wants(Selector::Named(TOOL_4))), it(wants(Selector::Named(TOOL_4)))]), Settings::default(), &[]);
    let first_round = run.driver.records.iter().find_map(|record| match record {
        ambidex::model::Record::Decided { refused, .. } => refused.first().cloned(),
        _ => None,
    });
    let sentence = first_round.map(|blocked| blocked.reason.sentence(&run.mission.names));
    assert_eq!(sentence.as_deref(), Some("outbid by first for tool#4 (5.000 against 1.000)"));
    let tree = or([first(blank("first")), it(blank("it"))]);
    check(tree, &[], "first was chosen instead");
    let tree = and([
        leaf("fails", blank("fails")),
        leaf("runs", blank("runs")),
        then([leaf("holds", blank("holds")), it(blank("it"))]),
    ]);
    check(or([tree, leaf("other", unlikely())]), &[Fails("fails")], "fails failed; its siblings are being canceled");
}

#[test]
fn of_lapses() {
    let keep = Retention::Intention(Access::Shared(ChannelId(1)));
    let spec = BehaviorSpec { claims: vec![claim(Selector::Named(TOOL_4), X, keep)], ..blank("keeps") };
    let lacks = BehaviorSpec { precondition: Condition::Fact(FactId(0), true), ..blank("lacks") };
    let tree = then([it(spec), leaf("heir", lacks)]);
    check(tree, &[Succeeds("it")], "already done for heir, which still lacks: \"fact0\" does not hold");
}

#[derive(Debug)]
struct Never(NodeId, NodeId);

impl Compatible for Never {
    fn check(&self, _: &View, uses: &[Use<'_>]) -> Result<(), Reason> {
        let is_there = |leaf| uses.iter().any(|used| used.request.leaf == leaf);
        match is_there(self.0) && is_there(self.1) {
            true => Err(Reason::Clash { with: self.0, over: Clash::Rule }),
            false => Ok(()),
        }
    }
}

#[test]
fn of_rules_and_allocators() {
    let tree = || and([first(wants(Selector::Named(TOOL_4))), it(wants(Selector::Named(ResourceId(2))))]);
    let rules = Arc::new(Never(NodeId(2), NodeId(3)));
    check_with(Settings { rules, ..Settings::default() }, tree(), &[], "it would be in the way of first");
    let allocator = Arc::new(Serial);
    check_with(Settings { allocator, ..Settings::default() }, tree(), &[], "head#2 is held by first");
    let allocator = Arc::new(Serial);
    let idle = and([first(blank("first")), it(blank("it"))]);
    check_with(
        Settings { allocator, ..Settings::default() },
        idle,
        &[],
        "one behavior at a time, and first has the robot",
    );
}

#[test]
fn a_pick_that_reaches_says_so() {
    let stand = support::place(0, PLACES).stand;
    let begin = BehaviorSpec { effects: vec![EffectTerm::Stands(stand)], ..blank("begin") };
    let spec = pick(robot(2, 1), LYING, PlaceId(0), PLACES);
    let run = run(then([leaf("begin", begin), it(spec)]), Settings::default(), &[Succeeds("begin")]);
    assert_eq!(run.steps(), "begin, it");
}

/// Whenever everything has come to rest, the reasons are told, and not once more while it rests.
#[test]
fn of_a_large_tree_are_told_when_nothing_goes_on_any_more() {
    let needs = |kind: &str, fact| BehaviorSpec { precondition: Condition::Fact(FactId(fact), true), ..blank(kind) };
    let tree = and([leaf("never", needs("never", 0)), leaf("later", needs("later", 1))]);
    let body = robot(1, 0);
    let mut mission = mission(body, 1, Vec::new(), vec![false; 3], &tree);
    mission.world.outside = vec![true; 3];
    let settings = Settings { waits_when_stalled: true, has_messages: false, ..Settings::default() };
    let change = |fact| Event::World(Change::Fact(FactId(fact), true));
    let run = Run::new(mission, settings, &[change(2), change(1), Event::Ok("later")]);
    // The first round comes to nothing, and so does the second; the third grants, the last comes to nothing again.
    assert_eq!(run.steps(), "later, waits");
    assert_eq!(run.told_rounds(), [1, 5]);
}
