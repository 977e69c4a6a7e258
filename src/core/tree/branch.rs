//! What a task node knows of its children, whatever its ordering.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::{Activation, Allocator, Answer};
use crate::world::View;
use ambidex_model::{MissionSpec, NodeId, NodeRange};

/// A task node with its children.
#[derive(Debug)]
pub(super) struct Branch {
    pub(super) id: NodeId,
    pub(super) children: Vec<Child>,
    pub(super) mission: Arc<MissionSpec>,
    pub(super) allocator: Arc<dyn Allocator>,
    pub(super) open: Option<Open>,
    /// Leaves below that run.
    pub(super) running: BTreeSet<NodeId>,
    /// Nodes below that count as done, as an OR sees them: behaviors that completed, nodes that were skipped.
    pub(super) done_below: BTreeSet<NodeId>,
    /// OR: the child it is committed to.
    pub(super) committed: Option<usize>,
    /// OR: a lease lapsed below the committed child since the last activation.
    pub(super) has_lapsed: bool,
}

/// A child as its parent sees it.
#[derive(Debug)]
pub(super) struct Child {
    pub(super) id: NodeId,
    pub(super) below: NodeRange,
    pub(super) is_done: bool,
    pub(super) has_failed: bool,
}

/// A round from activation to verdict.
#[derive(Debug)]
pub(super) struct Open {
    pub(super) activation: Activation,
    /// Children asked, in the order of asking, each with its answer.
    pub(super) asked: BTreeMap<usize, Option<Answer>>,
    /// How many of them have not answered.
    pub(super) waiting: usize,
}

impl Branch {
    pub(super) fn new(id: NodeId, mission: &Arc<MissionSpec>, allocator: &Arc<dyn Allocator>) -> Self {
        let topology = &mission.tree.topology;
        let child = |id| {
            let below = NodeRange { from: id, to: topology.end(id) };
            Child { id, below, is_done: false, has_failed: false }
        };
        Self {
            id,
            children: topology.children(id).map(child).collect(),
            mission: Arc::clone(mission),
            allocator: Arc::clone(allocator),
            open: None,
            running: BTreeSet::new(),
            done_below: BTreeSet::new(),
            committed: None,
            has_lapsed: false,
        }
    }

    /// The node and everything under it.
    pub(super) fn below(&self) -> NodeRange {
        NodeRange { from: self.id, to: self.mission.tree.topology.end(self.id) }
    }

    /// Whether something below runs in the eyes of root.
    pub(super) fn is_busy(&self, view: &View) -> bool {
        view.running.range(self.below().from..self.below().to).next().is_some()
    }

    pub(super) fn index_of(&self, child: NodeId) -> usize {
        self.children.binary_search_by_key(&child, |child| child.id).expect("children speak to their parent")
    }
}
