//! What a mission must come to, seen before it runs: what cannot be done, and what is legal but surely not meant.
//!
//! One check per file; what is wrong with a single value was told when that was read.

mod deadlock;
mod heirs;
mod infeasible;
mod shortage;
mod stands;

use crate::document::SourceSpan;
use crate::fault::Faults;
use ambidex_model::{Access, BehaviorSpec, Claim, MissionSpec, NodeId, ResourceId, Retention, Selector, TypeId};

/// The top of the task.
const TOP: NodeId = NodeId(1);

/// What is checked, of all that a robot may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// All of it.
    Mission,
    /// A task beside others that nobody knows here.
    Task,
    /// A part of a task: what comes before it and stands beside it nobody knows here.
    Branch,
}

/// Checks a mission, or a task as if it were one; `spans` has the place of each node below root.
pub(crate) fn check(mission: &MissionSpec, spans: &[SourceSpan], part: Part, faults: &mut Faults) {
    let seen = Seen { mission, spans, part };
    heirs::check(&seen, faults);
    stands::check(&seen, faults);
    if part != Part::Branch {
        infeasible::check(&seen, faults);
    }
    if !shortage::check(&seen, faults) && part != Part::Branch {
        deadlock::check(&seen, faults);
    }
}

/// A mission as the checks see it.
struct Seen<'a> {
    mission: &'a MissionSpec,
    spans: &'a [SourceSpan],
    part: Part,
}

/// What behaviors keep for good: a resource, or any of a type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Supply {
    One(ResourceId),
    Any(TypeId),
}

impl Seen<'_> {
    fn behavior(&self, leaf: NodeId) -> &BehaviorSpec {
        self.mission.tree.behavior(leaf).expect("leaves have behaviors")
    }

    fn behaviors(&self) -> impl Iterator<Item = &BehaviorSpec> {
        self.mission.tree.leaves().map(|leaf| self.behavior(leaf))
    }

    fn warn(&self, node: NodeId, message: String, help: &str, faults: &mut Faults) {
        let name = self.mission.names.node(node);
        faults.warn((self.span(node), name), message, Some(help.to_owned()));
    }

    /// Where a node stands; root where its task does.
    fn span(&self, node: NodeId) -> SourceSpan {
        self.spans[node.index().saturating_sub(1)]
    }

    /// What a claim takes from; none for what holds an object, since that depends on who took it.
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
            Selector::Holding { .. } => None,
        }
    }

    /// The one resource that a claim can get.
    fn resource(&self, claim: &Claim) -> Option<ResourceId> {
        match self.supply(claim)? {
            Supply::One(resource) => Some(resource),
            Supply::Any(_) => None,
        }
    }
}

/// Whether a claim keeps for good what nobody else can then use.
fn keeps_alone(claim: &Claim) -> bool {
    matches!(claim.keep, Retention::Physical(Access::Exclusive))
}
