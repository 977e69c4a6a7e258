//! Who fails, who waits for that, and who finishes what it can (`semantics` 6).

use std::collections::BTreeSet;

use ambidex::model::{Consequences, Failing, Fault, MissionEnd, NodeId, NodeKind, Reason};

use super::{Model, Step, TOP};

/// What a failure comes to.
#[derive(Debug, Default)]
pub(super) struct Fall {
    /// The topmost node that has failed for good.
    pub failed: Option<NodeId>,
    /// The lowest node that begins to fail, once all is settled.
    pub failing: Option<Failing>,
    /// The node whose cleanup is over.
    pub cleaned: Option<NodeId>,
    /// Nodes that were failing before.
    before: BTreeSet<NodeId>,
    /// The node that is tried again.
    pub again: Option<(NodeId, Fault)>,
}

impl Model<'_> {
    /// Before anything fails.
    pub(super) fn no_fall(&self) -> Fall {
        Fall { before: self.failing.keys().copied().collect(), ..Fall::default() }
    }

    /// A node has failed for good; none for the fault where it never could run.
    pub(super) fn fail(&mut self, node: NodeId, cause: NodeId, fault: Option<Fault>, fall: &mut Fall) {
        self.failed.insert(node);
        if let Some(fault) = fault {
            self.faults.insert(node, fault);
        }
        fall.failed = Some(node);
        if node == TOP {
            self.end = self.ending.is_none().then(|| self.failed_at(cause));
            return;
        }
        let parent = self.parent(node);
        let failing = Failing { node: parent, child: node, cause, fault, finishes: false };
        match self.kind(parent) {
            NodeKind::Cleanup if node != self.body(parent) => self.end_cleanup(parent, fall),
            NodeKind::Cleanup => {
                // A body that did what it could has failed for good now.
                let before = self.failing.remove(&parent);
                fall.before.remove(&parent);
                let failing =
                    before.map_or(failing, |before| Failing { node: parent, child: node, finishes: false, ..before });
                self.begin_to_fail(failing, fall);
            }
            NodeKind::Or => {
                if self.committed.get(&parent) == Some(&node) {
                    self.committed.remove(&parent);
                }
                if self.children(parent).iter().all(|child| self.failed.contains(child)) {
                    self.begin_to_fail(failing, fall);
                }
            }
            NodeKind::And | NodeKind::Tasks => {
                let finishes = !self.can_win(parent, fault);
                self.begin_to_fail(Failing { finishes, ..failing }, fall);
            }
            NodeKind::Then => self.begin_to_fail(failing, fall),
            NodeKind::Root | NodeKind::Behavior(_) => unreachable!("has no failing child"),
        }
    }

    /// As a mission ends that failed at a node.
    pub(super) fn failed_at(&self, cause: NodeId) -> MissionEnd {
        if let Some(Reason::Unavailable { resource, .. }) = self.infeasible.get(&cause)
            && let Some(id) = self.mission.robot.resources[resource.index()].controller
        {
            return MissionEnd::ControllerLost(id);
        }
        MissionEnd::Failed(cause)
    }

    /// What failed first counts.
    pub(super) fn begin_to_fail(&mut self, failing: Failing, fall: &mut Fall) {
        let node = failing.node;
        // What is given up stays so until all there is cleaned up.
        if self.is_given_up(node) {
            return;
        }
        let is_new = !self.failing.contains_key(&node);
        self.failing.entry(node).or_insert(failing);
        if is_new && failing.finishes && !self.has_ended(failing) {
            self.finish_above(failing);
        }
        self.end_failing(node, fall);
    }

    /// All that is above it can be complete no more, and does the same.
    fn finish_above(&mut self, failing: Failing) {
        for pair in self.within(failing.node).windows(2) {
            let [child, node] = *pair else { unreachable!() };
            if node.0 > 0 {
                self.failing.entry(node).or_insert(Failing { node, child, ..failing });
            }
        }
    }

    /// Fails, or is tried again, if nothing is left that it waits for.
    pub(super) fn end_failing(&mut self, node: NodeId, fall: &mut Fall) {
        let Some(&failing) = self.failing.get(&node) else { return };
        if !self.has_ended(failing) || self.runs_below(node) || self.owes(node, None) {
            return;
        }
        let is_over_above = self.is_over(self.parent(node));
        self.failing.remove(&node);
        match failing.fault.filter(|_| self.can_be_tried_again(node) && !is_over_above) {
            Some(fault) => fall.again = Some((node, fault)),
            None => self.fail(node, failing.cause, failing.fault, fall),
        }
    }

    /// Whether nothing is left of a failing node that it finishes.
    fn has_ended(&self, failing: Failing) -> bool {
        let is_over = |child: &NodeId| self.failed.contains(child) || self.done.contains(child);
        match self.kind(failing.node) {
            _ if !failing.finishes => true,
            NodeKind::Cleanup => is_over(&self.body(failing.node)),
            NodeKind::Then => self.not_done(failing.node).first().is_some_and(|next| self.failed.contains(next)),
            _ => self.children(failing.node).iter().all(is_over),
        }
    }

    /// Whether a node would be tried again if it failed now.
    pub(super) fn can_be_tried_again(&self, node: NodeId) -> bool {
        let failures = self.failures.get(&node).copied().unwrap_or(0);
        failures < self.mission.tree.limits(node).retries && !self.is_never(node)
    }

    /// Whether a node cannot be complete since leaves below it can never run.
    pub(super) fn is_never(&self, node: NodeId) -> bool {
        let children = self.children(node);
        match self.kind(node) {
            NodeKind::Cleanup => self.is_never(self.body(node)),
            NodeKind::Behavior(_) => self.infeasible.contains_key(&node),
            NodeKind::And | NodeKind::Tasks | NodeKind::Then => children.iter().any(|child| self.is_never(*child)),
            NodeKind::Or => children.iter().all(|child| self.is_never(*child)),
            NodeKind::Root => false,
        }
    }

    /// Whether something is won by canceling what is below an AND; what never could run is not tried again.
    fn can_win(&self, node: NodeId, fault: Option<Fault>) -> bool {
        let path = self.within(node);
        let has_other_way = |pair: &[NodeId]| {
            let others = self.children(pair[1]).into_iter().filter(|other| *other != pair[0]);
            self.kind(pair[1]) == &NodeKind::Or && others.into_iter().any(|other| !self.failed.contains(&other))
        };
        let is_again = |node: &NodeId| fault.is_some() && node.0 > 0 && self.can_be_tried_again(*node);
        self.is_over(node) || path.iter().any(is_again) || path.windows(2).any(has_other_way)
    }

    /// What fails with a node that does not run: leases, what waits, and who is tried again.
    pub(super) fn settle_fall(&mut self, fall: &mut Fall) {
        let mut begun = self.failing.values().rev().filter(|failing| !fall.before.contains(&failing.node));
        fall.failing = begun.next().copied();
        if let Some(failed) = fall.failed {
            let below = self.below(failed);
            self.waits.retain(|node, _| !below.contains(*node));
            self.resting.retain(|node, _| !below.contains(*node));
            self.deadlines.retain(|node, _| !below.contains(*node));
        }
    }

    /// A task node took longer than it may.
    pub(super) fn time_out(&mut self, node: NodeId) {
        self.hidden.clear();
        self.deadlines.remove(&node);
        let (child, fault) = (node, Some(Fault::TimedOut));
        let cause = self.failing.get(&node).map_or(node, |failing| failing.cause);
        let failing = Failing { node, child, cause, fault, finishes: false };
        self.failing.remove(&node);
        let mut fall = self.no_fall();
        self.begin_to_fail(failing, &mut fall);
        if let Some(failed) = fall.failed {
            self.take_back(failed, Some(failed));
        }
        self.settle_fall(&mut fall);
        let cleaned = fall.cleaned;
        let consequences = Consequences { completed: None, failed: fall.failed, failing: fall.failing, cleaned };
        self.log.push(Step::TimedOut { node, consequences });
        self.try_again(&fall);
    }
}
