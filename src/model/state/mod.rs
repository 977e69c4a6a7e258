//! What a run has come to: tree, table, world, what runs. Root decides on it and says every change of it as a record;
//! whoever reads the records has the same state, since [`State::apply`] is all that ever changes one.

mod apply;
mod check;
mod chunks;
mod status;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::{Grant, MissionEnd, NodeId, ResourceTable, Time, Topology, WorldState};
pub use chunks::Chunks;
pub use status::{Bar, Phase, Redone, Status, Wait};

/// The state of a run. A clone is cheap: it shares everything that neither of the two changes afterwards.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    topology: Arc<Topology>,
    nodes: Chunks<Status>,
    redone: Arc<BTreeMap<NodeId, Redone>>,
    table: Arc<ResourceTable>,
    world: Arc<WorldState>,
    running: Arc<BTreeMap<NodeId, Grant>>,
    waits: Arc<BTreeSet<(Time, NodeId)>>,
    is_awaiting: bool,
    awaited_until: Option<Time>,
    round: u32,
    progress: u64,
    stage: Stage,
}

/// How far a mission is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// It has not begun.
    Waiting,
    /// It goes on.
    Running,
    /// It is over.
    Over(MissionEnd),
}

impl State {
    /// Before the mission begins.
    pub fn new(topology: Arc<Topology>, resources: usize, world: WorldState) -> Self {
        Self {
            nodes: Chunks::new(topology.count()),
            topology,
            redone: Arc::default(),
            table: Arc::new(ResourceTable::new(resources)),
            world: Arc::new(world),
            running: Arc::default(),
            waits: Arc::default(),
            is_awaiting: false,
            awaited_until: None,
            round: 0,
            progress: 0,
            stage: Stage::Waiting,
        }
    }

    /// The shape of the tree.
    pub fn topology(&self) -> &Arc<Topology> {
        &self.topology
    }

    /// What a node has come to.
    pub fn status(&self, node: NodeId) -> &Status {
        self.nodes.get(node.index())
    }

    /// How far a node is.
    pub fn phase(&self, node: NodeId) -> Phase {
        self.status(node).phase
    }

    /// Whether a node's goal is reached.
    pub fn is_done(&self, node: NodeId) -> bool {
        self.phase(node) == Phase::Done
    }

    /// Behaviors that were sent back, and for whom.
    pub fn redone(&self) -> &BTreeMap<NodeId, Redone> {
        &self.redone
    }

    /// Who holds what.
    pub fn table(&self) -> &Arc<ResourceTable> {
        &self.table
    }

    /// Robot pose, objects, facts.
    pub fn world(&self) -> &WorldState {
        &self.world
    }

    /// Behaviors that were granted and have not ended, by leaf.
    pub fn running(&self) -> &BTreeMap<NodeId, Grant> {
        &self.running
    }

    /// Behaviors that wait after a failure, with the moment at which they ask again, the next one first.
    pub fn waits(&self) -> &BTreeSet<(Time, NodeId)> {
        &self.waits
    }

    /// Whether the mission waits for a controller without which nothing can go on.
    pub fn is_awaiting(&self) -> bool {
        self.is_awaiting
    }

    /// Until when it does; none where it does so without limit.
    pub fn awaited_until(&self) -> Option<Time> {
        self.awaited_until
    }

    /// What runs at or below a node.
    pub fn running_below(&self, node: NodeId) -> impl Iterator<Item = (NodeId, &Grant)> {
        self.running.range(node..self.topology.end(node)).map(|(&leaf, grant)| (leaf, grant))
    }

    /// Whether something at or below a node runs.
    pub fn is_busy(&self, node: NodeId) -> bool {
        self.running_below(node).next().is_some()
    }

    /// The last round that was decided.
    pub fn round(&self) -> u32 {
        self.round
    }

    /// Grows when a behavior completes that had not before, or the world changes from outside.
    pub fn progress(&self) -> u64 {
        self.progress
    }

    /// How far the mission is.
    pub fn stage(&self) -> Stage {
        self.stage
    }
}
