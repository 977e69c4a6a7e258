//! What behaviors keep for good is enough for all of them, in whatever order they run.

use std::collections::BTreeSet;

use super::{Seen, Supply, keeps_alone};
use crate::fault::Faults;
use ambidex_model::{BehaviorSpec, Claim, EffectTerm, NodeId, NodeKind, ResourceId, Retention, Selector, TypeId};

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
    let (there, full) = (count(seen, supply), full_at_start(seen, supply));
    let mut demands = vec![Demand::default(); tree.nodes.len()];
    let mut is_told = vec![false; tree.nodes.len()];
    for node in (0..tree.nodes.len()).rev().map(NodeId::from) {
        let children: Vec<NodeId> = tree.topology.children(node).collect();
        let below: Vec<Demand> = children.iter().map(|child| demands[child.index()]).collect();
        demands[node.index()] = match &tree.nodes[node.index()] {
            NodeKind::Behavior(behavior) => demand(seen, behavior, supply, is_taker),
            NodeKind::Then => in_order(&below),
            NodeKind::And | NodeKind::Root => in_any_order(&below),
            NodeKind::Or => either(&below),
            // Its cleanup may be left out.
            NodeKind::Cleanup => below.first().copied().unwrap_or_default(),
        };
        let is_told_below = children.iter().any(|child| is_told[child.index()]);
        is_told[node.index()] = is_told_below;
        let needed = demands[node.index()].peak + full;
        if !is_told_below && needed > there && demands[node.index()].peak > 0 {
            is_told[node.index()] = true;
            tell(seen, supply, node, needed, faults);
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

/// How many of a supply hold something at the start.
fn full_at_start(seen: &Seen<'_>, supply: Supply) -> i64 {
    let is_of_it = |id: &&ResourceId| match supply {
        Supply::One(one) => **id == one,
        Supply::Any(of) => ty(seen, **id) == of,
    };
    let holders = seen.mission.start.objects.iter().flat_map(|at| at.holders());
    holders.filter(is_of_it).count() as i64
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
            faults.push_with((seen.spans[node.index()], names.node(node)), message, help);
        }
        (supply, ..) => {
            let what = match supply {
                Supply::One(resource) => names.resource(resource).to_owned(),
                Supply::Any(of) => names.ty(of).to_owned(),
            };
            let has = count(seen, supply);
            let message = format!("it must run out: {needed} of `{what}` would be in use, and the robot has {has}");
            seen.warn(node, message, "give some back in between, as `place` does", faults);
        }
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
