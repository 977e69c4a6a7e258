//! When an intention lapses, and when a THEN goes back (`semantics` 2).

use std::collections::{BTreeMap, BTreeSet};

use crate::behavior;
use crate::world::{KnownPaths, View};
use ambidex_model::state::State;
use ambidex_model::{Blocked, Cause, Claim, LeaseKind, Lineage, NodeId, Reason, Reopened, Retention, TreeSpec};

/// What root knows at the end of a round.
pub(super) struct LapseCheck<'a> {
    pub(super) tree: &'a TreeSpec,
    pub(super) view: &'a View,
    /// The state with this round's grants.
    pub(super) state: &'a State,
    pub(super) refused: &'a BTreeMap<NodeId, Reason>,
}

impl LapseCheck<'_> {
    /// The last intention lease in tree order for which waiting would not help, if there is one.
    pub(super) fn lapse(&self) -> Option<Reopened> {
        let intentions = self.state.table().leases().filter(|(_, lease)| lease.kind == LeaseKind::Intention);
        let mut lapsing: Vec<_> = intentions
            .filter_map(|(resource, lease)| {
                let lacks = self.lacks(lease.holder)?;
                Some((lease.holder, lease.behavior, resource, lacks))
            })
            .collect();
        lapsing.sort_by_key(|(holder, behavior, resource, _)| (*holder, *behavior, *resource));
        let (holder, leaf, resource, lacks) = lapsing.pop()?;
        let cause = Cause::Lapse { resource, heir: Box::new(lacks) };
        Some(Reopened { node: leaf, up_to: holder, cause, undecided: Vec::new() })
    }

    /// The first heir below a holder with what it lacks; none while an heir runs or waits for something that runs.
    fn lacks(&self, holder: NodeId) -> Option<Blocked> {
        let below = holder..self.tree.topology.end(holder);
        if self.state.is_busy(holder) {
            return None;
        }
        let heirs = || self.refused.range(below.clone());
        if heirs().any(|(_, reason)| self.can_wait(reason)) {
            return None;
        }
        let wanting = heirs().find(|(_, reason)| **reason != Reason::Satisfied).or_else(|| heirs().next());
        wanting.map(|(&leaf, reason)| Blocked { leaf, reason: reason.clone() })
    }

    /// Whether it was refused for what a running behavior holds, so that waiting may help.
    fn can_wait(&self, reason: &Reason) -> bool {
        let runs_on = |resource| self.state.table().resource(resource).is_running();
        match reason {
            Reason::Held { resource, .. } => runs_on(*resource),
            // Root may bind the other request to another resource than the AND that compared the two.
            Reason::Outbid { resource, by, .. } => runs_on(*resource) || self.state.running().contains_key(by),
            Reason::NoneFree { of } | Reason::TooFew { of, .. } | Reason::NothingAvailable { of } => {
                self.view.mission.robot.of_type(*of).any(runs_on)
            }
            Reason::SameObject { with: by, .. }
            | Reason::Clash { with: by }
            | Reason::WholeRobot { by }
            | Reason::Outdone { by }
            | Reason::Driving { by } => self.state.running().contains_key(by),
            Reason::BackingOff { .. } => true,
            Reason::Satisfied
            | Reason::Unwanted
            | Reason::Unavailable { .. }
            | Reason::Missing { .. }
            | Reason::OutOfReach { .. }
            | Reason::NotHeld { .. }
            | Reason::Taken { .. }
            | Reason::Elsewhere { .. }
            | Reason::NotAt { .. }
            | Reason::NoPath { .. }
            | Reason::PathNotFound { .. }
            | Reason::Fact { .. }
            | Reason::AlreadyDone { .. }
            | Reason::Alternative { .. }
            | Reason::NotItsTurn { .. }
            | Reason::Ending { .. } => false,
        }
    }

    /// The first THEN in tree order with an earlier child that kept an intention and no longer meets its goal, and the
    /// last such behavior.
    pub(super) fn redo(&self) -> Option<Reopened> {
        let keepers = self.keepers();
        let no_longer_met = |leaf: NodeId| {
            let spec = self.tree.behavior(leaf).expect("behaviors keep leases");
            let line = Lineage { topology: &self.tree.topology, node: leaf, skips: &[] };
            !behavior::is_satisfied(spec, self.view, &line, &mut KnownPaths::default())
        };
        let is_earlier = |holder: NodeId, leaf| {
            let mut activated = self.refused.range(holder..self.tree.topology.end(holder));
            activated.next().is_some_and(|(&first, _)| leaf < first)
        };
        let is_lost = |&(holder, leaf): &(NodeId, NodeId)| is_earlier(holder, leaf) && no_longer_met(leaf);
        let (first, _) = keepers.iter().copied().find(is_lost)?;
        // Of several the last: what the earlier ones were done for has been done since.
        let mut of_first = keepers.range((first, NodeId(0))..=(first, NodeId(u32::MAX)));
        let (holder, leaf) = of_first.rfind(|&keeper| is_lost(keeper)).copied()?;
        Some(Reopened { node: leaf, up_to: holder, cause: Cause::Redo, undecided: Vec::new() })
    }

    /// THEN and behavior below it that kept an intention for it, or was skipped as if it had.
    fn keepers(&self) -> BTreeSet<(NodeId, NodeId)> {
        let keeps = |claim: &Claim| matches!(claim.keep, Retention::Intention(_));
        let is_keeper = |leaf: &NodeId| self.tree.behavior(*leaf).is_some_and(|spec| spec.claims.iter().any(keeps));
        let kept = self.state.kept_for().iter().filter(|(leaf, _)| is_keeper(leaf));
        kept.map(|(&leaf, &then)| (then, leaf)).collect()
    }
}
