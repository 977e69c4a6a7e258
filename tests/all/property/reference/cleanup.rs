//! What is done where a node has failed or is given up (`semantics` 6, "Cleanup").

use std::time::Duration;

use ambidex::model::{Consequences, MissionEnd, NodeId, NodeKind, Reason};

use super::failing::Fall;
use super::{Model, Refusal, Step, TOP};

impl Model<'_> {
    fn cleanup_nodes(&self) -> Vec<NodeId> {
        let nodes = (1..self.mission.tree.nodes.len()).map(NodeId::from);
        nodes.filter(|node| self.kind(*node) == &NodeKind::Cleanup).collect()
    }

    /// A node and those above it that are about it: in a cleanup no further than that.
    pub(super) fn within(&self, node: NodeId) -> Vec<NodeId> {
        let mut path = Vec::new();
        for above in self.upward(node) {
            path.push(above);
            if self.mission.tree.topology.is_cleanup(above) {
                break;
            }
        }
        path
    }

    /// The node whose cleanup something is part of.
    pub(super) fn cleans(&self, node: NodeId) -> Option<NodeId> {
        let top = *self.within(node).last().expect("itself");
        self.mission.tree.topology.is_cleanup(top).then(|| self.parent(top))
    }

    pub(super) fn body(&self, node: NodeId) -> NodeId {
        self.children(node)[0]
    }

    fn cleanup(&self, node: NodeId) -> NodeId {
        self.children(node)[1]
    }

    /// Whether an OR leaves the way, or the mission is told to end.
    pub(super) fn is_given_up(&self, node: NodeId) -> bool {
        self.leaving.contains_key(&node) || (node == TOP && self.ending.is_some())
    }

    fn is_ending(&self, node: NodeId) -> bool {
        self.within(node).into_iter().any(|above| self.is_canceling(above) || self.is_given_up(above))
    }

    pub(super) fn is_grace_over(&self) -> bool {
        self.ending.is_some_and(|(_, until)| until <= self.now)
    }

    /// Whether a cleanup of a node is due and has not begun.
    fn is_owing(&self, node: NodeId) -> bool {
        let is_left = |above: NodeId| !self.done.contains(&above) && !self.failed.contains(&above);
        self.begun.contains(&node)
            && !self.cleaning.contains(&node)
            && self.is_ending(node)
            && self.within(node).into_iter().all(is_left)
            && !self.is_grace_over()
    }

    /// Whether a cleanup of a node or below is due or going on, but for one.
    pub(super) fn owes(&self, top: NodeId, but_for: Option<NodeId>) -> bool {
        let below = self.below(top);
        let nodes = self.cleanup_nodes().into_iter().filter(|node| below.contains(*node) && Some(*node) != but_for);
        nodes.into_iter().any(|node| self.cleaning.contains(&node) || self.is_owing(node))
    }

    /// Cleanups begin, inner ones first, and ORs leave ways in which all is cleaned up; true if anything did.
    pub(super) fn begin_cleanups(&mut self) -> bool {
        let mut is_any = false;
        for node in self.cleanup_nodes().into_iter().rev() {
            if self.is_owing(node) && !self.runs_below(node) && !self.owes(node, Some(node)) {
                self.cleaning.insert(node);
                let body = self.below(self.body(node));
                self.settle_done(body);
                self.gather(node, |holder| body.contains(holder));
                self.log.push(Step::Cleaning { node });
                is_any = true;
            }
        }
        for (way, or) in self.leaving.clone() {
            if !self.owes(way, None) {
                self.leaving.remove(&way);
                self.leave_at_last(or, way);
                is_any = true;
            }
        }
        is_any
    }

    /// What it was given up for goes on.
    pub(super) fn end_cleanup(&mut self, node: NodeId, fall: &mut Fall) {
        self.cleaning.remove(&node);
        self.begun.remove(&node);
        let below = self.below(self.cleanup(node));
        for node in (below.from.0..below.to.0).map(NodeId) {
            self.forget(node);
            self.resting.remove(&node);
            self.bad.retain(|(leaf, _)| *leaf != node);
            self.begin_anew(node);
        }
        fall.cleaned = Some(node);
        fall.failed = None;
        // What was to finish what it can has failed too.
        self.failing.entry(node).and_modify(|failing| failing.finishes = false);
        self.end_failing_above(node, fall);
        self.gather(node, |holder| below.contains(holder));
        if fall.failed.is_some() {
            self.take_back(node, fall.failed);
        }
    }

    /// It ended without the end of a behavior.
    pub(super) fn end_cleanup_alone(&mut self, node: NodeId, is_done: bool) {
        self.hidden.clear();
        let mut fall = self.no_fall();
        self.end_cleanup(node, &mut fall);
        self.settle_fall(&mut fall);
        let cleaned = fall.cleaned;
        let consequences = Consequences { completed: None, failed: fall.failed, failing: fall.failing, cleaned };
        self.log.push(Step::Cleaned { node, is_done, consequences });
        self.try_again(&fall);
    }

    /// Why nothing below is asked but cleanups.
    pub(super) fn silence(&self, node: NodeId) -> Option<Refusal> {
        if self.is_canceling(node) {
            let failed = self.failing[&node].child;
            let reason = if failed == node { Reason::OutOfTime { node } } else { Reason::Ending { failed } };
            return Some(reason.into());
        }
        if self.is_given_up(node) {
            return Some(Reason::GivenUp { node }.into());
        }
        if let Some(&(_, wait_ms, fault)) = self.waits.get(&node)
            && !matches!(self.kind(node), NodeKind::Behavior(_))
        {
            return Some(Refusal { waits: true, ..Reason::BackingOff { wait_ms, fault }.into() });
        }
        let over = || (!self.cleaning.is_empty() && self.is_over(node)).then(|| Reason::GivenUp { node }.into());
        self.not_yet(node).or_else(over)
    }

    /// The mission is to end; what is to be cleaned up is. False if it was told so before.
    pub fn tell_to_finish(&mut self, end: MissionEnd) -> bool {
        if self.ending.is_some() || self.end.is_some() {
            return false;
        }
        self.hidden.clear();
        let until = self.now + Duration::from_secs(10);
        self.ending = Some((end, until));
        if !self.cleaning.contains(&TOP) {
            self.failing.remove(&TOP);
        }
        self.awaited = None;
        self.log.push(Step::Ending { end, until });
        true
    }

    /// Whether rounds go on; the mission that is told to end ends with the last cleanup.
    pub fn goes_on_cleaning(&mut self) -> bool {
        let Some((end, _)) = self.ending else { return true };
        if self.end.is_some() {
            return false;
        }
        if !self.is_grace_over() {
            self.begin_cleanups();
        }
        let owes = self.owes(TOP, None) && !self.is_grace_over();
        if self.running.is_empty() && !owes {
            self.finish(end);
            return false;
        }
        !self.cleaning.is_empty() && !self.is_grace_over()
    }
}
