//! What behaviors keep for good is enough for all of them, in whatever order they run.

use std::collections::BTreeSet;

use super::{Part, Seen, Supply, TOP, keeps_alone};
use crate::fault::Faults;
use ambidex_model::{
    BehaviorSpec, Claim, EffectTerm, NodeId, NodeKind, ObjectId, ResourceId, Retention, Selector, TypeId,
};

/// How many of a supply a node needs at once at least, how many more are kept when it is done, and how many of these
/// are still empty, so that whoever inherits them needs no other.
#[derive(Debug, Clone, Copy, Default)]
struct Demand {
    peak: i64,
    net: i64,
    spare: i64,
}

/// Whether something was told.
pub(super) fn check(seen: &Seen<'_>, faults: &mut Faults) -> bool {
    let mut is_short = false;
    for supply in supplies(seen) {
        is_short |= check_supply(seen, supply, faults);
    }
    is_short
}

/// Needs that the robot cannot meet, each told at the smallest node that has it; whether there are any.
fn check_supply(seen: &Seen<'_>, supply: Supply, faults: &mut Faults) -> bool {
    let tree = &seen.mission.tree;
    let is_taker = is_taker(seen, supply);
    let there = count(seen, supply);
    let (full, for_good) = full_at_start(seen, supply);
    let mut demands = vec![Demand::default(); tree.nodes.len()];
    let mut is_told = vec![false; tree.nodes.len()];
    for node in tree.topology.nodes().rev() {
        let children: Vec<NodeId> = tree.topology.children(node).collect();
        let below: Vec<Demand> = children.iter().map(|child| demands[child.index()]).collect();
        demands[node.index()] = match &tree.nodes[node.index()] {
            NodeKind::Behavior(behavior) => demand(seen, behavior, supply, is_taker),
            NodeKind::Then => in_order(&below),
            NodeKind::And | NodeKind::Tasks | NodeKind::Root => in_any_order(&below),
            NodeKind::Or => either(&below),
            // Its cleanup may be left out.
            NodeKind::Cleanup => below.first().copied().unwrap_or_default(),
        };
        let is_told_below = children.iter().any(|child| is_told[child.index()]);
        is_told[node.index()] = is_told_below;
        let peak = demands[node.index()].peak;
        // What is let go somewhere may be so before anything below this begins.
        let full = if node == TOP { full } else { for_good };
        if !is_told_below && peak + full > there && peak > 0 {
            is_told[node.index()] = true;
            match seen.part == Part::Task && peak + full - for_good <= there {
                true => tell_of_others(seen, supply, node, for_good, faults),
                false => tell(seen, supply, node, peak + full, faults),
            }
        }
    }
    is_told.contains(&true)
}

/// What is kept physically by any behavior.
fn supplies(seen: &Seen<'_>) -> BTreeSet<Supply> {
    let claims = seen.behaviors().flat_map(|behavior| &behavior.claims);
    claims.filter(|claim| keeps_alone(claim)).filter_map(|claim| seen.supply(claim)).collect()
}

fn count(seen: &Seen<'_>, supply: Supply) -> i64 {
    match supply {
        Supply::One(_) => 1,
        Supply::Any(of) => seen.mission.robot.of_type(of).count() as i64,
    }
}

/// How many of a supply hold something at the start, and how many of these something that nothing here lets go. Of what
/// comes before a branch nothing is known.
fn full_at_start(seen: &Seen<'_>, supply: Supply) -> (i64, i64) {
    if seen.part == Part::Branch {
        return (0, 0);
    }
    let is_of_it = |id: &&ResourceId| match supply {
        Supply::One(one) => **id == one,
        Supply::Any(of) => ty(seen, **id) == of,
    };
    let let_go: BTreeSet<ObjectId> = seen.behaviors().flat_map(let_go).collect();
    let (mut full, mut for_good) = (0, 0);
    for (object, at) in seen.mission.start.objects.iter().enumerate() {
        let holders = at.holders().iter().filter(is_of_it).count() as i64;
        full += holders;
        for_good += if let_go.contains(&ObjectId::from(object)) { 0 } else { holders };
    }
    (full, for_good)
}

/// Objects that a behavior puts down or gives away.
fn let_go(behavior: &BehaviorSpec) -> impl Iterator<Item = ObjectId> {
    behavior.effects.iter().filter_map(|effect| match effect {
        EffectTerm::LetGo(object, _) | EffectTerm::Lies(object, _) => Some(*object),
        EffectTerm::Taken(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => None,
    })
}

fn ty(seen: &Seen<'_>, resource: ResourceId) -> TypeId {
    seen.mission.robot.resources[resource.index()].ty
}

/// Whether some behavior takes an object with one of a supply.
fn is_taker(seen: &Seen<'_>, supply: Supply) -> bool {
    seen.behaviors().any(|behavior| {
        let mut takers = behavior.effects.iter().filter_map(|effect| match effect {
            EffectTerm::Taken(_, claim) => Some(&behavior.claims[*claim]),
            EffectTerm::LetGo(..) | EffectTerm::Lies(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => None,
        });
        takers.any(|claim| seen.supply(claim) == Some(supply))
    })
}

fn demand(seen: &Seen<'_>, behavior: &BehaviorSpec, supply: Supply, is_taker: bool) -> Demand {
    let mut demand = Demand::default();
    for (index, claim) in behavior.claims.iter().enumerate() {
        let takes = |effect: &EffectTerm| matches!(effect, EffectTerm::Taken(_, by) if *by == index);
        match claim.selector {
            // What is held was kept before, for all that is known of what takes things.
            Selector::Holding { of, resource, .. } => {
                let is_of_it = match supply {
                    Supply::One(one) => resource.is_none_or(|named| named == one) && ty(seen, one) == of,
                    Supply::Any(any) => any == of,
                };
                demand.net -= i64::from(is_of_it && is_taker && claim.keep == Retention::Release);
            }
            // One that was kept before will do, whatever it holds.
            Selector::Named(_) | Selector::Any(_) if !keeps_alone(claim) => {}
            Selector::Named(_) | Selector::Empty { .. } | Selector::Any(_) | Selector::AnyEmpty { .. } => {
                let is_of_it = seen.supply(claim) == Some(supply);
                let is_spare = is_of_it && keeps_alone(claim) && !behavior.effects.iter().any(takes);
                demand.spare += i64::from(is_spare);
                demand.peak += i64::from(is_of_it);
                demand.net += i64::from(is_of_it && keeps_alone(claim));
            }
        }
    }
    demand
}

fn tell(seen: &Seen<'_>, supply: Supply, node: NodeId, needed: i64, faults: &mut Faults) {
    let names = &seen.mission.names;
    let keepers: Vec<&str> = keepers(seen, supply, node).into_iter().map(|leaf| names.node(leaf)).collect();
    match (supply, keepers.as_slice(), &seen.mission.tree.nodes[node.index()]) {
        (Supply::One(resource), [one, other, ..], NodeKind::And) => {
            let resource = names.resource(resource);
            let message = format!(
                "`{one}` and `{other}` can only ever exclude each other: whichever comes first keeps {resource} for good"
            );
            let help = "give it back between the two, as `place` does, or claim another resource".to_owned();
            faults.push_with((seen.span(node), names.node(node)), message, help);
        }
        (supply, ..) => {
            let (what, has) = (name(seen, supply), count(seen, supply));
            let message = format!("it must run out: {needed} of `{what}` would be in use, and the robot has {has}");
            seen.warn(node, message, "give some back in between, as `place` does", faults);
        }
    }
}

/// What is full now may be given back by another task.
fn tell_of_others(seen: &Seen<'_>, supply: Supply, node: NodeId, full: i64, faults: &mut Faults) {
    let (what, has) = (name(seen, supply), count(seen, supply));
    let message =
        format!("it waits for `{what}`: {full} of {has} hold something now that nothing in the task puts down");
    seen.warn(node, message, "it goes on once another task puts that down", faults);
}

fn name<'a>(seen: &Seen<'a>, supply: Supply) -> &'a str {
    match supply {
        Supply::One(resource) => seen.mission.names.resource(resource),
        Supply::Any(of) => seen.mission.names.ty(of),
    }
}

/// Behaviors below a node that keep some of a supply for good.
fn keepers(seen: &Seen<'_>, supply: Supply, node: NodeId) -> Vec<NodeId> {
    let keeps = |claim: &Claim| keeps_alone(claim) && seen.supply(claim) == Some(supply);
    let below = seen.mission.tree.leaves().filter(|&leaf| seen.mission.tree.topology.is_within(leaf, node));
    below.filter(|&leaf| seen.behavior(leaf).claims.iter().any(keeps)).collect()
}

fn in_order(children: &[Demand]) -> Demand {
    let mut whole = Demand::default();
    for child in children {
        whole.peak = whole.peak.max(whole.net - whole.spare.min(child.peak) + child.peak);
        let kept_again = whole.spare.min(child.net.max(0));
        whole.net += child.net - kept_again;
        whole.spare += child.spare - kept_again;
    }
    whole
}

/// The least that any order of the children needs at once.
fn in_any_order(children: &[Demand]) -> Demand {
    let net: i64 = children.iter().map(|child| child.net).sum();
    let given_back: i64 = children.iter().map(|child| child.net.min(0)).sum();
    let alone = children.iter().map(|child| child.peak + given_back - child.net.min(0)).max();
    // Whichever comes last, all others are done by then.
    let last = children.iter().map(|child| net - child.net + child.peak).min();
    let spare = children.iter().map(|child| child.spare).sum();
    Demand { peak: alone.into_iter().chain(last).max().unwrap_or(0).max(net), net, spare }
}

fn either(children: &[Demand]) -> Demand {
    Demand {
        peak: children.iter().map(|child| child.peak).min().unwrap_or(0),
        net: children.iter().map(|child| child.net).min().unwrap_or(0),
        spare: children.iter().map(|child| child.spare).max().unwrap_or(0),
    }
}
