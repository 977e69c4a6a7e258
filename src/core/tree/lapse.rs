//! When an intention lapses (`semantics` 2).

use super::reopening::RoundEnd;
use ambidex_model::{Blocked, Cause, LeaseKind, NodeId, Reason, Reopened};

impl RoundEnd<'_> {
    /// The last intention lease in tree order for which waiting would not help, if there is one.
    pub(super) fn lapse(&self) -> Option<Reopened> {
        let intentions = self.view.state.table().leases().filter(|(_, lease)| lease.kind == LeaseKind::Intention);
        let mut lapsing: Vec<_> = intentions
            .filter_map(|(resource, lease)| {
                let lacks = self.lacks(lease.holder)?;
                Some((lease.holder, lease.behavior, resource, lacks))
            })
            .collect();
        lapsing.sort_by_key(|(holder, behavior, resource, _)| (*holder, *behavior, *resource));
        let (holder, leaf, resource, lacks) = lapsing.pop()?;
        let cause = Cause::Lapse { resource, heir: Box::new(lacks) };
        Some(Reopened::new(leaf, holder, cause))
    }

    /// The first heir below a holder with what it lacks; none while an heir runs or waits for something that runs.
    fn lacks(&self, holder: NodeId) -> Option<Blocked> {
        if self.view.state.is_busy(holder) {
            return None;
        }
        // Task nodes may have a word of their own.
        let is_leaf = |(node, _): &(NodeId, &Reason)| self.view.mission.tree.behavior(*node).is_some();
        let topology = self.view.state.topology();
        let heirs = || topology.within(holder, self.refused).filter(is_leaf);
        if heirs().any(|(_, reason)| self.can_wait(reason)) {
            return None;
        }
        let wanting = heirs().find(|(_, reason)| **reason != Reason::Satisfied).or_else(|| heirs().next());
        wanting.map(|(leaf, reason)| Blocked { leaf, reason: reason.clone() })
    }

    /// Whether it was refused for what a running behavior holds, so that waiting may help.
    fn can_wait(&self, reason: &Reason) -> bool {
        let state = &self.view.state;
        let runs_on = |resource| state.table().resource(resource).is_running();
        match reason {
            Reason::Held { resource, .. } => runs_on(*resource),
            // Root may bind the other request to another resource than the AND that compared the two.
            Reason::Outbid { resource, by, .. }
            | Reason::LessUrgent { resource, by, .. }
            | Reason::DoneOftener { resource, by, .. } => runs_on(*resource) || state.running().contains_key(by),
            Reason::Reserved { .. } | Reason::TooEarly { .. } => !state.running().is_empty(),
            Reason::NoneFree { of } | Reason::TooFew { of, .. } | Reason::NothingAvailable { of } => {
                self.view.mission.robot.of_type(*of).any(runs_on)
            }
            Reason::SameObject { with: by, .. }
            | Reason::Clash { with: by, .. }
            | Reason::WholeRobot { by }
            | Reason::Outdone { by }
            | Reason::Driving { by } => state.running().contains_key(by),
            Reason::BackingOff { .. } => true,
            Reason::WouldDeadlock { .. } => !state.running().is_empty(),
            Reason::Satisfied
            | Reason::Unwanted
            | Reason::Unavailable { .. }
            | Reason::Unfit { .. }
            | Reason::Missing { .. }
            | Reason::OutOfReach { .. }
            | Reason::OutOfReachLater { .. }
            | Reason::Unreachable { .. }
            | Reason::NoSpot { .. }
            | Reason::NotHeld { .. }
            | Reason::Misheld(_)
            | Reason::Taken { .. }
            | Reason::Elsewhere { .. }
            | Reason::Nowhere { .. }
            | Reason::NotAt { .. }
            | Reason::NoPath { .. }
            | Reason::InTheWay { .. }
            | Reason::PathNotFound { .. }
            | Reason::Fact { .. }
            | Reason::AlreadyDone { .. }
            | Reason::Alternative { .. }
            | Reason::NotItsTurn { .. }
            | Reason::Ending { .. }
            | Reason::NotYet { .. }
            | Reason::GivenUp { .. }
            | Reason::OutOfTime { .. } => false,
        }
    }
}
