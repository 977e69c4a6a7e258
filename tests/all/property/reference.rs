//! The rules of the task tree once more, sequentially and over plain data: no messages, no machines, brute force.
//!
//! It imports the vocabulary alone, so that an error in the core cannot be in here by inheritance.

mod branch;
mod certified;
mod cleanup;
mod failing;
mod fairness;
mod feasible;
mod holding;
mod lapse;
mod leases;
mod others;
mod outside;
mod reach;
mod repeat;
mod retry;
mod round;
mod settle;
mod stall;
mod urgent;
mod world;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use ambidex::model::{
    Change, Consequences, ControllerId, Deadline, End, Failing, Fault, Grant, Loss, MissionEnd, MissionSpec, NodeId,
    NodeKind, NodeRange, Objection, Origin, Reason, Reopened, ResourceId, StopCause, Time, Uptake, Urged, WorldState,
};

pub use branch::{Freedom, Next, Rule};
pub use certified::Certified;
pub use leases::{Held, Row};

const TOP: NodeId = NodeId(1);

/// The whole state of a mission.
#[derive(Clone)]
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
    /// What came to pass, in order, until somebody takes it.
    pub log: Vec<Step>,
    /// Nodes that wait after a failure: until when, how long, why.
    waits: BTreeMap<NodeId, (Time, u64, Fault)>,
    /// Controllers that are away, and whether they are awaited.
    away: BTreeMap<ControllerId, (Loss, bool)>,
    awaited: Option<Time>,
    /// What each behavior failed with.
    bad: BTreeSet<(NodeId, ResourceId)>,
    /// What would not do a behavior for reach or kind, with the progress at which that was.
    unfit: BTreeSet<(NodeId, ResourceId, u64)>,
    failed: BTreeSet<NodeId>,
    /// How each node failed that did not fail since it could never run.
    faults: BTreeMap<NodeId, Fault>,
    /// Leaves that failed since they could never run.
    infeasible: BTreeMap<NodeId, Reason>,
    /// Nodes that will have failed: when nothing runs below, or when nothing is left that can be finished.
    failing: BTreeMap<NodeId, Failing>,
    failures: BTreeMap<NodeId, u32>,
    /// When task nodes will have taken too long.
    deadlines: BTreeMap<NodeId, Time>,
    /// Ways that their ORs left, with the progress at which they did.
    left: BTreeMap<NodeId, u64>,
    /// Behaviors that were told to end, and why.
    stopping: BTreeMap<NodeId, StopCause>,
    /// Who was told to end, and why, until somebody takes it.
    told: Vec<(NodeId, StopCause)>,
    /// Nodes that are as urgent as who waits for what they hold.
    urged: BTreeMap<NodeId, i32>,
    /// Who does not ask since it was reserved, before something is granted, ends, lapses or changes.
    hidden: BTreeMap<NodeId, Refusal>,
    /// Who was preempted for which wish, with the progress at which that was.
    preempted: BTreeSet<(NodeId, NodeId, u64)>,
    committed: BTreeMap<NodeId, NodeId>,
    /// What lapsed does not ask before the count of progress grows.
    silent: BTreeMap<NodeId, (u64, NodeId, Reason)>,
    /// How many iterations of each node have ended, when the one now began, and when the next one begins.
    iterated: BTreeMap<NodeId, u32>,
    began: BTreeMap<NodeId, Time>,
    resting: BTreeMap<NodeId, (Time, u64)>,
    /// How many grants to later tasks each task has seen since its own last one, and who is overdue.
    seen: BTreeMap<NodeId, u32>,
    overdue: BTreeSet<NodeId>,
    /// Nodes with a cleanup below whose body something was granted since they began.
    begun: BTreeSet<NodeId>,
    /// Nodes that clean up now.
    cleaning: BTreeSet<NodeId>,
    /// Ways that their ORs will leave, with these ORs.
    leaving: BTreeMap<NodeId, NodeId>,
    /// How the mission will end, and until when cleanups may take.
    ending: Option<(MissionEnd, Time)>,
    progress: u64,
    ever_completed: BTreeSet<NodeId>,
    /// Behaviors that were sent back: in which progress, and for whom while that one needs it.
    redone: BTreeMap<NodeId, (u64, Option<NodeId>)>,
    /// How often an OR was free to choose again.
    pub rechoices: u32,
    /// What a certificate came to in each round to come, if there is one.
    pub certified: VecDeque<Vec<Certified>>,
    /// What operators were told of what they asked for.
    pub taken_up: Vec<(Change, Uptake)>,
    /// What was denied since the world changed or a behavior ended.
    denied: Vec<(Change, Origin, Objection)>,
}

/// A request with all that would serve it.
#[derive(Debug, Clone)]
pub struct Ask {
    pub grant: Grant,
    pub is_heir: bool,
    /// Per claim the resources that fit, with the distance to reach out.
    pub serving: Vec<Vec<(ResourceId, f64)>>,
    /// It is its task's turn.
    pub is_overdue: bool,
    /// With a wish, how much rather another resource than this one.
    pub wish: Option<BTreeMap<ResourceId, u32>>,
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
#[derive(Debug, Clone, Default)]
pub struct Decision {
    pub granted: BTreeMap<NodeId, Grant>,
    pub refused: BTreeMap<NodeId, Refusal>,
    pub reopened: Option<Reopened>,
    pub deadlines: Vec<Deadline>,
    pub urged: Option<Vec<Urged>>,
    pub overdue: Option<Vec<NodeId>>,
}

/// Something that came to pass.
#[derive(Debug, Clone)]
pub enum Step {
    Released { leaf: NodeId, end: End, consequences: Consequences, unfit: Vec<ResourceId> },
    Decided(Decision),
    Infeasible { leaf: NodeId, reason: Reason, consequences: Consequences },
    TimedOut { node: NodeId, consequences: Consequences },
    Reopened(Reopened),
    Ending { end: MissionEnd, until: Time },
    Leaving { way: NodeId },
    Cleaning { node: NodeId },
    Cleaned { node: NodeId, is_done: bool, consequences: Consequences },
    Denied { change: Change, origin: Origin, why: Objection },
    Overtaken { leaf: NodeId, skip: NodeRange, goal: NodeId, consequences: Consequences },
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
            log: Vec::new(),
            waits: BTreeMap::new(),
            away: BTreeMap::new(),
            awaited: None,
            bad: BTreeSet::new(),
            unfit: BTreeSet::new(),
            failed: BTreeSet::new(),
            faults: BTreeMap::new(),
            infeasible: BTreeMap::new(),
            failing: BTreeMap::new(),
            failures: BTreeMap::new(),
            deadlines: BTreeMap::new(),
            left: BTreeMap::new(),
            stopping: BTreeMap::new(),
            told: Vec::new(),
            urged: BTreeMap::new(),
            hidden: BTreeMap::new(),
            preempted: BTreeSet::new(),
            committed: BTreeMap::new(),
            silent: BTreeMap::new(),
            iterated: BTreeMap::new(),
            began: BTreeMap::new(),
            resting: BTreeMap::new(),
            seen: BTreeMap::new(),
            overdue: BTreeSet::new(),
            begun: BTreeSet::new(),
            cleaning: BTreeSet::new(),
            leaving: BTreeMap::new(),
            ending: None,
            progress: 0,
            ever_completed: BTreeSet::new(),
            redone: BTreeMap::new(),
            rechoices: 0,
            certified: VecDeque::new(),
            taken_up: Vec::new(),
            denied: Vec::new(),
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
        self.mission.tree.topology.runs([node])[0]
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

    /// Whether a node fails and waits only for what runs below it to end.
    fn is_canceling(&self, node: NodeId) -> bool {
        self.failing.get(&node).is_some_and(|failing| !failing.finishes)
    }

    /// Whether nothing is granted there any more.
    fn is_over(&self, node: NodeId) -> bool {
        let is_it = |node: &NodeId| {
            self.done.contains(node)
                || self.failed.contains(node)
                || self.is_canceling(*node)
                || self.is_given_up(*node)
        };
        let is_asleep = self.cleans(node).is_some_and(|cleans| !self.cleaning.contains(&cleans));
        is_asleep || self.within(node).iter().any(is_it)
    }

    /// Whether one that waits out a back-off is there.
    fn waits_below(&self, node: NodeId) -> bool {
        let below = self.below(node);
        self.waits.keys().any(|node| below.contains(*node))
    }

    /// Who was told to end since the last time, what runs below a node that fails included.
    pub fn stops(&mut self) -> Vec<(NodeId, StopCause)> {
        self.tell_what_ends();
        let mut told = std::mem::take(&mut self.told);
        told.sort_by_key(|(leaf, _)| *leaf);
        told
    }

    pub(crate) fn tell_what_ends(&mut self) {
        let is_ending = |leaf: &NodeId| {
            let is_it = |node: NodeId| self.is_canceling(node) || self.is_given_up(node);
            self.is_grace_over() || self.within(*leaf).into_iter().any(is_it)
        };
        let told = |leaf: &NodeId| self.stopping.get(leaf) != Some(&StopCause::Ends) && is_ending(leaf);
        let now: Vec<NodeId> = self.running.keys().copied().filter(told).collect();
        now.into_iter().for_each(|leaf| self.tell_to_end(leaf, StopCause::Ends));
    }

    fn tell_to_end(&mut self, leaf: NodeId, cause: StopCause) {
        self.stopping.insert(leaf, cause.clone());
        self.told.push((leaf, cause));
    }
}
