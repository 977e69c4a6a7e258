//! What a mission must come to, seen before it runs: what cannot be done, and what is legal but surely not meant.

use std::collections::BTreeSet;

use crate::document::SourceSpan;
use crate::fault::Faults;
use ambidex_model::{
    Access, BehaviorSpec, Claim, Condition, EffectTerm, FactId, MissionSpec, NodeId, NodeKind, ResourceId, Retention,
    Selector, Task, TypeId,
};

/// Looks at a mission; `spans` has the place of each node.
pub(crate) fn check(mission: &MissionSpec, spans: &[SourceSpan], faults: &mut Faults) {
    let outlook = Outlook { mission, spans };
    let (brought, driven) = (outlook.brought(), outlook.driven());
    for leaf in mission.tree.leaves() {
        outlook.look_for_heirs(leaf, faults);
        outlook.look_for_facts(leaf, &brought, faults);
        outlook.look_for_a_base_that_leaves(leaf, &driven, faults);
    }
    for supply in outlook.supplies() {
        outlook.look_for_shortage(supply, faults);
    }
}

struct Outlook<'a> {
    mission: &'a MissionSpec,
    spans: &'a [SourceSpan],
}

/// What behaviors keep for good: a resource, or any of a type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Supply {
    One(ResourceId),
    Any(TypeId),
}

/// How many of a supply a node needs at once at least, how many more are kept when it is done, and how many of these
/// are still empty, so that whoever inherits them needs no other.
#[derive(Debug, Clone, Copy, Default)]
struct Demand {
    peak: i64,
    net: i64,
    spare: i64,
}

impl Outlook<'_> {
    fn behavior(&self, leaf: NodeId) -> &BehaviorSpec {
        self.mission.tree.behavior(leaf).expect("leaves have behaviors")
    }

    fn warn(&self, node: NodeId, message: String, help: &str, faults: &mut Faults) {
        let name = self.mission.names.node(node);
        faults.warn(self.spans[node.index()], name, message, Some(help.to_owned()));
    }

    /// An intention lives only while a THEN that is not complete holds it.
    fn look_for_heirs(&self, leaf: NodeId, faults: &mut Faults) {
        let tree = &self.mission.tree;
        let keeps = |claim: &Claim| matches!(claim.keep, Retention::Intention(_));
        let parent = tree.topology.parent(leaf);
        let is_loose = matches!(tree.nodes[parent.index()], NodeKind::And | NodeKind::Or);
        if !is_loose || !self.behavior(leaf).claims.iter().any(keeps) {
            return;
        }
        let mut node = leaf;
        while node.0 > 0 {
            let parent = tree.topology.parent(node);
            let has_heirs = tree.topology.end(node) < tree.topology.end(parent);
            if matches!(tree.nodes[parent.index()], NodeKind::Then) && has_heirs {
                return;
            }
            node = parent;
        }
        let message = "nobody inherits what it keeps: other behaviors may undo it at once".to_owned();
        self.warn(leaf, message, "put it in a `then`, before what it is done for", faults);
    }

    /// What behaviors claim that move the base.
    fn driven(&self) -> BTreeSet<ResourceId> {
        let leaves = self.mission.tree.leaves().map(|leaf| self.behavior(leaf));
        let drivers = leaves.filter(|behavior| {
            let drives = behavior.commands.iter().any(|term| matches!(term.task, Task::DriveTo(_)));
            drives || behavior.effects.iter().any(|effect| matches!(effect, EffectTerm::Stands(_)))
        });
        drivers.flat_map(|behavior| &behavior.claims).filter_map(|claim| self.resource(claim)).collect()
    }

    /// The one resource that a claim can get.
    fn resource(&self, claim: &Claim) -> Option<ResourceId> {
        match self.supply(claim)? {
            Supply::One(resource) => Some(resource),
            Supply::Any(_) => None,
        }
    }

    /// Who must stand somewhere to begin and does not claim what drives may be driven away.
    fn look_for_a_base_that_leaves(&self, leaf: NodeId, driven: &BTreeSet<ResourceId>, faults: &mut Faults) {
        let behavior = self.behavior(leaf);
        let claims_it = behavior.claims.iter().any(|claim| self.resource(claim).is_some_and(|id| driven.contains(&id)));
        if driven.is_empty() || claims_it || !must_stand(&behavior.precondition) {
            return;
        }
        let message = "it must stand somewhere and does not claim the base, which may drive away meanwhile".to_owned();
        self.warn(leaf, message, "claim `{type: base, shared: at $place}`", faults);
    }

    /// Every fact as some behavior makes it.
    fn brought(&self) -> BTreeSet<(FactId, bool)> {
        let effects = self.mission.tree.leaves().flat_map(|leaf| &self.behavior(leaf).effects);
        let facts = effects.filter_map(|effect| match effect {
            EffectTerm::Fact(fact, holds) => Some((*fact, *holds)),
            EffectTerm::Lies(..) | EffectTerm::Taken(..) | EffectTerm::Stands(_) => None,
        });
        facts.collect()
    }

    fn look_for_facts(&self, leaf: NodeId, brought: &BTreeSet<(FactId, bool)>, faults: &mut Faults) {
        let mut needed = Vec::new();
        facts(&self.behavior(leaf).precondition, &mut needed);
        for (fact, holds) in needed {
            let is_so = self.mission.start.facts[fact.index()] == holds;
            if is_so || brought.contains(&(fact, holds)) {
                continue;
            }
            let (fact, verb) = (self.mission.names.fact(fact), if holds { "sets" } else { "clears" });
            let message = format!("it can never run: no behavior {verb} \"{fact}\"");
            self.warn(leaf, message, "see `facts` of the world and `effects` of the behaviors", faults);
        }
    }

    /// What is kept physically by any behavior.
    fn supplies(&self) -> BTreeSet<Supply> {
        let claims = self.mission.tree.leaves().flat_map(|leaf| &self.behavior(leaf).claims);
        claims.filter(|claim| keeps_alone(claim)).filter_map(|claim| self.supply(claim)).collect()
    }

    fn supply(&self, claim: &Claim) -> Option<Supply> {
        let robot = &self.mission.robot;
        match claim.selector {
            Selector::Named(resource) | Selector::Empty { resource, .. } => Some(Supply::One(resource)),
            Selector::Any(of) | Selector::AnyEmpty { of, .. } => {
                let mut all = robot.of_type(of);
                Some(match (all.next(), all.next()) {
                    (Some(only), None) => Supply::One(only),
                    (_, _) => Supply::Any(of),
                })
            }
            Selector::Holding(_) => None,
        }
    }

    fn count(&self, supply: Supply) -> i64 {
        match supply {
            Supply::One(_) => 1,
            Supply::Any(of) => self.mission.robot.of_type(of).count() as i64,
        }
    }

    /// Needs that the robot cannot meet, each told at the smallest node that has it.
    fn look_for_shortage(&self, supply: Supply, faults: &mut Faults) {
        let tree = &self.mission.tree;
        let is_taker = self.is_taker(supply);
        let mut demands = vec![Demand::default(); tree.nodes.len()];
        let mut is_told = vec![false; tree.nodes.len()];
        for node in (0..tree.nodes.len()).rev().map(NodeId::from) {
            let children: Vec<NodeId> = tree.topology.children(node).collect();
            let below: Vec<Demand> = children.iter().map(|child| demands[child.index()]).collect();
            demands[node.index()] = match &tree.nodes[node.index()] {
                NodeKind::Behavior(behavior) => self.demand(behavior, supply, is_taker),
                NodeKind::Then => in_order(&below),
                NodeKind::And | NodeKind::Root => in_any_order(&below),
                NodeKind::Or => either(&below),
            };
            let is_told_below = children.iter().any(|child| is_told[child.index()]);
            is_told[node.index()] = is_told_below;
            if !is_told_below && demands[node.index()].peak > self.count(supply) {
                is_told[node.index()] = true;
                self.tell_shortage(supply, node, demands[node.index()].peak, faults);
            }
        }
    }

    /// Whether some behavior takes an object with one of a supply.
    fn is_taker(&self, supply: Supply) -> bool {
        self.mission.tree.leaves().map(|leaf| self.behavior(leaf)).any(|behavior| {
            let mut takers = behavior.effects.iter().filter_map(|effect| match effect {
                EffectTerm::Taken(_, claim) => Some(&behavior.claims[*claim]),
                EffectTerm::Lies(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => None,
            });
            takers.any(|claim| self.supply(claim) == Some(supply))
        })
    }

    fn demand(&self, behavior: &BehaviorSpec, supply: Supply, is_taker: bool) -> Demand {
        let mut demand = Demand::default();
        for (index, claim) in behavior.claims.iter().enumerate() {
            let takes = |effect: &EffectTerm| matches!(effect, EffectTerm::Taken(_, by) if *by == index);
            match claim.selector {
                // What is held was kept before, for all that is known of what takes things.
                Selector::Holding(_) => demand.net -= i64::from(is_taker && claim.keep == Retention::Release),
                // One that was kept before will do, whatever it holds.
                Selector::Named(_) | Selector::Any(_) if !keeps_alone(claim) => {}
                Selector::Named(_) | Selector::Empty { .. } | Selector::Any(_) | Selector::AnyEmpty { .. } => {
                    let is_of_it = self.supply(claim) == Some(supply);
                    let is_spare = is_of_it && keeps_alone(claim) && !behavior.effects.iter().any(takes);
                    demand.spare += i64::from(is_spare);
                    demand.peak += i64::from(is_of_it);
                    demand.net += i64::from(is_of_it && keeps_alone(claim));
                }
            }
        }
        demand
    }

    fn tell_shortage(&self, supply: Supply, node: NodeId, needed: i64, faults: &mut Faults) {
        let names = &self.mission.names;
        let keepers: Vec<&str> = self.keepers(supply, node).into_iter().map(|leaf| names.node(leaf)).collect();
        match (supply, keepers.as_slice(), &self.mission.tree.nodes[node.index()]) {
            (Supply::One(resource), [one, other, ..], NodeKind::And) => {
                let resource = names.resource(resource);
                let message = format!(
                    "`{one}` and `{other}` can only ever exclude each other: whichever comes first keeps {resource} for good"
                );
                let help = "give it back between the two, as `place` does, or claim another resource".to_owned();
                faults.push(self.spans[node.index()], names.node(node), message, Some(help));
            }
            (supply, ..) => {
                let what = match supply {
                    Supply::One(resource) => names.resource(resource).to_owned(),
                    Supply::Any(of) => names.ty(of).to_owned(),
                };
                let has = self.count(supply);
                let message = format!("it must run out: {needed} of `{what}` would be in use, and the robot has {has}");
                self.warn(node, message, "give some back in between, as `place` does", faults);
            }
        }
    }

    /// Behaviors below a node that keep some of a supply for good.
    fn keepers(&self, supply: Supply, node: NodeId) -> Vec<NodeId> {
        let keeps = |claim: &Claim| keeps_alone(claim) && self.supply(claim) == Some(supply);
        let below = self.mission.tree.leaves().filter(|&leaf| self.mission.tree.topology.is_within(leaf, node));
        below.filter(|&leaf| self.behavior(leaf).claims.iter().any(keeps)).collect()
    }
}

/// Whether a claim keeps for good what nobody else can then use.
fn keeps_alone(claim: &Claim) -> bool {
    matches!(claim.keep, Retention::Physical(Access::Exclusive))
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

/// Whether a condition says where the base stands.
fn must_stand(condition: &Condition) -> bool {
    match condition {
        Condition::All(parts) => parts.iter().any(must_stand),
        Condition::At { .. } => true,
        Condition::Never | Condition::Path { .. } | Condition::Held(_) | Condition::Free(_) => false,
        Condition::Lies(..) | Condition::Fact(..) => false,
    }
}

/// Every fact that a condition needs, and how.
fn facts(condition: &Condition, needed: &mut Vec<(FactId, bool)>) {
    match condition {
        Condition::All(parts) => parts.iter().for_each(|part| facts(part, needed)),
        Condition::Fact(fact, holds) => needed.push((*fact, *holds)),
        Condition::Never | Condition::At { .. } | Condition::Path { .. } => {}
        Condition::Held(_) | Condition::Free(_) | Condition::Lies(..) => {}
    }
}
