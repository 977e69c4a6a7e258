//! How leases move, rest and lapse (`semantics` 2).

use ambidex::model::{
    Access, BehaviorSpec, Change, ChannelId, EffectTerm, FactId, ObjectId, ResourceId, Retention, Selector,
};

use super::Event::{Ok, World};
use super::words::*;
use super::{FREE, and, leaf, then};
use crate::support::{self, GRIPPER, blank, claim, fact};

#[test]
fn a_grant_moves_leases() {
    // What the move kept moves to the pick; what the pick does not claim stays with the THEN.
    let keeping = BehaviorSpec {
        claims: vec![
            claim(Selector::Named(ResourceId(4)), EXCLUSIVE, GO),
            claim(Selector::Named(ResourceId(5)), EXCLUSIVE, GO),
        ],
        ..blank("keep")
    };
    let tree = || then([leaf("keep", keeping.clone()), tool("use", EXCLUSIVE, FREE), free("end")]);
    assert_eq!(check(tree(), &[], "keep").table(), "tool#4: keep, tool#5: keep");
    let run = check(tree(), &[Ok("keep")], "keep, use");
    assert_eq!(run.table(), "tool#4: use, tool#5: then1");
    let run = check(tree(), &[Ok("keep"), Ok("use")], "keep, use, end");
    assert_eq!(run.table(), "tool#5: then1");
    // Heirs granted in one round hold together.
    let shared = Access::Shared(ChannelId(1));
    let heirs = and([tool("a", shared, FREE), tool("b", shared, FREE)]);
    let run = check(then([tool("keep", EXCLUSIVE, GO), heirs]), &[Ok("keep")], "keep, a + b");
    assert_eq!(run.table(), "tool#4: a, tool#4: b");
}

#[test]
fn a_move_keeps_its_base_for_its_heir() {
    // The base is shared "at the place": nobody else can drive it away, others of that place can join.
    let other = then([go("move b", 1), free("b")]);
    let tree = and([then([go("move a", 0), grab("pick 0", 0, 0)]), other]);
    let run = check(tree, &[Ok("move a")], "move a, pick 0");
    assert!(run.table().starts_with("gripper#1: pick 0, head#2: pick 0, base#3: pick 0"), "{}", run.table());
}

#[test]
fn an_intention_rests_only_with_a_then() {
    let tree = and([tool("keep", EXCLUSIVE, GO), free("other")]);
    assert_eq!(check(tree, &[Ok("keep")], "keep + other").table(), "");
    let physical = and([tool("keep", EXCLUSIVE, Retention::Physical(EXCLUSIVE)), free("other")]);
    assert_eq!(check(physical, &[Ok("keep")], "keep + other").table(), "tool#4: keep");
}

#[test]
fn an_intention_lapses_when_waiting_would_not_help() {
    let heir = || leaf("heir", needing(tool_spec(EXCLUSIVE, FREE), 0));
    let tree = then([tool("keep", EXCLUSIVE, GO), heir()]);
    let run = check(tree, &[Ok("keep")], "keep, lapses keep, waits");
    assert_eq!(run.table(), "");
    // It does not ask again before something new is done or the world changes.
    let tree = || and([then([tool("keep", EXCLUSIVE, GO), heir()]), free("news")]);
    check(tree(), &[Ok("keep")], "keep + news, lapses keep");
    check(tree(), &[Ok("keep"), Ok("news")], "keep + news, lapses keep, keep");
    let holds = World(Change::Fact(FactId(0), true));
    check(tree(), &[Ok("keep"), holds, Ok("keep")], "keep + news, lapses keep, keep, heir");
    // An heir that waits for what runs keeps it.
    let second = Selector::Named(ResourceId(5));
    let busy = BehaviorSpec { claims: vec![claim(second, EXCLUSIVE, FREE)], ..blank("busy") };
    let waits = leaf("heir", busy.clone());
    let tree = and([then([tool("keep", EXCLUSIVE, GO), waits]), leaf("busy", with_potential(busy, 9.0))]);
    check(tree, &[Ok("keep"), Ok("busy")], "keep + busy, heir");
}

#[test]
fn of_several_intentions_the_last_lapses() {
    let stuck = || leaf("stuck", needing(blank("stuck"), 0));
    let second = BehaviorSpec { claims: vec![claim(Selector::Named(ResourceId(5)), EXCLUSIVE, GO)], ..blank("second") };
    let tree = then([tool("first", EXCLUSIVE, GO), then([leaf("second", second), stuck()])]);
    let events = [Ok("first"), Ok("second")];
    check(tree, &events, "first, second, lapses second, lapses first, waits");
}

#[test]
fn a_lapse_waits_for_the_preferred_wherever_it_is_bound() {
    // The AND gives gripper 0 to `best`, root the nearer gripper 1; `heir` needs both.
    let wanted = Selector::AnyEmpty { of: GRIPPER, reaches: Some(ObjectId(0)) };
    let best = BehaviorSpec { claims: vec![claim(wanted, EXCLUSIVE, FREE)], ..blank("best") };
    let best = needing(with_potential(best, 9.0), 1);
    let both = [1, 0].map(|gripper| claim(Selector::Named(ResourceId(gripper)), EXCLUSIVE, FREE));
    let heir = BehaviorSpec { claims: both.to_vec(), ..blank("heir") };
    let effects = vec![EffectTerm::Fact(FactId(1), true)];
    let keep = BehaviorSpec { effects, ..tool_spec(EXCLUSIVE, GO) };
    let tree = and([then([leaf("keep", keep), leaf("heir", heir)]), leaf("best", best)]);
    let begins = World(Change::Base(support::place(0, PLACES).stand));
    check(tree, &[begins, Ok("keep"), Ok("best")], "keep, best, heir");
}

#[test]
fn leases_in_what_is_skipped_count_as_inherited() {
    let holding = tool("hold", EXCLUSIVE, Retention::Physical(EXCLUSIVE));
    let tree = then([and([holding, leaf("met", fact(FactId(0)))]), tool("use", EXCLUSIVE, FREE)]);
    let slow = leaf("met", needing(fact(FactId(0)), 3));
    let tree_slow =
        then([and([tool("hold", EXCLUSIVE, Retention::Physical(EXCLUSIVE)), slow]), tool("use", EXCLUSIVE, FREE)]);
    let holds = World(Change::Fact(FactId(0), true));
    check(tree_slow, &[holds, Ok("hold"), Ok("use")], "hold, use, done");
    check(tree, &[Ok("met"), Ok("hold"), Ok("use")], "hold + met, use, done");
}
