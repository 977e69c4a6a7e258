//! The rules of the task tree once more, sequentially and over plain data: no messages, no machines, brute force.
//!
//! It imports the vocabulary alone, so that an error in the core cannot be in here by inheritance.

mod lapse;
mod leases;
mod round;
mod settle;
mod world;

use std::collections::{BTreeMap, BTreeSet};

use ambidex::model::{
    ControllerId, Fault, Grant, Loss, MissionEnd, MissionSpec, NodeId, NodeKind, NodeRange, Reason, Reopened,
    ResourceId, Time, WorldState,
};

pub use leases::{Held, Row};

/// The whole state of a mission.
pub struct Model<'a> {
    pub mission: &'a MissionSpec,
    /// One behavior at a time.
    pub is_serial: bool,
    /// Pairs of behaviors that must not go on at once.
    pub clashing: &'a [(NodeId, NodeId)],
    /// Who holds what, by resource.
    pub rows: Vec<Row>,
    pub world_state: WorldState,
    pub running: BTreeMap<NodeId, Grant>,
    pub done: BTreeSet<NodeId>,
    pub end: Option<MissionEnd>,
    pub now: Time,
    /// Behaviors that wait after a failure: until when, how long, why.
    waits: BTreeMap<NodeId, (Time, u64, Fault)>,
    /// Controllers that are away, and whether they are awaited.
    away: BTreeMap<ControllerId, (Loss, bool)>,
    awaited: Option<Time>,
    /// What each behavior failed with.
    bad: BTreeSet<(NodeId, ResourceId)>,
    failed: BTreeSet<NodeId>,
    /// Nodes that fail and wait for what runs below: the child that failed, the leaf it began with.
    ending: BTreeMap<NodeId, (NodeId, NodeId)>,
    failures: BTreeMap<NodeId, u32>,
    committed: BTreeMap<NodeId, NodeId>,
    /// What lapsed does not ask before the count of progress grows.
    silent: BTreeMap<NodeId, (u64, NodeId, Reason)>,
    progress: u64,
    ever_completed: BTreeSet<NodeId>,
    keepers: BTreeSet<(NodeId, NodeId)>,
    /// How often an OR was free to choose again.
    pub rechoices: u32,
}

/// A request with all that would serve it.
#[derive(Debug, Clone)]
pub struct Ask {
    pub grant: Grant,
    pub is_heir: bool,
    /// Per claim the resources that fit, with the distance to reach out.
    pub serving: Vec<Vec<(ResourceId, f64)>>,
}

/// Why a leaf does not run, and what would have to end for that to change.
#[derive(Debug, Clone)]
pub struct Refusal {
    pub reason: Reason,
    pub resources: Vec<ResourceId>,
    pub behaviors: Vec<NodeId>,
    /// It will ask again by itself.
    pub waits: bool,
}

/// What a round came to.
#[derive(Debug, Default)]
pub struct Decision {
    pub granted: BTreeMap<NodeId, Grant>,
    pub refused: BTreeMap<NodeId, Refusal>,
    pub reopened: Option<Reopened>,
}

impl From<Reason> for Refusal {
    fn from(reason: Reason) -> Self {
        Self { reason, resources: Vec::new(), behaviors: Vec::new(), waits: false }
    }
}

impl<'a> Model<'a> {
    pub fn new(mission: &'a MissionSpec, is_serial: bool, clashing: &'a [(NodeId, NodeId)]) -> Self {
        Self {
            mission,
            is_serial,
            clashing,
            rows: vec![Row::default(); mission.robot.resources.len()],
            world_state: mission.start.clone(),
            running: BTreeMap::new(),
            done: BTreeSet::new(),
            end: None,
            now: Time::ZERO,
            waits: BTreeMap::new(),
            away: BTreeMap::new(),
            awaited: None,
            bad: BTreeSet::new(),
            failed: BTreeSet::new(),
            ending: BTreeMap::new(),
            failures: BTreeMap::new(),
            committed: BTreeMap::new(),
            silent: BTreeMap::new(),
            progress: 0,
            ever_completed: BTreeSet::new(),
            keepers: BTreeSet::new(),
            rechoices: 0,
        }
    }

    fn kind(&self, node: NodeId) -> &'a NodeKind {
        &self.mission.tree.nodes[node.index()]
    }

    fn parent(&self, node: NodeId) -> NodeId {
        self.mission.tree.topology.parent(node)
    }

    fn children(&self, node: NodeId) -> Vec<NodeId> {
        self.mission.tree.topology.children(node).collect()
    }

    fn below(&self, node: NodeId) -> NodeRange {
        NodeRange { from: node, to: self.mission.tree.topology.end(node) }
    }

    fn runs_below(&self, node: NodeId) -> bool {
        let below = self.below(node);
        self.running.keys().any(|leaf| below.contains(*leaf))
    }

    /// The node and all above it, from below; root included.
    fn upward(&self, node: NodeId) -> Vec<NodeId> {
        let mut path = vec![node];
        while let Some(&top) = path.last().filter(|top| top.0 > 0) {
            path.push(self.parent(top));
        }
        path
    }
}
