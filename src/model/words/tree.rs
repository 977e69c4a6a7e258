//! The task tree: what each node is, and what is told of nodes beside that.

use std::collections::BTreeMap;
use std::time::Duration;

use super::behavior::doubled;
use super::{BehaviorSpec, NodeId, Runs, Topology, WorldState};

/// How far from 0 a priority may be.
pub const PRIORITY_MAX: i32 = 1000;

/// A task tree.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeSpec {
    /// What each node is, by id; node 0 is the root and has one child.
    pub nodes: Runs<NodeKind>,
    /// Parents and extents of the nodes.
    pub topology: Topology,
    /// Task nodes that may be tried again, or may take only so long.
    pub limits: BTreeMap<NodeId, Limits>,
    /// Nodes that are done more than once.
    pub repeats: BTreeMap<NodeId, Repeat>,
    /// How urgent each node is, by id, what holds for all below it included; absent where nothing is told.
    priorities: Runs<i32>,
    /// How many behaviors are how urgent.
    levels: BTreeMap<i32, usize>,
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
        let is_standing = nodes.get(1) == Some(&NodeKind::Tasks);
        let topology = topology.with_stem(NodeId(u32::from(is_standing)));
        let (limits, repeats) = (BTreeMap::new(), BTreeMap::new());
        let mut tree = Self {
            nodes: nodes.into(),
            topology,
            limits,
            repeats,
            priorities: Runs::default(),
            levels: BTreeMap::new(),
            tasks: Vec::new(),
            bypass: BYPASS,
        };
        tree.count_levels();
        tree
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
        let is_told = priorities.iter().any(|priority| *priority != 0);
        self.priorities = if is_told { priorities.into() } else { Runs::default() };
        self.count_levels();
        self
    }

    fn count_levels(&mut self) {
        self.levels = BTreeMap::new();
        for priority in self.leaves().map(|leaf| self.priority(leaf)).collect::<Vec<_>>() {
            *self.levels.entry(priority).or_default() += 1;
        }
    }

    /// Adds a subtree as a child of a node, at some place among the others; gives the id of its top.
    pub fn graft(&mut self, under: NodeId, place: usize, fragment: &Fragment) -> NodeId {
        let has_cleanup = |base: NodeId| {
            let nodes = &fragment.nodes;
            move |node: NodeId| nodes[(node.0 - base.0) as usize] == NodeKind::Cleanup
        };
        let top = self.topology.graft(under, place, &fragment.parents, has_cleanup(self.topology.next()));
        self.take(top, fragment);
        for leaf in self.leaves_below(top) {
            *self.levels.entry(self.priority(leaf)).or_default() += 1;
        }
        top
    }

    /// The tree of a run that is gone on with: its shape then, and what was added to it, each by its top.
    #[must_use]
    pub fn restored(mut self, topology: &Topology, added: BTreeMap<NodeId, Fragment>) -> Self {
        self.topology = topology.clone();
        for (top, fragment) in added {
            self.take(top, &fragment);
        }
        self.tasks = self.topology.children(self.topology.stem()).collect();
        self.count_levels();
        self
    }

    /// What the nodes of a part are that stands in the topology already.
    fn take(&mut self, top: NodeId, fragment: &Fragment) {
        let moved = |node: &NodeId| NodeId(top.0 + node.0);
        self.nodes.add(top.index(), fragment.nodes.clone());
        self.limits.extend(fragment.limits.iter().map(|(node, limits)| (moved(node), *limits)));
        self.repeats.extend(fragment.repeats.iter().map(|(node, repeat)| (moved(node), *repeat)));
        let above = self.priority(self.topology.parent(top));
        let mut priorities = vec![above; fragment.nodes.len()];
        for index in 0..priorities.len() {
            let node = NodeId::from(index);
            let above = if index == 0 { above } else { priorities[fragment.parents[index].index()] };
            priorities[index] = fragment.priorities.get(&node).copied().unwrap_or(above);
        }
        if priorities.iter().any(|priority| *priority != 0) {
            self.priorities.add(top.index(), priorities);
        }
    }

    /// A node and all below it are gone.
    pub fn remove(&mut self, node: NodeId) {
        let runs: Vec<_> = self.topology.below(node).collect();
        for leaf in self.leaves_below(node) {
            let level = self.priority(leaf);
            self.levels.entry(level).and_modify(|count| *count -= 1);
        }
        self.levels.retain(|_, count| *count > 0);
        self.topology.remove(node);
        for run in runs {
            for node in (run.start.0..run.end.0).map(NodeId) {
                self.limits.remove(&node);
                self.repeats.remove(&node);
            }
            self.nodes.remove(run.start.index()..run.end.index());
            self.priorities.remove(run.start.index()..run.end.index());
        }
    }

    /// Whether some of its behaviors are more urgent than others.
    pub fn has_priorities(&self) -> bool {
        self.levels.len() > 1
    }

    /// How urgent a node is.
    pub fn priority(&self, node: NodeId) -> i32 {
        self.priorities.get(node.index()).copied().unwrap_or_default()
    }

    /// How urgent the least urgent behavior is.
    pub fn least_priority(&self) -> i32 {
        self.levels.keys().next().copied().unwrap_or_default()
    }

    /// How long a task node may take, and how often it is tried.
    pub fn limits(&self, node: NodeId) -> Limits {
        self.limits.get(&node).copied().unwrap_or_default()
    }

    /// The behavior of a leaf.
    pub fn behavior(&self, node: NodeId) -> Option<&BehaviorSpec> {
        match self.nodes.get(node.index())? {
            NodeKind::Behavior(spec) => Some(spec),
            NodeKind::Root | NodeKind::Tasks | NodeKind::And => None,
            NodeKind::Or | NodeKind::Then | NodeKind::Cleanup => None,
        }
    }

    /// The behavior of a leaf as the world is.
    pub fn behavior_in(&self, node: NodeId, world_state: &WorldState) -> Option<&BehaviorSpec> {
        self.behavior(node).map(|spec| spec.as_in(world_state))
    }

    /// All ORs in tree order.
    pub fn ors(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.topology.nodes().filter(|node| self.nodes[node.index()] == NodeKind::Or)
    }

    /// The leaves at and below a node.
    pub fn leaves_below(&self, node: NodeId) -> Vec<NodeId> {
        self.topology.nodes_below(node).filter(|node| self.behavior(*node).is_some()).collect()
    }

    /// Whether its tasks come and go.
    pub fn is_standing(&self) -> bool {
        self.topology.stem().0 > 0
    }

    /// All leaves in tree order.
    pub fn leaves(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.topology.nodes().filter(|&node| self.behavior(node).is_some())
    }
}

/// What a node is (III-A).
#[derive(Debug, Clone, PartialEq)]
pub enum NodeKind {
    /// Keeps resources and world, and grants.
    Root,
    /// All children, in any order.
    And,
    /// Tasks that come and go, each by itself: the one child of root in a run that takes work (`semantics` 6).
    Tasks,
    /// One child.
    Or,
    /// All children, in order.
    Then,
    /// The first of two children; the second where that fails or is given up (`semantics` 6, "Cleanup").
    Cleanup,
    /// A low-level behavior.
    Behavior(Box<BehaviorSpec>),
}

/// A subtree whose nodes are counted from its top, node 0. Its resources, objects, places, facts and types are those of the
/// mission that it was made for.
#[derive(Debug, Clone, PartialEq)]
pub struct Fragment {
    /// As its file, or whoever submits it, calls it.
    pub name: String,
    /// What each node is, in preorder.
    pub nodes: Vec<NodeKind>,
    /// The parent of each node; the top is its own.
    pub parents: Vec<NodeId>,
    /// Task nodes that may be tried again, or may take only so long.
    pub limits: BTreeMap<NodeId, Limits>,
    /// Nodes that are done more than once.
    pub repeats: BTreeMap<NodeId, Repeat>,
    /// Nodes that are told how urgent they are.
    pub priorities: BTreeMap<NodeId, i32>,
    /// What each node is called; no two alike.
    pub names: Vec<String>,
    /// Channels that the mission did not have; their ids go on behind its own.
    pub channels: Vec<String>,
}

impl Fragment {
    /// A tree of which this is all that there is below root.
    pub fn into_tree(self) -> TreeSpec {
        let below = |node: NodeId| NodeId(node.0 + 1);
        let nodes = [NodeKind::Root].into_iter().chain(self.nodes).collect();
        // The top is its own parent, and root stands above both.
        let parents =
            std::iter::once(NodeId(0)).chain(self.parents.into_iter().enumerate().map(|(index, parent)| match index {
                0 => NodeId(0),
                _ => below(parent),
            }));
        let priorities = self.priorities.into_iter().map(|(node, priority)| (below(node), priority)).collect();
        let mut tree = TreeSpec::new(nodes, Topology::new(parents.collect())).with_priorities(&priorities);
        tree.limits = self.limits.into_iter().map(|(node, limits)| (below(node), limits)).collect();
        tree.repeats = self.repeats.into_iter().map(|(node, repeat)| (below(node), repeat)).collect();
        tree
    }
}
