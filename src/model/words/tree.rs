//! The task tree: its shape, what each node is, and what is told of nodes beside that.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::behavior::doubled;
use super::{BehaviorSpec, NodeId, WorldState};

/// The shape of a tree in preorder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    parents: Vec<NodeId>,
    ends: Vec<NodeId>,
    /// Nodes that are asked only where what stands before them has failed or is given up.
    cleanups: BTreeSet<NodeId>,
}

impl Topology {
    /// From each node's parent in preorder; the root is its own parent.
    ///
    /// # Panics
    /// When the parents are not those of a tree in preorder.
    pub fn new(parents: Vec<NodeId>) -> Self {
        let mut ends: Vec<NodeId> = (1..=parents.len()).map(NodeId::from).collect();
        for node in (1..parents.len()).rev() {
            let parent = parents[node].index();
            assert!(parent < node && ends[parent].index() > 0, "not in preorder: {parents:?}");
            ends[parent] = ends[parent].max(ends[node]);
        }
        for node in 1..parents.len() {
            let (parent, before) = (parents[node], NodeId::from(node - 1));
            assert!(parent <= before && before < ends[parent.index()], "not in preorder: {parents:?}");
        }
        Self { parents, ends, cleanups: BTreeSet::new() }
    }

    /// The same, where some nodes have a body and, behind it, a cleanup.
    #[must_use]
    pub fn with_cleanups_of(self, has_cleanup: impl Fn(NodeId) -> bool) -> Self {
        let nodes = (1..self.count()).map(NodeId::from);
        // The body stands right behind its parent.
        let is_cleanup = |node: &NodeId| has_cleanup(self.parent(*node)) && self.parent(*node).0 + 1 < node.0;
        let cleanups = nodes.filter(is_cleanup).collect();
        Self { cleanups, ..self }
    }

    /// Whether a node is a cleanup.
    pub fn is_cleanup(&self, node: NodeId) -> bool {
        !self.cleanups.is_empty() && self.cleanups.contains(&node)
    }

    /// Whether a node is a cleanup or below one.
    pub fn is_in_cleanup(&self, node: NodeId) -> bool {
        !self.cleanups.is_empty() && self.path(node).any(|above| self.cleanups.contains(&above))
    }

    /// The nodes that are cleanups.
    pub fn cleanups(&self) -> &BTreeSet<NodeId> {
        &self.cleanups
    }

    /// How many nodes there are; at least root.
    pub fn count(&self) -> usize {
        self.parents.len()
    }

    /// A node and those above it, root last.
    pub fn path(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        std::iter::successors(Some(node), |node| (node.0 > 0).then(|| self.parent(*node)))
    }

    /// The parent of a node; the root's is itself.
    pub fn parent(&self, node: NodeId) -> NodeId {
        self.parents[node.index()]
    }

    /// The first node in preorder behind a node's subtree.
    pub fn end(&self, node: NodeId) -> NodeId {
        self.ends[node.index()]
    }

    /// Whether `node` is `top` or below it.
    pub fn is_within(&self, node: NodeId, top: NodeId) -> bool {
        top <= node && node < self.end(top)
    }

    /// The children of a node in order.
    pub fn children(&self, node: NodeId) -> impl Iterator<Item = NodeId> + '_ {
        let end = self.end(node);
        let mut next = NodeId(node.0 + 1);
        std::iter::from_fn(move || {
            let child = (next < end).then_some(next)?;
            next = self.end(child);
            Some(child)
        })
    }
}

/// A task tree.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeSpec {
    /// What each node is, by id; node 0 is the root and has one child.
    pub nodes: Vec<NodeKind>,
    /// Parents and extents of the nodes.
    pub topology: Topology,
    /// Task nodes that may be tried again, or may take only so long.
    pub limits: BTreeMap<NodeId, Limits>,
    /// Nodes that are done more than once.
    pub repeats: BTreeMap<NodeId, Repeat>,
    /// How urgent each node is, by id, what holds for all below it included; empty where all are alike.
    priorities: Vec<i32>,
    least_priority: i32,
    /// The tasks among which resources are shared fairly, in the order in which they came; with fewer than two there is
    /// nothing to be shared.
    pub tasks: Vec<NodeId>,
    /// How many grants a task that waits may see go to tasks that came after it.
    pub bypass: u32,
}

/// How many grants a task that waits sees go to later ones, unless a mission says otherwise.
pub const BYPASS: u32 = 8;

/// How often a node is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Repeat {
    /// How often; none without end.
    pub times: Option<u32>,
    /// How long after the last time began the next one begins, robot time; none at once when it ended.
    pub every: Option<Duration>,
}

impl Repeat {
    /// Whether there is another time after so many.
    pub fn goes_on(&self, after: u32) -> bool {
        self.times.is_none_or(|times| after < times)
    }
}

/// How long a task node may take, and how often it is tried.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Limits {
    /// How long an attempt may take from the first grant below, robot time; none without end.
    pub timeout: Option<Duration>,
    /// How often it is tried again after it failed.
    pub retries: u32,
    /// How long it waits before that, robot time; twice as long after each further time.
    pub backoff: Duration,
}

impl Limits {
    /// How long it waits after so many failures, robot time.
    pub fn wait(&self, failures: u32) -> Duration {
        doubled(self.backoff, failures)
    }
}

impl TreeSpec {
    /// A tree of which nothing else is told.
    pub fn new(nodes: Vec<NodeKind>, topology: Topology) -> Self {
        let topology = topology.with_cleanups_of(|node| nodes[node.index()] == NodeKind::Cleanup);
        let (limits, repeats) = (BTreeMap::new(), BTreeMap::new());
        Self {
            nodes,
            topology,
            limits,
            repeats,
            priorities: Vec::new(),
            least_priority: 0,
            tasks: Vec::new(),
            bypass: BYPASS,
        }
    }

    /// The same with nodes that are told how urgent they are; what is told holds for all below that are told nothing.
    #[must_use]
    pub fn with_priorities(mut self, told: &BTreeMap<NodeId, i32>) -> Self {
        let mut priorities = vec![0; self.nodes.len()];
        for index in 0..priorities.len() {
            let node = NodeId::from(index);
            let above = priorities[self.topology.parent(node).index()];
            priorities[index] = told.get(&node).copied().unwrap_or(above);
        }
        self.least_priority = self.leaves().map(|leaf| priorities[leaf.index()]).min().unwrap_or_default();
        let is_told = priorities.iter().any(|priority| *priority != 0);
        self.priorities = if is_told { priorities } else { Vec::new() };
        self
    }

    /// Whether some of its behaviors are more urgent than others.
    pub fn has_priorities(&self) -> bool {
        !self.priorities.is_empty() && self.leaves().any(|leaf| self.priority(leaf) > self.least_priority)
    }

    /// How urgent a node is.
    pub fn priority(&self, node: NodeId) -> i32 {
        self.priorities.get(node.index()).copied().unwrap_or_default()
    }

    /// How urgent the least urgent node is.
    pub fn least_priority(&self) -> i32 {
        self.least_priority
    }

    /// How long a task node may take, and how often it is tried.
    pub fn limits(&self, node: NodeId) -> Limits {
        self.limits.get(&node).copied().unwrap_or_default()
    }

    /// The behavior of a leaf.
    pub fn behavior(&self, node: NodeId) -> Option<&BehaviorSpec> {
        match &self.nodes[node.index()] {
            NodeKind::Behavior(spec) => Some(spec),
            NodeKind::Root | NodeKind::And | NodeKind::Or | NodeKind::Then | NodeKind::Cleanup => None,
        }
    }

    /// The behavior of a leaf as the world is.
    pub fn behavior_in(&self, node: NodeId, world_state: &WorldState) -> Option<&BehaviorSpec> {
        self.behavior(node).map(|spec| spec.as_in(world_state))
    }

    /// All ORs in tree order.
    pub fn ors(&self) -> impl Iterator<Item = NodeId> + '_ {
        (0..self.nodes.len()).map(NodeId::from).filter(|node| self.nodes[node.index()] == NodeKind::Or)
    }

    /// All leaves in tree order.
    pub fn leaves(&self) -> impl Iterator<Item = NodeId> + '_ {
        (0..self.nodes.len()).map(NodeId::from).filter(|&node| self.behavior(node).is_some())
    }
}

/// What a node is (III-A).
#[derive(Debug, Clone, PartialEq)]
pub enum NodeKind {
    /// Keeps resources and world, and grants.
    Root,
    /// All children, in any order.
    And,
    /// One child.
    Or,
    /// All children, in order.
    Then,
    /// The first of two children; the second where that fails or is given up (`semantics` 6, "Cleanup").
    Cleanup,
    /// A low-level behavior.
    Behavior(Box<BehaviorSpec>),
}
