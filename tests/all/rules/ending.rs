//! Consequences back, failing, and what is left then (`semantics` 2 and 6).

use ambidex::model::{BehaviorSpec, Change, EffectTerm, FactId, Location, ObjectId, PlaceId, ResourceId};

use super::Event::{Fails, FailsWith, Ok, OkWith, World};
use super::words::*;
use super::{and, leaf, or, then};
use crate::support::{self, blank};

#[test]
fn before_a_stall_a_then_goes_back() {
    // The place fails, another drives the base away: the second move is done again, not the first.
    let carry = then([go("move a", 0), grab("pick 0", 0, 0), go("move b", 1), drop_at("place 0", 0, 1, 1)]);
    let away = World(Change::Base(support::place(2, PLACES).stand));
    let events = [Ok("move a"), Ok("pick 0"), Ok("move b"), away, Fails("place 0"), Ok("move b"), Ok("place 0")];
    let steps = "move a, pick 0, move b, place 0, back move b, move b, place 0, done";
    check(carry, &events, steps);
}

#[test]
fn undone_work_is_done_again_by_whoever_did_it() {
    let maker = |name: &str| {
        let effects = vec![EffectTerm::Fact(FactId(2), true)];
        leaf(name, BehaviorSpec { effects, ..blank(name) })
    };
    let heir = BehaviorSpec { retries: 1, ..needing(blank("heir"), 2) };
    let fact = |holds| World(Change::Fact(FactId(2), holds));
    // The way that the OR has chosen, not the other one.
    let either = || then([or([maker("one"), maker("two")]), leaf("heir", heir.clone())]);
    let events = [Ok("one"), fact(false), Fails("heir"), Ok("one"), Ok("heir")];
    check(either(), &events, "one, heir, back one, one, heir, done");
    // The nearest one, and only while it is needed.
    let chain = || then([maker("first"), maker("second"), leaf("heir", heir.clone())]);
    let events = [Ok("first"), Ok("second"), fact(false), Fails("heir"), Ok("second"), Ok("heir")];
    check(chain(), &events, "first, second, heir, back second, second, heir, done");
    // Once in each progress: it failed to make it so, and nothing else has changed.
    let unmade = OkWith("one", Change::Fact(FactId(2), false));
    let events = [Ok("one"), fact(false), Fails("heir"), unmade];
    check(either(), &events, "one, heir, back one, one, waits");
    // Not across siblings of an AND.
    let beside = and([maker("one"), leaf("heir", heir)]);
    let events = [Ok("one"), fact(false), Fails("heir")];
    check(beside, &events, "one, heir, waits");
}

#[test]
fn a_failed_place_keeps_what_it_holds() {
    let carry = || then([go("move a", 0), grab("pick 0", 0, 0), go("move b", 1), drop_at("place 0", 0, 1, 1)]);
    let before = [Ok("move a"), Ok("pick 0"), Ok("move b")];
    let steps = "move a, pick 0, move b, place 0";
    // Full, the gripper goes back to the THEN, and the place tries again.
    let run = check(carry(), &[&before[..], &[Fails("place 0")]].concat(), &format!("{steps}, place 0"));
    assert!(run.table().starts_with("gripper#1: place 0"), "{}", run.table());
    // Empty, it is free; what was dropped is picked up again, from where the robot can.
    let lost = FailsWith("place 0", Change::Object(ObjectId(0), Location::At(PlaceId(0))));
    let events = [&before[..], &[lost]].concat();
    let run = check(carry(), &events, &format!("{steps}, back pick 0, back move a, move a"));
    assert_eq!(run.table(), "base#3: move a");
    // Nobody knows where it is.
    let lost = FailsWith("place 0", Change::Emptied(ResourceId(1)));
    let events = [&before[..], &[lost]].concat();
    check(carry(), &events, &format!("{steps}, never place 0, failed at place 0"));
}

#[test]
fn failure_ends_what_runs_beside_it() {
    // Another way is left: what runs is canceled, and nothing else begins.
    let other = || leaf("other", with_potential(blank("other"), 0.1));
    let tree = || or([and([free("a"), then([free("b"), free("c")])]), other()]);
    let run = check(tree(), &[Fails("a")], "a + b");
    assert_eq!(run.reason("c"), Some(ambidex::model::Reason::Ending { failed: run.node("a") }));
    check(tree(), &[Fails("a"), Ok("b")], "a + b, other");
    // Nothing is won by that: the others finish what they can.
    let tree = || and([free("a"), then([free("b"), free("c")])]);
    check(tree(), &[Fails("a"), Ok("b")], "a + b, c");
    check(tree(), &[Fails("a"), Ok("b"), Ok("c")], "a + b, c, failed at a");
    check(then([tree(), free("d")]), &[Fails("a"), Ok("b"), Ok("c")], "a + b, c, failed at a");
    check(and([tree(), free("d")]), &[Fails("a"), Ok("b"), Ok("c"), Ok("d")], "a + b + d, c, failed at a");
    // The task failed at what failed first, whatever ended last.
    check(and([free("a"), free("b")]), &[Fails("a"), Ok("b")], "a + b, failed at a");
    let twice = leaf("a", BehaviorSpec { retries: 1, ..blank("a") });
    check(twice, &[Fails("a"), Fails("a")], "a, a, failed at a");
}

/// What controllers say of the world overrules what the kind promises, and a success that they deny is none.
#[test]
fn a_contradicted_success_is_a_failure() {
    let carry = || then([go("move a", 0), grab("pick 0", 0, 0), go("move b", 1), drop_at("place 0", 0, 1, 1)]);
    let held = |object| Change::Taken(ObjectId(object), ResourceId(1));
    // The gripper closed on nothing: nothing was picked.
    let nothing = [Ok("move a"), OkWith("pick 0", Change::Emptied(ResourceId(1)))];
    check(carry(), &nothing, "move a, pick 0, failed at pick 0");
    // The gripper holds the other object, and that alone.
    let other = [Ok("move a"), OkWith("pick 0", held(1))];
    let run = check(carry(), &other, "move a, pick 0, failed at pick 0");
    assert_eq!(run.world_state().objects[1], Location::held(ResourceId(1)));
    assert_ne!(run.world_state().objects[0], Location::held(ResourceId(1)));
    // The object sticks to the gripper.
    let stuck = [Ok("move a"), Ok("pick 0"), Ok("move b"), OkWith("place 0", held(0))];
    check(carry(), &stuck, "move a, pick 0, move b, place 0, place 0");
}
