//! Undone work is done again: a behavior whose precondition is not met any more sends back the one that made it so
//! (`semantics` 2).

use super::ordering::Ordering;
use super::reopening::RoundEnd;
use crate::behavior;
use ambidex_model::{Cause, Condition, Kept, LeaseKind, Misheld, NodeId, Reason, Reopened};

impl RoundEnd<'_> {
    /// Leaves in tree order that are blocked by what they lack of their precondition, each with that.
    pub(super) fn lacking(&self) -> impl Iterator<Item = (NodeId, &Condition)> {
        let blocked = self.refused.iter().filter(|(_, reason)| is_of_precondition(reason));
        blocked.filter_map(|(&leaf, reason)| {
            let spec = self.view.behavior(leaf)?;
            Some((leaf, behavior::lacking(spec, self.view, leaf, reason)?))
        })
    }

    /// The nearest earlier thing that can be done again for a leaf that lacks something.
    pub(super) fn redo(&self, leaf: NodeId, lacking: &Condition) -> Option<Reopened> {
        let (node, up_to) = self.sent_back_by(leaf, lacking)?;
        let ended = self.kept_below(up_to);
        Some(Reopened { ended, ..Reopened::new(node, up_to, Cause::Redo { leaf }) })
    }

    /// What was kept for nodes below a THEN.
    fn kept_below(&self, then: NodeId) -> Vec<Kept> {
        let is_below = |holder| holder != then && self.view.state.topology().is_within(holder, then);
        let leases = self.view.state.table().leases();
        let kept = leases.filter(|(_, lease)| lease.kind == LeaseKind::Intention && is_below(lease.holder));
        kept.map(|(resource, lease)| Kept { resource, holder: lease.holder, behavior: lease.behavior }).collect()
    }

    /// The nearest earlier behavior of a THEN above a leaf that makes so what the leaf lacks, and that THEN.
    fn sent_back_by(&self, leaf: NodeId, lacking: &Condition) -> Option<(NodeId, NodeId)> {
        let tree = &self.view.mission.tree;
        let mut child = leaf;
        for node in tree.topology.path(leaf).skip(1) {
            // A cleanup sends back nobody but its own.
            if tree.topology.is_cleanup(child) {
                return None;
            }
            if Ordering::of(&tree.nodes[node.index()]) == Some(Ordering::Then) {
                // Backwards through what stands before the leaf in this THEN.
                let topology = &tree.topology;
                let before = topology.children(node).take_while(|earlier| *earlier != child);
                let before: Vec<NodeId> = before.flat_map(|earlier| topology.nodes_below(earlier)).collect();
                let mut earlier = before.into_iter().rev();
                let makes_it_so = |earlier: &NodeId| {
                    let spec = self.view.behavior(*earlier).filter(|_| self.view.state.is_done(*earlier));
                    spec.is_some_and(|spec| behavior::makes_so(spec, lacking)) && self.is_on_its_way(*earlier, node)
                };
                if let Some(maker) = earlier.find(makes_it_so) {
                    return self.can_go_back(maker, node).then_some((maker, node));
                }
            }
            child = node;
        }
        None
    }

    /// Whether every OR between a behavior and a node above it has chosen the way to it.
    fn is_on_its_way(&self, leaf: NodeId, up_to: NodeId) -> bool {
        let tree = &self.view.mission.tree;
        let path: Vec<NodeId> = tree.topology.path(leaf).take_while(|node| *node >= up_to).collect();
        path.windows(2).all(|pair| {
            let is_or = Ordering::of(&tree.nodes[pair[1].index()]) == Some(Ordering::Or);
            !is_or || self.view.state.status(pair[1]).way == Some(pair[0])
        })
    }

    /// Once in each progress, and not while something of the THEN runs or waits.
    fn can_go_back(&self, leaf: NodeId, then: NodeId) -> bool {
        let state = &self.view.state;
        let was = state.redone().get(&leaf).is_some_and(|redone| redone.progress == state.progress());
        !was && self.is_idle(then)
    }

    /// Whether nothing at or below a node runs or waits after a failure.
    pub(super) fn is_idle(&self, node: NodeId) -> bool {
        let state = &self.view.state;
        !state.is_busy(node) && !state.waits().iter().any(|(_, waiting)| state.topology().is_within(*waiting, node))
    }
}

/// Whether a reason can be that of a precondition that something could make true again.
fn is_of_precondition(reason: &Reason) -> bool {
    match reason {
        Reason::NotAt { .. }
        | Reason::Nowhere { .. }
        | Reason::NotHeld { .. }
        | Reason::Misheld(Misheld::NotSo { .. })
        | Reason::Taken { .. }
        | Reason::Elsewhere { .. }
        | Reason::NoPath { .. }
        | Reason::InTheWay { .. }
        | Reason::PathNotFound { .. }
        | Reason::Fact { .. } => true,
        Reason::Satisfied
        | Reason::Held { .. }
        | Reason::NoneFree { .. }
        | Reason::TooFew { .. }
        | Reason::Missing { .. }
        | Reason::OutOfReach { .. }
        | Reason::OutOfReachLater { .. }
        | Reason::Unreachable { .. }
        | Reason::NoSpot { .. }
        | Reason::Misheld(Misheld::Too { .. } | Misheld::Last { .. } | Misheld::Full { .. })
        | Reason::Driving { .. }
        | Reason::Unavailable { .. }
        | Reason::Unfit { .. }
        | Reason::BackingOff { .. }
        | Reason::Unwanted
        | Reason::NothingAvailable { .. }
        | Reason::AlreadyDone { .. }
        | Reason::Outbid { .. }
        | Reason::Outdone { .. }
        | Reason::LessUrgent { .. }
        | Reason::DoneOftener { .. }
        | Reason::SameObject { .. }
        | Reason::Clash { .. }
        | Reason::Alternative { .. }
        | Reason::WholeRobot { .. }
        | Reason::WouldDeadlock { .. }
        | Reason::NotItsTurn { .. }
        | Reason::Ending { .. }
        | Reason::Reserved { .. }
        | Reason::TooEarly { .. }
        | Reason::NotYet { .. }
        | Reason::GivenUp { .. }
        | Reason::OutOfTime { .. } => false,
    }
}
