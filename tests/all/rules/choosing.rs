//! Who is asked, who is chosen, what is skipped (`semantics` 3 to 5).

use ambidex::model::{BehaviorSpec, Change, EffectTerm, FactId, ObjectId, PlaceId, Potential, ResourceId, Selector};

use super::Event::{Fails, Ok, World};
use super::words::*;
use super::{FREE, and, leaf, or, then};
use crate::support::{self, TOOL, blank, claim, fact, move_to};

#[test]
fn n_is_one_without_the_type() {
    let spec = move_to(body(), PlaceId(0), PLACES);
    let Potential::Nearness { to, floor_m, .. } = spec.potential else { unreachable!("a move is drawn by nearness") };
    let scale_by = Some(support::WING);
    let potential = Potential::Nearness { to, floor_m, scale_by };
    check(leaf("move", BehaviorSpec { potential, ..spec }), &[Ok("move")], "move, done");
}

#[test]
fn an_or_is_committed_by_a_grant() {
    let both = || or([leaf("a", with_potential(blank("a"), 1.0)), leaf("b", with_potential(blank("b"), 2.0))]);
    check(both(), &[Ok("b")], "b, done");
    check(both(), &[Fails("b"), Ok("a")], "b, a, done");
    // Refused above, it is free to take the other way in the next round.
    let wants = with_potential(tool_spec(EXCLUSIVE, FREE), 2.0);
    let tree = and([
        leaf("first", with_potential(tool_spec(EXCLUSIVE, FREE), 9.0)),
        or([leaf("wants", wants), free("other")]),
    ]);
    check(tree, &[], "first, other");
}

#[test]
fn a_lapse_frees_an_or() {
    let way =
        then([leaf("keep", with_potential(tool_spec(EXCLUSIVE, GO), 2.0)), leaf("stuck", needing(blank("stuck"), 0))]);
    check(or([way, free("other")]), &[Ok("keep"), Ok("other")], "keep, lapses keep, other, done");
}

#[test]
fn a_skip_stands_only_with_its_grant() {
    let met = |name: &str, holds: u32| leaf(name, fact(FactId(holds)));
    let tree = then([met("met", 0), free("next")]);
    let holds = World(Change::Fact(FactId(0), true));
    check(then([free("begin"), tree]), &[holds, Ok("begin"), Ok("next")], "begin, next, done");
    // Rejected, the THEN is back at what it skipped when that is not so any more.
    let next = leaf("next", with_potential(tool_spec(EXCLUSIVE, FREE), 1.0));
    let owner = leaf("owner", with_potential(tool_spec(EXCLUSIVE, FREE), 9.0));
    let tree = then([free("begin"), and([owner, then([met("met", 0), next])])]);
    let (set, clear) = (World(Change::Fact(FactId(0), true)), World(Change::Fact(FactId(0), false)));
    check(tree, &[set, Ok("begin"), clear], "begin, owner, met");
}

#[test]
fn satisfied_composites() {
    let met = |name: &str, holds: u32| leaf(name, fact(FactId(holds)));
    let set = |holds| World(Change::Fact(FactId(holds), true));
    let begin = || free("begin");
    let both = and([met("a", 0), met("b", 1)]);
    check(then([begin(), both]), &[set(0), set(1), Ok("begin")], "begin, done");
    let one = or([met("a", 0), met("b", 1)]);
    check(then([begin(), one]), &[set(1), Ok("begin")], "begin, done");
    let all = then([met("a", 0), met("b", 1)]);
    check(then([begin(), all]), &[set(0), set(1), Ok("begin")], "begin, done");
    // A satisfied child of an AND is not done by that: when it is undone it runs.
    let clear = World(Change::Fact(FactId(0), false));
    let late = and([begin(), leaf("a", needing(fact(FactId(0)), 1))]);
    check(late, &[set(0), clear, set(1)], "begin, a");
}

#[test]
fn a_grant_is_followed_by_another_round() {
    // The inner AND keeps only what fits its own best; what it hid comes in the next round.
    let inner = and([
        leaf(
            "big",
            BehaviorSpec {
                claims: [4, 5].map(|id| claim(Selector::Named(ResourceId(id)), EXCLUSIVE, FREE)).to_vec(),
                potential: Potential::Constant(5.0),
                ..blank("big")
            },
        ),
        leaf(
            "small",
            BehaviorSpec { claims: vec![claim(Selector::Named(ResourceId(5)), EXCLUSIVE, FREE)], ..blank("small") },
        ),
    ]);
    let outer = leaf("owner", with_potential(tool_spec(EXCLUSIVE, FREE), 9.0));
    check(and([outer, inner]), &[], "owner, small");
}

#[test]
fn algorithm_1() {
    let any = |name: &str, value: f64, wanted| {
        let claims = vec![claim(wanted, EXCLUSIVE, FREE)];
        leaf(name, with_potential(BehaviorSpec { claims, ..blank("any") }, value))
    };
    let named = |id| Selector::Named(ResourceId(id));
    // "Any of type" is matched as a whole: the first moves aside for the second.
    check(and([any("a", 2.0, Selector::Any(TOOL)), any("b", 1.0, named(4))]), &[], "a + b");
    // Greatest potential first, tree order among equals.
    check(and([any("a", 1.0, named(4)), any("b", 1.0, named(4))]), &[], "a");
    check(and([any("a", 1.0, named(4)), any("b", 2.0, named(4))]), &[], "b");
    // The heir of an intention comes first among equals.
    let heir = || then([tool("keep", EXCLUSIVE, GO), any("heir", 1.0, named(5))]);
    check(and([any("other", 1.0, named(5)), heir()]), &[], "other + keep");
    let late =
        leaf("other", BehaviorSpec { claims: vec![claim(named(5), EXCLUSIVE, FREE)], ..needing(blank("other"), 0) });
    let both = BehaviorSpec { effects: vec![EffectTerm::Fact(FactId(0), true)], ..tool_spec(EXCLUSIVE, GO) };
    let tree = and([late, then([leaf("keep", both), any("heir", 1.0, named(5))])]);
    check(tree, &[Ok("keep")], "keep, heir");
}

#[test]
fn nobody_changes_what_another_changes() {
    let changing = |name: &str| leaf(name, BehaviorSpec { changes: vec![ObjectId(0)], ..blank("changing") });
    check(and([changing("a"), changing("b")]), &[], "a");
    check(and([changing("a"), changing("b")]), &[Ok("a")], "a, b");
}
