//! What begins anew, is left or cleaned up: the parts of records that put nodes back to where they were.

use std::sync::Arc;

use super::{GoesOn, Pause, Phase, State, Status, Wait};
use crate::{Consequences, Kept, NodeId, Reopened, Time};

impl State {
    /// An OR is free to choose again. What is done in the way that it leaves stays done.
    pub(super) fn leave(&mut self, way: NodeId, or: NodeId) {
        self.status_mut(or).way = None;
        let progress = self.progress;
        Arc::make_mut(&mut self.left).insert(way, progress);
        let topology = Arc::clone(&self.topology);
        self.gather(or, |holder| topology.is_within(holder, way));
        // What waits there for its next time goes on waiting: nobody hurries by leaving.
        topology.below(way).for_each(|run| self.end_times(run));
        if self.phase(way) == Phase::Ending {
            self.status_mut(way).phase = Phase::Pending;
        }
        self.forget_begun(way);
    }

    /// Nothing below a node counts as granted since it began.
    pub(super) fn forget_begun(&mut self, top: NodeId) {
        let topology = Arc::clone(&self.topology);
        for node in topology.nodes_below(top) {
            if self.status(node).is_begun {
                self.status_mut(node).is_begun = false;
            }
        }
    }

    /// A node that is done more than once begins anew.
    pub(super) fn repeat(&mut self, reopened: &Reopened, since: Time, until: Option<Time>) {
        let top = reopened.node;
        let topology = Arc::clone(&self.topology);
        self.forget_below(top);
        let times = self.iterations.get(&top).copied().unwrap_or_default() + 1;
        topology.nodes_below(top).for_each(|node| self.forget_all(node));
        Arc::make_mut(&mut self.iterations).insert(top, times);
        self.gather(top, |holder| topology.is_within(holder, top));
        if let Some(until) = until {
            Arc::make_mut(&mut self.pauses).insert(top, Pause { since, until });
        }
    }

    /// A node is as before it was ever begun.
    fn forget_all(&mut self, node: NodeId) {
        *self.status_mut(node) = Status::default();
        Arc::make_mut(&mut self.iterations).remove(&node);
        Arc::make_mut(&mut self.left).remove(&node);
        Arc::make_mut(&mut self.infeasible).remove(&node);
        Arc::make_mut(&mut self.unfit).remove(&node);
    }

    pub(super) fn end_intentions(&mut self, ended: &[Kept]) {
        for &Kept { resource, holder, .. } in ended {
            Arc::make_mut(&mut self.table).lapse(resource, holder);
        }
    }

    /// A node is canceled or about to be left.
    pub(super) fn end_node(&mut self, node: NodeId) -> bool {
        let is_known = self.topology.has(node);
        if is_known && !matches!(self.phase(node), Phase::Done | Phase::Failed | Phase::Cleaning(_)) {
            self.status_mut(node).phase = Phase::Ending;
            self.end_times_of_body(node);
        }
        is_known
    }

    /// What full grippers held below the body goes to the cleanup's node.
    pub(super) fn begin_cleaning(&mut self, node: NodeId) -> bool {
        if !self.can_clean(node) {
            return false;
        }
        let topology = Arc::clone(&self.topology);
        let body = topology.children(node).next().expect("it has a body and a cleanup");
        topology.below(body).for_each(|run| self.forget_moments(run));
        self.gather(node, |holder| topology.is_within(holder, body));
        let goes_on = match self.phase(node) {
            Phase::Failing(failing) => GoesOn::Failing(failing),
            Phase::Ending => GoesOn::Ending,
            Phase::Pending | Phase::Done | Phase::Failed | Phase::Cleaning(_) => GoesOn::Pending,
        };
        self.status_mut(node).phase = Phase::Cleaning(goes_on);
        Arc::make_mut(&mut self.cleaning).insert(node);
        true
    }

    pub(super) fn cleaned(&mut self, node: NodeId, consequences: Consequences) -> bool {
        let is_sound = self.cleaning.contains(&node) && self.can_fail(node, consequences);
        if is_sound {
            self.end_cleaning(node);
            self.fall(node, Consequences { cleaned: None, ..consequences });
        }
        is_sound
    }

    /// A cleanup is over, and can be done another time; its node is as before it was begun.
    pub(super) fn end_cleaning(&mut self, node: NodeId) {
        Arc::make_mut(&mut self.cleaning).remove(&node);
        let cleanup = self.topology.children(node).last().unwrap_or(node);
        let topology = Arc::clone(&self.topology);
        self.forget_below(cleanup);
        topology.nodes_below(cleanup).for_each(|node| self.forget_all(node));
        self.gather(node, |holder| topology.is_within(holder, cleanup));
        if let Phase::Cleaning(goes_on) = self.phase(node) {
            let is_ending = goes_on == GoesOn::Ending;
            self.status_mut(node).phase = if is_ending { Phase::Ending } else { Phase::Pending };
        }
        self.forget_begun(node);
    }

    /// A node begins anew, but for what it keeps, when it has waited.
    pub(super) fn try_again(&mut self, reopened: &Reopened, wait: Wait) {
        let top = reopened.node;
        // What was done is done from its beginning, as often as it says.
        let is_done = |node: NodeId| node > top && self.phase(node) == Phase::Done;
        let is_again = |node: &NodeId| self.iterations.contains_key(node) && self.topology.path(*node).any(is_done);
        let again: Vec<NodeId> = reopened.reset.iter().copied().filter(is_again).collect();
        for node in again {
            Arc::make_mut(&mut self.iterations).remove(&node);
        }
        for &node in &reopened.reset {
            self.end_time(node);
            self.wake(node);
            let failures = if node == top { self.status(node).failures + 1 } else { 0 };
            let status = self.status_mut(node);
            (status.phase, status.way, status.failures, status.bar) = (Phase::Pending, None, failures, None);
            status.is_begun = false;
            Arc::make_mut(&mut self.infeasible).remove(&node);
            Arc::make_mut(&mut self.unfit).remove(&node);
            self.forget_needs(node..NodeId(node.0 + 1));
        }
        self.gather(top, |holder| reopened.reset.binary_search(&holder).is_ok());
        if wait.until > wait.since {
            self.wait(top, wait);
        }
    }

    /// What full grippers hold below a node goes to it; all else that is held there is free.
    pub(super) fn gather(&mut self, to: NodeId, is_from: impl Fn(NodeId) -> bool) {
        let world = Arc::clone(&self.world);
        Arc::make_mut(&mut self.table).gather(to, is_from, |resource| world.held_by(resource).is_some());
    }
}
