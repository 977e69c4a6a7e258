//! Work that is done more than once (`semantics` 6, "Work that repeats").

use ambidex::model::{Cause, NodeId, NodeKind, Reason, Reopened};

use super::{Model, Refusal, Step};

impl Model<'_> {
    /// How many iterations the outermost repeating node above a leaf, or itself, has ended.
    pub(super) fn iterations(&self, leaf: NodeId) -> u32 {
        let path = self.upward(leaf);
        let outermost = path.iter().rfind(|node| self.mission.tree.repeats.contains_key(node));
        outermost.map_or(0, |node| self.ended_times(*node))
    }

    pub(super) fn ended_times(&self, node: NodeId) -> u32 {
        self.iterated.get(&node).copied().unwrap_or(0)
    }

    /// Whether another iteration comes after this one.
    pub(super) fn is_not_the_last(&self, node: NodeId) -> bool {
        let repeat = self.mission.tree.repeats.get(&node);
        repeat.is_some_and(|repeat| repeat.times.is_none_or(|times| self.ended_times(node) + 1 < times))
    }

    /// Why nothing there is asked, if its next time has not come.
    pub(super) fn not_yet(&self, node: NodeId) -> Option<Refusal> {
        let (_, wait_ms) = *self.resting.get(&node)?;
        Some(Reason::NotYet { node, wait_ms }.into())
    }

    /// The first grant below a node begins its first iteration.
    pub(super) fn begin_first_time(&mut self, leaf: NodeId) {
        for node in self.upward(leaf) {
            if self.kind(node) == &NodeKind::Cleanup {
                self.begun.insert(node);
            }
            if self.mission.tree.repeats.contains_key(&node) {
                self.began.entry(node).or_insert(self.now);
            }
            if self.mission.tree.topology.is_cleanup(node) {
                break;
            }
        }
    }

    /// An iteration ends if a node that is complete has another one.
    pub(super) fn end_iteration_of_complete(&mut self, node: NodeId) {
        if self.is_not_the_last(node) && !self.is_over(node) {
            self.end_iteration(node);
        }
    }

    pub(super) fn end_iteration(&mut self, node: NodeId) {
        self.hidden.clear();
        let times = self.ended_times(node) + 1;
        let every = self.mission.tree.repeats[&node].every;
        let began = self.began.get(&node).copied().unwrap_or(self.now);
        let until = every.map(|every| began + every).filter(|until| *until > self.now);
        let below = self.below(node);
        let reset: Vec<NodeId> = (below.from.0..below.to.0).map(NodeId).collect();
        for &node in &reset {
            self.forget(node);
            self.begin_anew(node);
        }
        self.iterated.insert(node, times);
        self.began.insert(node, until.unwrap_or(self.now));
        if let Some(until) = until {
            self.resting.insert(node, (until, (until.0 - self.now.0) / 1000));
        }
        self.gather(node, |holder| reset.contains(&holder));
        let reopened = Reopened::new(node, node, Cause::Repeat { since: self.now, until });
        self.log.push(Step::Reopened(Reopened { reset, ..reopened }));
    }

    /// Nothing is known of earlier iterations.
    pub(super) fn begin_anew(&mut self, node: NodeId) {
        self.iterated.remove(&node);
        self.began.remove(&node);
        self.resting.remove(&node);
        self.infeasible.remove(&node);
        self.left.remove(&node);
        self.redone.remove(&node);
        self.ever_completed.remove(&node);
        self.bad.retain(|(leaf, _)| *leaf != node);
    }
}
