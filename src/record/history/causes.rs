//! What keeps a run from going on: the leaves behind which all others wait.

use std::collections::BTreeSet;

use ambidex_model::{NodeId, Reason};

use super::{History, LeafState};

impl History {
    /// The leaves that cannot run for a reason of their own, in tree order; what only waits for one of them is not
    /// among them.
    pub fn causes(&self) -> Vec<(NodeId, Reason)> {
        let is_waiting = |leaf: &NodeId| matches!(self.state(*leaf), LeafState::Waiting | LeafState::Failed);
        let reasons = self.leaves().filter(is_waiting).filter_map(|leaf| Some((leaf, self.reason(leaf)?)));
        let reasons: Vec<(NodeId, Reason)> = reasons.filter(|(_, reason)| *reason != Reason::Satisfied).collect();
        let own = reasons.iter().filter(|(_, reason)| waits_for(reason).is_none());
        let mut known: BTreeSet<NodeId> = own.map(|(leaf, _)| *leaf).collect();
        // What waits for a node of which nothing else is told is the next that one can tell.
        for (leaf, reason) in &reasons {
            if waits_for(reason).is_some_and(|node| !self.is_of(node, &known)) {
                known.insert(*leaf);
            }
        }
        reasons.into_iter().filter(|(leaf, _)| known.contains(leaf)).collect()
    }

    /// Whether one of these is a node or below it.
    fn is_of(&self, node: NodeId, known: &BTreeSet<NodeId>) -> bool {
        let topology = &self.states.topology;
        topology.has(node) && topology.of_set(node, known).next().is_some()
    }
}

/// The node that keeps a leaf waiting, where the reason is no more than that.
fn waits_for(reason: &Reason) -> Option<NodeId> {
    match reason {
        Reason::NotItsTurn { after } => Some(*after),
        Reason::Outdone { by } => Some(*by),
        Reason::Alternative { chosen } => Some(*chosen),
        Reason::AlreadyDone { heir, .. } => Some(*heir),
        Reason::Ending { failed } => Some(*failed),
        Reason::OutOfTime { node } | Reason::GivenUp { node } => Some(*node),
        Reason::Satisfied
        | Reason::Held { .. }
        | Reason::Unavailable { .. }
        | Reason::Unfit { .. }
        | Reason::BackingOff { .. }
        | Reason::NoneFree { .. }
        | Reason::TooFew { .. }
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
        | Reason::Driving { .. }
        | Reason::NoPath { .. }
        | Reason::InTheWay { .. }
        | Reason::PathNotFound { .. }
        | Reason::Fact { .. }
        | Reason::Unwanted
        | Reason::NothingAvailable { .. }
        | Reason::Outbid { .. }
        | Reason::LessUrgent { .. }
        | Reason::DoneOftener { .. }
        | Reason::Reserved { .. }
        | Reason::TooEarly { .. }
        | Reason::NotYet { .. }
        | Reason::SameObject { .. }
        | Reason::Clash { .. }
        | Reason::WouldDeadlock { .. }
        | Reason::WholeRobot { .. } => None,
    }
}
