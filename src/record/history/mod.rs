//! What the records of a run come to: the one fold that everything asks that reads a log.

mod apply;
mod causes;
mod controllers;
mod leaf;
mod leases;
mod outside;
mod report;
mod states;
mod tasks;
#[cfg(test)]
mod tests;
mod ways;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use ambidex_model::state::State;
use ambidex_model::{
    ControllerId, FactId, Grant, Header, Location, Loss, MissionEnd, Names, NodeId, ObjectId, Pose, Reason, Record,
    Resource, Runs, StopCause, Time, WorldState,
};

pub use controllers::{ActiveCommand, ControllerView, Controllers, LastError, Presence};
pub use leaf::{Failures, LeafHistory, LeafState, Phase};
pub use leases::{Held, Lane};
use outside::Makers;
pub use outside::OutsideChange;
pub use report::{MissionOutcome, MissionReport};
pub use states::Counts;
use states::LeafStates;
pub use tasks::EndedTask;

/// What a run is at after some of its records, and where it is kept also what it was at before.
///
/// All its times are since the mission began, which is when root decided first; what was before is at 0.
///
/// Ids that the header does not have are passed over.
#[derive(Debug, Clone)]
pub struct History {
    header: Arc<Header>,
    state: State,
    states: LeafStates,
    resources: Vec<Resource>,
    /// Where the base is, as controllers or root said last.
    base: Option<Pose>,
    controllers: Controllers,
    potentials: Runs<Option<f64>>,
    lost: BTreeMap<ControllerId, (Time, Loss)>,
    makers: Makers,
    begun: Option<Time>,
    now: Time,
    messages: u64,
    step_count: usize,
    is_step_over: bool,
    last_release: Option<Time>,
    end: Option<MissionEnd>,
    ended_tasks: VecDeque<EndedTask>,
    /// Objects that are not in the room any more.
    removed: BTreeSet<ObjectId>,
    past: Option<Past>,
}

/// What grows with every grant, and with what others change.
#[derive(Debug, Clone, Default)]
struct Past {
    steps: Vec<Step>,
    rounds: Vec<Time>,
    lanes: Vec<Lane>,
    outside: Vec<OutsideChange>,
    interruptions: Vec<Interruption>,
}

/// A behavior was interrupted, and was to run again.
#[derive(Debug, Clone, PartialEq)]
pub struct Interruption {
    /// When it had ended.
    pub at: Time,
    /// The behavior.
    pub leaf: NodeId,
    /// Why.
    pub cause: StopCause,
}

/// What was granted between two releases.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// When the first of it was.
    pub at: Time,
    /// The behaviors in the order of their grants.
    pub leaves: Vec<NodeId>,
}

impl History {
    /// A run that has not begun, in memory bounded by the mission however long its log is.
    ///
    /// # Panics
    /// When the nodes of the header are no tree in preorder, as those of a header that was read always are.
    pub fn new(header: &Header) -> Self {
        Self::begin(header, None)
    }

    /// The same with phases of leaves, steps, rounds and leases over time.
    ///
    /// # Panics
    /// As [`History::new`].
    pub fn with_past(header: &Header) -> Self {
        let lanes = vec![Lane::default(); header.names.resources.len()];
        Self::begin(header, Some(Past { lanes, ..Past::default() }))
    }

    /// What these records come to, with the past; none where they do not begin with a header.
    pub fn of<'a>(records: impl IntoIterator<Item = &'a Record>) -> Option<Self> {
        let mut records = records.into_iter();
        let Some(Record::Header(header)) = records.next() else { return None };
        let mut history = Self::with_past(header);
        records.for_each(|record| history.apply(record));
        Some(history)
    }

    /// The same without the past.
    #[must_use]
    pub fn present(&self) -> Self {
        Self { past: None, states: self.states.present(), ..self.clone() }
    }

    fn begin(header: &Header, past: Option<Past>) -> Self {
        let names = &header.names;
        let unknown = WorldState::new(Pose::new(0.0, 0.0, 0.0), Vec::new(), Vec::new());
        let mut world = header.start.clone().unwrap_or(unknown);
        world.objects.resize(names.objects.len(), Location::Unknown);
        world.facts.resize(names.facts.len(), false);
        let states = LeafStates::new(header, past.is_some());
        Self {
            state: State::new(Arc::clone(&states.topology), names.resources.len(), world),
            states,
            resources: vec![Resource::default(); names.resources.len()],
            base: header.start.as_ref().map(|start| start.base),
            controllers: Controllers::default(),
            potentials: vec![None; header.nodes.len()].into(),
            lost: BTreeMap::new(),
            makers: Makers::default(),
            begun: None,
            now: Time::ZERO,
            messages: 0,
            step_count: 0,
            is_step_over: true,
            last_release: None,
            end: None,
            ended_tasks: VecDeque::new(),
            removed: BTreeSet::new(),
            past,
            header: Arc::new(header.clone()),
        }
    }

    /// What the ids stand for.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// What everything is called.
    pub fn names(&self) -> &Names {
        &self.header.names
    }

    /// When the mission began, robot time; none before that.
    pub fn begun(&self) -> Option<Time> {
        self.begun
    }

    /// A moment of a record as time since the mission began; 0 for what was before.
    pub fn moment(&self, at: Time) -> Time {
        self.begun.map_or(Time::ZERO, |begun| Time::ZERO + (at - begun))
    }

    /// Time of the last record.
    pub fn now(&self) -> Time {
        self.now
    }

    /// How many rounds were decided.
    pub fn rounds(&self) -> u32 {
        self.state.round()
    }

    /// How many messages went between nodes.
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// How many steps there were: grants between two releases count once.
    pub fn step_count(&self) -> usize {
        self.step_count
    }

    /// How the mission ended; only the first word counts, since what is made safe afterwards ends as canceled.
    pub fn end(&self) -> Option<MissionEnd> {
        self.end
    }

    /// Robot seconds from the beginning to the last release.
    pub fn makespan_s(&self) -> f64 {
        self.last_release.unwrap_or_default().seconds()
    }

    /// The last release, or the last record where something runs on.
    pub fn last_moment(&self) -> Time {
        self.last_release.filter(|_| self.running().is_empty()).unwrap_or(self.now)
    }

    /// What runs, each with what it was granted.
    pub fn running(&self) -> &BTreeMap<NodeId, Grant> {
        self.state.running()
    }

    /// Tree, table, world and what runs, as root has them.
    pub fn state_of_run(&self) -> &State {
        &self.state
    }

    /// Every resource as root told it last, in resource order.
    pub fn resources(&self) -> &[Resource] {
        &self.resources
    }

    /// Robot pose, objects, facts, as root knows them.
    pub fn world(&self) -> &WorldState {
        self.state.world()
    }

    /// Pose of the base in the map frame, as was said last; none before anything was told of it.
    pub fn base(&self) -> Option<Pose> {
        self.base
    }

    /// What each controller is at.
    pub fn controllers(&self) -> &Controllers {
        &self.controllers
    }

    /// When a controller was lost last, and how that was seen.
    pub fn lost(&self, controller: ControllerId) -> Option<(Time, Loss)> {
        self.lost.get(&controller).copied()
    }

    /// Every node in tree order, those of ended tasks too where the past is kept.
    pub fn nodes(&self) -> impl Iterator<Item = NodeId> {
        self.states.topology.in_order(NodeId(0))
    }

    /// Every leaf in the order of ids.
    pub fn leaves(&self) -> impl Iterator<Item = NodeId> {
        let nodes = self.header.nodes.entries();
        nodes.filter(|(_, node)| node.kind.is_behavior()).map(|(node, _)| NodeId::from(node))
    }

    /// The leaves at and below a node, those of ended tasks too where the past is kept.
    pub fn leaves_below(&self, node: NodeId) -> Vec<NodeId> {
        match self.states.topology.has(node) {
            true => self.states.topology.nodes_below(node).filter(|node| self.leaf(*node).is_some()).collect(),
            false => Vec::new(),
        }
    }

    /// What became of a leaf; none of a node that is no leaf.
    pub fn leaf(&self, leaf: NodeId) -> Option<&LeafHistory> {
        self.states.leaf(leaf)
    }

    /// Whether a node is another one or below it.
    pub fn is_within(&self, node: NodeId, top: NodeId) -> bool {
        self.states.path(node).any(|above| above == top)
    }

    /// The part of the mission just below its top that a node belongs to, or the node where it is no part of one; in a run
    /// that takes work the task.
    pub fn task_of(&self, node: NodeId) -> NodeId {
        let topology = &self.states.topology;
        let task = self.states.path(node).find(|above| topology.parent(*above) == NodeId(1));
        task.unwrap_or(node)
    }

    /// Whether a leaf is part of a cleanup.
    pub fn is_in_cleanup(&self, leaf: NodeId) -> bool {
        self.states.topology.has(leaf) && self.states.topology.is_in_cleanup(leaf)
    }

    /// What any node is; a composite is what its leaves and the ends that root applied make it.
    pub fn state(&self, node: NodeId) -> LeafState {
        let state = self.states.state(node);
        // What is done once more may be done as it stands, when the mission ends before that.
        let is_given_up = node == NodeId(1) && self.end.is_some_and(|end| end != MissionEnd::Done);
        if is_given_up && state.is_done() && self.leaf(node).is_none() { LeafState::Canceled } else { state }
    }

    /// How many leaves at or below a node are what.
    pub fn counts(&self, node: NodeId) -> Counts {
        self.states.counts(node)
    }

    /// The potential of a node's last answer; of a running behavior that of its last request.
    pub fn potential(&self, node: NodeId) -> Option<f64> {
        self.potentials.get(node.index()).copied().flatten()
    }

    /// Why a leaf does not run: the last reason that was told, else why it was not asked, if that is known.
    pub fn reason(&self, leaf: NodeId) -> Option<Reason> {
        let told = self.leaf(leaf)?.reason.clone();
        told.or_else(|| self.not_asked(leaf))
    }

    /// What stands before a leaf in a THEN, or the way that an OR went instead of it.
    pub fn not_asked(&self, leaf: NodeId) -> Option<Reason> {
        self.states.not_asked(leaf)
    }

    /// The child by which an OR above a node is done, where the node lies below another one.
    pub fn instead_of(&self, node: NodeId) -> Option<NodeId> {
        self.states.instead_of(node)
    }

    /// The topmost ways that ORs did not need, in tree order, each with the child that did it.
    pub fn ways_left(&self) -> Vec<(NodeId, NodeId)> {
        self.states.ways_left()
    }

    /// The leaves that a grant skips and that were not done before; of an OR those of one way.
    pub fn skipped_by(&self, grant: &Grant) -> Vec<NodeId> {
        self.states.skipped_by(grant)
    }

    /// The leaves that count as skipped once the mission is done: their goal is met though nobody went on from it.
    pub fn met(&self) -> Vec<NodeId> {
        self.states.met()
    }

    /// What is done without having run, in the order in which that was settled, with its time.
    pub fn skipped(&self) -> Vec<(NodeId, Time)> {
        let leaves = self.leaves().filter_map(|leaf| Some((leaf, self.leaf(leaf)?)));
        let mut skipped: Vec<_> = leaves.filter(|(_, history)| history.state() == LeafState::Skipped).collect();
        skipped.sort_by_key(|(_, history)| history.order);
        skipped.into_iter().map(|(leaf, history)| (leaf, history.since)).collect()
    }

    /// The steps so far; empty where the past is not kept.
    pub fn steps(&self) -> &[Step] {
        self.past.as_ref().map_or(&[], |past| &past.steps)
    }

    /// When rounds were decided, several at one moment once; empty where the past is not kept.
    pub fn round_times(&self) -> &[Time] {
        self.past.as_ref().map_or(&[], |past| &past.rounds)
    }

    /// Who was interrupted when, in order; empty where the past is not kept.
    pub fn interruptions(&self) -> &[Interruption] {
        self.past.as_ref().map_or(&[], |past| &past.interruptions)
    }

    /// Who made a fact as it is, where that was no behavior.
    pub fn maker_of_fact(&self, fact: FactId) -> Option<&OutsideChange> {
        self.makers.facts.get(&fact)
    }

    /// Who brought an object to where it is, where that was no behavior.
    pub fn maker_of_object(&self, object: ObjectId) -> Option<&OutsideChange> {
        self.makers.objects.get(&object)
    }

    /// Whether an object is in the room.
    pub fn has_object(&self, object: ObjectId) -> bool {
        // One that went before a log began anew has no name.
        !self.removed.contains(&object) && self.names().objects.get(object.index()).is_some_and(|name| !name.is_empty())
    }

    /// What others changed so far, but for where the base is; empty where the past is not kept.
    pub fn outside_changes(&self) -> &[OutsideChange] {
        self.past.as_ref().map_or(&[], |past| &past.outside)
    }

    /// Who held each resource when, in resource order; empty where the past is not kept.
    pub fn lanes(&self) -> &[Lane] {
        self.past.as_ref().map_or(&[], |past| &past.lanes)
    }
}
