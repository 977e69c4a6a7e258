//! What the records of a run come to: the one fold that everything asks that reads a log.

mod controllers;
mod leaf;
mod leases;
mod report;
mod states;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::Arc;

use ambidex_model::{
    Blocked, Change, Consequences, ControllerId, ControllerMessage, ControllerState, End, FromController, Grant,
    Header, Location, Message, MissionEnd, Names, NodeId, Pose, Reason, Record, Reopened, Resource, ResourceId, Time,
    WorldState,
};

pub use controllers::{ActiveCommand, ControllerView, Controllers, LastError, Presence};
pub use leaf::{Failures, LeafHistory, LeafState, Phase};
pub use leases::{Held, Lane};
pub use report::{MissionOutcome, MissionReport};
pub use states::Counts;
use states::LeafStates;

/// What a run is at after some of its records, and where it is kept also what it was at before.
///
/// Ids that the header does not have are passed over.
#[derive(Debug, Clone)]
pub struct History {
    header: Arc<Header>,
    states: LeafStates,
    running: BTreeMap<NodeId, Grant>,
    resources: Vec<Resource>,
    world: WorldState,
    is_base_known: bool,
    controllers: Controllers,
    potentials: Vec<Option<f64>>,
    lost: BTreeMap<ControllerId, Time>,
    now: Time,
    rounds: u32,
    messages: u64,
    step_count: usize,
    is_step_over: bool,
    first_grant: Option<Time>,
    last_release: Option<Time>,
    end: Option<MissionEnd>,
    past: Option<Past>,
}

/// What grows with every grant.
#[derive(Debug, Clone, Default)]
struct Past {
    steps: Vec<Step>,
    rounds: Vec<Time>,
    lanes: Vec<Lane>,
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

    fn begin(header: &Header, past: Option<Past>) -> Self {
        let names = &header.names;
        let unknown = WorldState { base: Pose::new(0.0, 0.0, 0.0), objects: Vec::new(), facts: Vec::new() };
        let mut world = header.start.clone().unwrap_or(unknown);
        world.objects.resize(names.objects.len(), Location::Unknown);
        world.facts.resize(names.facts.len(), false);
        Self {
            states: LeafStates::new(header, past.is_some()),
            running: BTreeMap::new(),
            resources: vec![Resource::default(); names.resources.len()],
            world,
            is_base_known: header.start.is_some(),
            controllers: Controllers::default(),
            potentials: vec![None; header.nodes.len()],
            lost: BTreeMap::new(),
            now: Time::ZERO,
            rounds: 0,
            messages: 0,
            step_count: 0,
            is_step_over: true,
            first_grant: None,
            last_release: None,
            end: None,
            past,
            header: Arc::new(header.clone()),
        }
    }

    /// Takes the next record.
    pub fn apply(&mut self, record: &Record) {
        self.now = record.at();
        self.controllers.forget_ended();
        match record {
            Record::Header(_) => {}
            Record::Sent { from, message, .. } => self.sent(*from, message),
            Record::Decided { at, round, granted, refused, reopened } => {
                self.rounds = *round;
                if let Some(past) = self.past.as_mut().filter(|past| past.rounds.last() != Some(at)) {
                    past.rounds.push(*at);
                }
                granted.iter().for_each(|grant| self.grant(*at, grant));
                refused.iter().for_each(|blocked| self.refuse(blocked));
                reopened.iter().for_each(|reopened| self.reopen(*at, reopened));
            }
            Record::Released { at, leaf, end, consequences, changes } => {
                self.release(*at, *leaf, *end, *consequences);
                changes.iter().for_each(|change| self.change(*change));
            }
            Record::World { change, .. } => self.change(*change),
            Record::Resource { at, resource, state } => {
                if let Some(known) = self.resources.get_mut(resource.index()) {
                    known.clone_from(state);
                }
                if let Some(lane) = self.past.as_mut().and_then(|past| past.lanes.get_mut(resource.index())) {
                    lane.change(*at, state);
                }
            }
            Record::Controller { at, controller, message } => {
                self.controllers.apply(*at, *controller, message);
                self.hear(*at, *controller, message);
            }
            Record::Ended { at, end } => self.finish(*at, *end),
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

    /// Time of the last record.
    pub fn now(&self) -> Time {
        self.now
    }

    /// How many rounds were decided.
    pub fn rounds(&self) -> u32 {
        self.rounds
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

    /// Robot seconds from the first grant to the last release.
    pub fn makespan_s(&self) -> f64 {
        self.first_grant.zip(self.last_release).map_or(0.0, |(first, last)| (last - first).as_secs_f64())
    }

    /// From the first grant, since waiting for controllers says nothing of the task, to the last release, or to the
    /// last record where something runs on.
    pub fn span(&self) -> (Time, Time) {
        let end = self.last_release.filter(|_| self.running.is_empty()).unwrap_or(self.now);
        (self.first_grant.unwrap_or_default(), end)
    }

    /// What runs, each with what it was granted.
    pub fn running(&self) -> &BTreeMap<NodeId, Grant> {
        &self.running
    }

    /// Every resource as root told it last, in resource order.
    pub fn resources(&self) -> &[Resource] {
        &self.resources
    }

    /// Robot pose, objects, facts: as root knows them, corrected by what controllers say.
    pub fn world(&self) -> &WorldState {
        &self.world
    }

    /// Pose of the base in the map frame; none before anything was told of it.
    pub fn base(&self) -> Option<Pose> {
        self.is_base_known.then_some(self.world.base)
    }

    /// What each controller is at.
    pub fn controllers(&self) -> &Controllers {
        &self.controllers
    }

    /// When a controller was lost last.
    pub fn lost_at(&self, controller: ControllerId) -> Option<Time> {
        self.lost.get(&controller).copied()
    }

    /// Every leaf in tree order.
    pub fn leaves(&self) -> impl Iterator<Item = NodeId> {
        let nodes = self.header.nodes.iter().enumerate();
        nodes.filter(|(_, node)| node.kind.is_behavior()).map(|(node, _)| NodeId::from(node))
    }

    /// What became of a leaf; none of a node that is no leaf.
    pub fn leaf(&self, leaf: NodeId) -> Option<&LeafHistory> {
        self.states.leaf(leaf)
    }

    /// What any node is; a composite is what its leaves and the ends that root applied make it.
    pub fn state(&self, node: NodeId) -> LeafState {
        self.states.state(node)
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

    /// Every leaf that is not done and does not run, in tree order, with why.
    pub fn open(&self) -> impl Iterator<Item = (NodeId, Option<Reason>)> {
        let is_open = |leaf: &NodeId| self.state(*leaf).is_open();
        self.leaves().filter(is_open).map(|leaf| (leaf, self.reason(leaf)))
    }

    /// What stands before a leaf in a THEN, or the way that an OR went instead of it.
    pub fn not_asked(&self, leaf: NodeId) -> Option<Reason> {
        self.states.not_asked(leaf)
    }

    /// The leaves that a grant skips and that were not done before.
    pub fn skipped_by(&self, grant: &Grant) -> Vec<NodeId> {
        let is_open = |leaf: &NodeId| self.leaf(*leaf).is_some_and(|leaf| leaf.state().is_open());
        grant.skipped(self.header.nodes.len()).filter(is_open).collect()
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

    /// Who held each resource when, in resource order; empty where the past is not kept.
    pub fn lanes(&self) -> &[Lane] {
        self.past.as_ref().map_or(&[], |past| &past.lanes)
    }

    fn sent(&mut self, from: NodeId, message: &Message) {
        self.messages += 1;
        match message {
            // A behavior that runs asks for nothing: what it was granted with still says most.
            Message::Answer { running: true, potential: None, .. } if self.leaf(from).is_some() => {}
            Message::Answer { potential, .. } => self.ask(from, *potential),
            Message::Activation
            | Message::Verdict { .. }
            | Message::Reopen { .. }
            | Message::Cancel
            | Message::Release { .. } => {}
        }
    }

    fn ask(&mut self, node: NodeId, potential: Option<f64>) {
        if let Some(last) = self.potentials.get_mut(node.index()) {
            *last = potential;
        }
    }

    fn grant(&mut self, at: Time, grant: &Grant) {
        let leaf = grant.leaf();
        for skipped in self.skipped_by(grant) {
            self.states.enter(skipped, at, Phase::Skipped);
        }
        let Some(history) = self.states.leaf_mut(leaf) else { return };
        (history.reason, history.last_end) = (None, None);
        self.states.enter(leaf, at, Phase::Active);
        self.running.insert(leaf, grant.clone());
        self.first_grant = Some(self.first_grant.map_or(at, |first| first.min(at)));
        let is_new = std::mem::take(&mut self.is_step_over);
        self.step_count += usize::from(is_new);
        let Some(past) = &mut self.past else { return };
        match past.steps.last_mut().filter(|_| !is_new) {
            Some(step) => step.leaves.push(leaf),
            None => past.steps.push(Step { at, leaves: vec![leaf] }),
        }
    }

    fn refuse(&mut self, blocked: &Blocked) {
        if let Some(leaf) = self.states.leaf_mut(blocked.leaf) {
            leaf.reason = Some(blocked.reason.clone());
        }
    }

    fn reopen(&mut self, at: Time, reopened: &Reopened) {
        self.is_step_over |= reopened.lapsed.is_some();
        self.states.reopen(reopened.leaf, at);
        if let Some(leaf) = self.states.leaf_mut(reopened.leaf) {
            leaf.reopened = Some(reopened.clone());
        }
    }

    fn release(&mut self, at: Time, leaf: NodeId, end: End, consequences: Consequences) {
        self.is_step_over = true;
        self.controllers.release(leaf);
        self.ask(leaf, None);
        if self.running.remove(&leaf).is_some() {
            self.last_release = Some(self.last_release.map_or(at, |last| last.max(at)));
        }
        let Some(history) = self.states.leaf_mut(leaf) else { return };
        history.last_end = Some(end);
        if let End::Failed(fault) = end {
            history.fail(at, fault);
        }
        let is_final = consequences.failed.is_some() || self.end.is_some();
        self.states.enter(leaf, at, Phase::ended(end, is_final));
        self.states.settle(leaf, at, consequences);
    }

    /// A controller that was configured says how things are, which wins; a base says where it is all the time.
    fn hear(&mut self, at: Time, controller: ControllerId, message: &ControllerMessage) {
        let message = match message {
            ControllerMessage::Heard { message } => message,
            ControllerMessage::Lost => {
                self.lost.insert(controller, at);
                return;
            }
            ControllerMessage::Attached
            | ControllerMessage::Told { .. }
            | ControllerMessage::Joined { .. }
            | ControllerMessage::Refused { .. } => return,
        };
        match message {
            FromController::Configured { state, .. } => self.observe(state, controller),
            FromController::Feedback { state, .. } | FromController::Result { state, .. } => match state {
                ControllerState::Base { pose, .. } => self.change(Change::Base(*pose)),
                ControllerState::Arm { .. } | ControllerState::Head { .. } => {}
            },
            FromController::Accepted { .. } | FromController::Rejected { .. } => {}
        }
    }

    fn observe(&mut self, state: &ControllerState, controller: ControllerId) {
        let movers = self.header.movers.iter().enumerate();
        let moved = movers.filter(|(_, mover)| **mover == Some(controller)).map(|(index, _)| ResourceId::from(index));
        let changes = state.changes(moved);
        changes.into_iter().for_each(|change| self.change(change));
    }

    fn change(&mut self, change: Change) {
        let is_known = match change {
            Change::Base(_) | Change::Emptied(_) => true,
            Change::Object(object, _) => object.index() < self.world.objects.len(),
            Change::Fact(fact, _) => fact.index() < self.world.facts.len(),
        };
        if is_known {
            self.is_base_known |= matches!(change, Change::Base(_));
            self.world.apply(change);
        }
    }

    fn finish(&mut self, at: Time, end: MissionEnd) {
        if *self.end.get_or_insert(end) == MissionEnd::Done {
            for leaf in self.met() {
                self.states.enter(leaf, at, Phase::Skipped);
            }
            self.states.complete(at);
        }
        self.states.end();
    }
}
