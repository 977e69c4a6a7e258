//! Task nodes that are tried again (`semantics` 6).

use ambidex::model::{Cause, NodeId, NodeKind, Reopened};

use super::failing::Fall;
use super::{Model, Step, TOP};

impl Model<'_> {
    /// The node whose attempt has failed begins anew, when it has waited.
    pub(super) fn try_again(&mut self, fall: &Fall) {
        let Some((top, fault)) = fall.again else { return };
        let mut reset = Vec::new();
        self.begins_anew(top, &mut reset);
        let failures = self.failures.get(&top).copied().unwrap_or(0) + 1;
        let wait = self.mission.tree.limits(top).wait(failures);
        let was_done = |node: &NodeId| self.upward(*node).iter().any(|above| *above > top && self.done.contains(above));
        for node in reset.iter().copied().filter(was_done).collect::<Vec<_>>() {
            self.iterated.remove(&node);
            self.began.remove(&node);
        }
        for &node in &reset {
            self.forget(node);
            self.resting.remove(&node);
        }
        self.failures.insert(top, failures);
        self.gather(top, |holder| reset.contains(&holder));
        let until = self.now + wait;
        if until > self.now {
            self.waits.insert(top, (until, wait.as_millis() as u64, fault));
        }
        let cause = Cause::Retry { fault, since: self.now, until };
        self.log.push(Step::Reopened(Reopened { reset, ..Reopened::new(top, top, cause) }));
    }

    /// Nodes that begin anew when one does that was not done; what failed since it can never run does not.
    fn begins_anew(&self, node: NodeId, reset: &mut Vec<NodeId>) {
        if self.is_never(node) {
            return;
        }
        reset.push(node);
        let children = self.children(node);
        let is_done = |child: &NodeId| self.done.contains(child);
        let kept = match self.kind(node) {
            NodeKind::Then => {
                let mut before_last = children[..children.len() - 1].iter();
                before_last.rposition(|child| is_done(child) && self.is_reached(*child))
            }
            NodeKind::Or => None,
            NodeKind::Cleanup | NodeKind::And | NodeKind::Tasks | NodeKind::Root | NodeKind::Behavior(_) => {
                Some(children.len())
            }
        };
        let is_asked = |child: &NodeId| !self.mission.tree.topology.is_cleanup(*child);
        for (index, child) in children.iter().enumerate().filter(|(_, child)| is_asked(child)) {
            if !is_done(child) {
                self.begins_anew(*child, reset);
            } else if kept.is_none_or(|kept| index > kept) {
                self.begins_from_its_beginning(*child, reset);
            }
        }
    }

    /// What is done again.
    fn begins_from_its_beginning(&self, node: NodeId, reset: &mut Vec<NodeId>) {
        reset.push(node);
        for child in self.children(node) {
            self.begins_from_its_beginning(child, reset);
        }
    }

    pub(super) fn forget(&mut self, node: NodeId) {
        self.done.remove(&node);
        self.failed.remove(&node);
        self.faults.remove(&node);
        self.failing.remove(&node);
        self.failures.remove(&node);
        self.begun.remove(&node);
        self.committed.remove(&node);
        self.silent.remove(&node);
        self.unfit.retain(|(leaf, ..)| *leaf != node);
        self.deadlines.remove(&node);
        self.waits.remove(&node);
        if let Some((_, by)) = self.redone.get_mut(&node) {
            *by = None;
        }
    }

    /// Whether the goal of a node holds; being somewhere is none.
    pub(super) fn is_reached(&self, node: NodeId) -> bool {
        let children = self.children(node);
        match self.kind(node) {
            NodeKind::Cleanup => self.is_reached(self.body(node)),
            NodeKind::Behavior(spec) => !spec.is_drive() && self.is_satisfied(node, &[]),
            NodeKind::And | NodeKind::Tasks => children.iter().all(|child| self.is_reached(*child)),
            NodeKind::Or => children.iter().any(|child| self.is_reached(*child)),
            NodeKind::Then => children.last().is_some_and(|child| self.is_reached(*child)),
            NodeKind::Root => self.is_reached(TOP),
        }
    }
}
