//! Why those that were asked do not run, as they and the nodes above them said it last.

use std::collections::BTreeMap;
use std::ops::Deref;

use ambidex_model::{NodeId, Reason, TreeSpec};

/// Reasons by node, and which tasks wait for others.
#[derive(Debug, Default)]
pub(super) struct Reasons {
    by_node: BTreeMap<NodeId, Reason>,
    /// By task, how many of its behaviors wait for what others have.
    waiting: BTreeMap<NodeId, u32>,
}

impl Deref for Reasons {
    type Target = BTreeMap<NodeId, Reason>;

    fn deref(&self) -> &Self::Target {
        &self.by_node
    }
}

impl Reasons {
    /// Whether something of a task waits for what others have.
    pub(super) fn waits(&self, task: NodeId) -> bool {
        self.waiting.contains_key(&task)
    }

    /// What a node says now; none where nothing keeps it from asking.
    pub(super) fn take(&mut self, tree: &TreeSpec, node: NodeId, reason: Option<Reason>) {
        let is_of_others = reason.as_ref().is_some_and(Reason::is_of_others);
        let before = match reason {
            Some(reason) => self.by_node.insert(node, reason),
            None => self.by_node.remove(&node),
        };
        let was_of_others = before.as_ref().is_some_and(Reason::is_of_others);
        if is_of_others != was_of_others
            && let Some(task) = task_of(tree, node)
        {
            self.count(task, is_of_others);
        }
    }

    fn count(&mut self, task: NodeId, is_more: bool) {
        let waiting = self.waiting.entry(task).or_default();
        *waiting = if is_more { *waiting + 1 } else { waiting.saturating_sub(1) };
        if *waiting == 0 {
            self.waiting.remove(&task);
        }
    }

    /// Nodes that are asked no more say nothing.
    pub(super) fn withdraw(&mut self, tree: &TreeSpec, range: std::ops::Range<NodeId>) {
        let gone: Vec<NodeId> = self.by_node.range(range).map(|(&node, _)| node).collect();
        gone.into_iter().for_each(|node| self.take(tree, node, None));
    }

    /// Nobody has said anything.
    pub(super) fn clear(&mut self) {
        self.by_node.clear();
        self.waiting.clear();
    }
}

/// The task that a node belongs to.
pub(super) fn task_of(tree: &TreeSpec, node: NodeId) -> Option<NodeId> {
    match tree.tasks.is_empty() {
        true => None,
        false => tree.topology.path(node).find(|above| tree.tasks.binary_search(above).is_ok()),
    }
}
