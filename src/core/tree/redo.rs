//! Undone work is done again: a behavior whose precondition is not met any more sends back the one that made it so
//! (`semantics` 2).

use super::ordering::Ordering;
use super::reopening::RoundEnd;
use crate::behavior;
use ambidex_model::{Cause, Kept, LeaseKind, NodeId, Reason, Reopened};

impl RoundEnd<'_> {
    /// The first blocked leaf in tree order for which something earlier can be done again, and the nearest such thing.
    pub(super) fn redo(&self) -> Option<Reopened> {
        self.refused.iter().filter(|(_, reason)| is_of_precondition(reason)).find_map(|(&leaf, reason)| {
            let (node, up_to) = self.sent_back_by(leaf, reason)?;
            let ended = self.kept_below(up_to);
            Some(Reopened { node, up_to, cause: Cause::Redo { leaf }, undecided: Vec::new(), ended })
        })
    }

    /// What was kept for nodes below a THEN.
    fn kept_below(&self, then: NodeId) -> Vec<Kept> {
        let is_below = |holder| holder != then && self.view.state.topology().is_within(holder, then);
        let leases = self.view.state.table().leases();
        let kept = leases.filter(|(_, lease)| lease.kind == LeaseKind::Intention && is_below(lease.holder));
        kept.map(|(resource, lease)| Kept { resource, holder: lease.holder, behavior: lease.behavior }).collect()
    }

    /// The nearest earlier behavior of a THEN above a leaf that makes so what the leaf lacks, and that THEN.
    fn sent_back_by(&self, leaf: NodeId, reason: &Reason) -> Option<(NodeId, NodeId)> {
        let tree = &self.view.mission.tree;
        let lacking = behavior::lacking(tree.behavior(leaf)?, self.view, leaf, reason)?;
        let mut child = leaf;
        for node in tree.topology.path(leaf).skip(1) {
            if Ordering::of(&tree.nodes[node.index()]) == Some(Ordering::Then) {
                // Backwards through what stands before the leaf in this THEN.
                let earlier = (node.0 + 1..child.0).rev().map(NodeId);
                let makes_it_so = |earlier: &NodeId| {
                    let spec = tree.behavior(*earlier).filter(|_| self.view.state.is_done(*earlier));
                    spec.is_some_and(|spec| behavior::makes_so(spec, lacking)) && self.is_on_its_way(*earlier, node)
                };
                if let Some(maker) = earlier.into_iter().find(makes_it_so) {
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
        let below = then..state.topology().end(then);
        let is_idle = !state.is_busy(then) && !state.waits().iter().any(|(_, leaf)| below.contains(leaf));
        !was && is_idle
    }
}

/// Whether a reason can be that of a precondition that something could make true again.
fn is_of_precondition(reason: &Reason) -> bool {
    match reason {
        Reason::NotAt { .. }
        | Reason::NotHeld { .. }
        | Reason::Taken { .. }
        | Reason::Elsewhere { .. }
        | Reason::Fact { .. } => true,
        Reason::Satisfied
        | Reason::Held { .. }
        | Reason::NoneFree { .. }
        | Reason::TooFew { .. }
        | Reason::Missing { .. }
        | Reason::OutOfReach { .. }
        | Reason::Driving { .. }
        | Reason::NoPath { .. }
        | Reason::PathNotFound { .. }
        | Reason::Unavailable { .. }
        | Reason::BackingOff { .. }
        | Reason::Unwanted
        | Reason::NothingAvailable { .. }
        | Reason::AlreadyDone { .. }
        | Reason::Outbid { .. }
        | Reason::Outdone { .. }
        | Reason::SameObject { .. }
        | Reason::Clash { .. }
        | Reason::Alternative { .. }
        | Reason::WholeRobot { .. }
        | Reason::WouldDeadlock { .. }
        | Reason::NotItsTurn { .. }
        | Reason::Ending { .. } => false,
    }
}
