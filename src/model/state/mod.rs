//! What a run has come to: tree, table, world, what runs. Root decides on it and says every change of it as a record;
//! whoever reads the records has the same state, since [`State::apply`] is all that ever changes one.

mod anew;
mod apply;
mod check;
mod chunks;
mod decided;
mod saved;
mod status;
mod tasks;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::{
    FactId, Failing, Grant, Granting, MissionEnd, NodeId, PlaceId, Reason, ResourceId, ResourceTable, StopCause, Time,
    Topology, WorldState,
};
pub use chunks::Chunks;
pub use saved::{Saved, SavedRoot};
pub use status::{Bar, GoesOn, Pause, Phase, Redone, Status, Unfit, Wait};
pub use tasks::Task;

/// The state of a run. A clone is cheap: it shares everything that neither of the two changes afterwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    topology: Arc<Topology>,
    nodes: Chunks<Status>,
    redone: Arc<BTreeMap<NodeId, Redone>>,
    table: Arc<ResourceTable>,
    world: Arc<WorldState>,
    running: Arc<BTreeMap<NodeId, Grant>>,
    waits: Arc<BTreeSet<(Time, NodeId)>>,
    is_awaiting: bool,
    deadlines: Arc<BTreeSet<(Time, NodeId)>>,
    /// Task nodes with the moment at which they will have taken too long.
    timed: Arc<BTreeMap<NodeId, Time>>,
    /// Ways that their ORs left, with the progress at which they did.
    left: Arc<BTreeMap<NodeId, u64>>,
    /// How often nodes that are done more than once have been done.
    iterations: Arc<BTreeMap<NodeId, u32>>,
    pauses: Arc<BTreeMap<NodeId, Pause>>,
    /// Nodes that are as urgent as who waits for what they hold.
    urged: Arc<BTreeMap<NodeId, i32>>,
    /// Tasks that have waited for so long that it is their turn.
    overdue: Arc<BTreeSet<NodeId>>,
    /// Nodes whose cleanup is done.
    cleaning: Arc<BTreeSet<NodeId>>,
    /// Why behaviors were told to end that will ask again.
    interrupted: Arc<BTreeMap<NodeId, StopCause>>,
    ending: Option<(MissionEnd, Time)>,
    infeasible: Arc<BTreeMap<NodeId, Reason>>,
    unfit: Arc<BTreeMap<NodeId, Unfit>>,
    awaited_until: Option<Time>,
    awaited_of_others: Arc<(Vec<FactId>, Vec<PlaceId>)>,
    round: u32,
    progress: u64,
    stage: Stage,
    tasks: Arc<BTreeMap<NodeId, Task>>,
    granting: Granting,
}

/// How far a mission is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
            nodes: Chunks::default(),
            topology,
            redone: Arc::default(),
            table: Arc::new(ResourceTable::new(resources)),
            world: Arc::new(world),
            running: Arc::default(),
            waits: Arc::default(),
            is_awaiting: false,
            deadlines: Arc::default(),
            timed: Arc::default(),
            left: Arc::default(),
            iterations: Arc::default(),
            pauses: Arc::default(),
            urged: Arc::default(),
            overdue: Arc::default(),
            cleaning: Arc::default(),
            interrupted: Arc::default(),
            ending: None,
            infeasible: Arc::default(),
            unfit: Arc::default(),
            awaited_until: None,
            awaited_of_others: Arc::default(),
            round: 0,
            progress: 0,
            stage: Stage::Waiting,
            tasks: Arc::default(),
            granting: Granting::Freely,
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

    /// Whether nothing at or below a node is granted any more: it or one above is done, has failed, is given up, or waits
    /// for what runs to end. A cleanup is, but for while it is done.
    pub fn is_over(&self, node: NodeId) -> bool {
        let mut child = node;
        for node in self.topology.path(node) {
            let phase = self.phase(node);
            if child != node && self.topology.is_cleanup(child) {
                return !matches!(phase, Phase::Cleaning(_));
            }
            match phase {
                Phase::Pending | Phase::Failing(Failing { finishes: true, .. }) => {}
                Phase::Done | Phase::Failed | Phase::Failing(_) | Phase::Ending | Phase::Cleaning(_) => return true,
            }
            child = node;
        }
        false
    }

    /// Whether what runs at or below a node is to end, since one above fails or is given up.
    pub fn is_ending(&self, node: NodeId) -> bool {
        let mut child = node;
        for node in self.topology.path(node) {
            if child != node && self.topology.is_cleanup(child) {
                return false;
            }
            match self.phase(node) {
                Phase::Ending | Phase::Failing(Failing { finishes: false, .. }) => return true,
                Phase::Pending | Phase::Failing(_) | Phase::Done | Phase::Failed | Phase::Cleaning(_) => {}
            }
            child = node;
        }
        false
    }

    /// The first cleanup in tree order, at or below a node, that was begun and is not over or is yet to be done: its node;
    /// `but` is passed over.
    pub fn owed_cleanup(&self, top: NodeId, but: Option<NodeId>) -> Option<NodeId> {
        self.owed_cleanups(top, but).next()
    }

    /// All of these.
    pub fn owed_cleanups(&self, top: NodeId, but: Option<NodeId>) -> impl Iterator<Item = NodeId> {
        let cleanups = self.topology.of_set(top, self.topology.cleanups());
        let nodes = cleanups.map(|cleanup| self.topology.parent(cleanup));
        let mut nodes: Vec<NodeId> =
            nodes.filter(|node| self.topology.is_within(*node, top) && Some(*node) != but).collect();
        nodes.sort_unstable();
        nodes.into_iter().filter(move |node| {
            let mut up_to_top = self.topology.path(*node).take_while(|above| *above >= top);
            let is_left = up_to_top.all(|node| !matches!(self.phase(node), Phase::Done | Phase::Failed));
            // One that goes on is not cut short, though another way of an OR above is done.
            self.cleaning.contains(node) || (is_left && self.status(*node).is_begun)
        })
    }

    /// Nodes whose cleanup is done.
    pub fn cleaning(&self) -> &BTreeSet<NodeId> {
        &self.cleaning
    }

    /// How the mission will have ended, and until when cleanups may take; none while it is not told to end.
    pub fn ending(&self) -> Option<(MissionEnd, Time)> {
        self.ending
    }

    /// How often a node has been done that is done more than once.
    pub fn iterations(&self, node: NodeId) -> u32 {
        self.iterations.get(&node).copied().unwrap_or_default()
    }

    /// Nodes that wait for their next time.
    pub fn pauses(&self) -> &BTreeMap<NodeId, Pause> {
        &self.pauses
    }

    /// Nodes that are as urgent as who waits for what they hold.
    pub fn urged(&self) -> &BTreeMap<NodeId, i32> {
        &self.urged
    }

    /// Tasks that have waited for so long that it is their turn.
    pub fn overdue(&self) -> &BTreeSet<NodeId> {
        &self.overdue
    }

    /// Why a behavior that runs was told to end, if it will ask again.
    pub fn interrupted(&self, leaf: NodeId) -> Option<&StopCause> {
        self.interrupted.get(&leaf)
    }

    /// Task nodes whose time runs, with the moment at which they will have taken too long, the next one first.
    pub fn deadlines(&self) -> &BTreeSet<(Time, NodeId)> {
        &self.deadlines
    }

    /// Whether the time of a task node runs.
    pub fn is_timed(&self, node: NodeId) -> bool {
        self.timed.contains_key(&node)
    }

    /// Whether an OR has left a way since there was progress.
    pub fn was_left(&self, way: NodeId) -> bool {
        self.left.get(&way) == Some(&self.progress)
    }

    /// Behaviors that failed since they could never run, each with what it lacked.
    pub fn infeasible(&self) -> &BTreeMap<NodeId, Reason> {
        &self.infeasible
    }

    /// What would not do a behavior, for reach or kind, as the world is now.
    pub fn unfit(&self, leaf: NodeId) -> &[ResourceId] {
        let unfit = self.unfit.get(&leaf).filter(|unfit| unfit.progress == self.progress);
        unfit.map_or(&[], |unfit| &unfit.resources)
    }

    /// Nodes that wait after a failure, with the moment at which they ask again, the next one first.
    pub fn waits(&self) -> &BTreeSet<(Time, NodeId)> {
        &self.waits
    }

    /// Whether the mission waits for a controller without which nothing can go on.
    pub fn is_awaiting(&self) -> bool {
        self.is_awaiting
    }

    /// Facts that others are to set or clear before anything can go on, and places to which the way is to be free.
    pub fn awaited_of_others(&self) -> (&[FactId], &[PlaceId]) {
        let (facts, places) = &*self.awaited_of_others;
        (facts, places)
    }

    /// Until when it does; none where it does so without limit.
    pub fn awaited_until(&self) -> Option<Time> {
        self.awaited_until
    }

    /// What runs at or below a node.
    pub fn running_below(&self, node: NodeId) -> impl Iterator<Item = (NodeId, &Grant)> {
        self.topology.within(node, &self.running)
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
