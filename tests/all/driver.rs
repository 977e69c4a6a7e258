//! Carries effects between the machines: first in first out per edge, any order between edges.

mod lockstep;
mod rng;
mod watch;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use ambidex::model::{Change, Goal, MissionEnd, MissionSpec, NodeId, Record, Time, Uptake, Worked};
use ambidex::tree::{Effect, Input, Machines, Outbox, Root, Settings};

pub use lockstep::Lockstep;
pub use rng::Rng;
pub use watch::Watch;

/// The machines of a mission, what is on its way between them, and what came out so far.
pub struct Driver {
    pub now: Time,
    pub records: Vec<Record>,
    pub finished: Option<MissionEnd>,
    /// Goals given to controllers and not ended.
    pub goals: BTreeMap<NodeId, Goal>,
    /// Effects for the world around, in order.
    pub outside: Vec<Outside>,
    /// What came of what somebody asked to be different.
    pub taken_up: Vec<(Change, Uptake)>,
    pub messages: u64,
    /// What came of work that was asked for.
    pub worked: Vec<(u64, Worked)>,
    nodes: Machines,
    edges: BTreeMap<Edge, VecDeque<Input>>,
    interleaving: Rng,
    watch: Watch,
    lockstep: Option<Lockstep>,
}

/// What controllers are told.
#[derive(Debug, Clone)]
pub enum Outside {
    Start(NodeId),
    Stop(NodeId),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Edge {
    Down(NodeId),
    Up(NodeId),
}

impl Driver {
    pub fn new(mission: &Arc<MissionSpec>, settings: &Settings, interleaving: Rng) -> Self {
        Self {
            now: Time::ZERO,
            records: Vec::new(),
            finished: None,
            goals: BTreeMap::new(),
            outside: Vec::new(),
            taken_up: Vec::new(),
            messages: 0,
            worked: Vec::new(),
            nodes: Machines::new(mission, settings),
            edges: BTreeMap::new(),
            interleaving,
            watch: Watch::new(mission),
            lockstep: None,
        }
    }

    /// Compares every round with plain recursion.
    pub fn in_lockstep(self, lockstep: Lockstep) -> Self {
        Self { lockstep: Some(lockstep), ..self }
    }

    /// What was said otherwise than by plain recursion.
    pub fn difference(&self) -> Option<&str> {
        self.lockstep.as_ref()?.difference.as_deref()
    }

    pub fn root(&self) -> &Root {
        self.nodes.root()
    }

    /// Hands an input to a node, and puts on their way what it says.
    pub fn give(&mut self, node: NodeId, input: Input) {
        if let Input::Ended(_) = input {
            self.goals.remove(&node).expect("only what runs ends");
        }
        self.watch.given(node, &input);
        let mut out = Outbox::default();
        self.nodes.handle(self.now, node, input, &mut out);
        for effect in out.drain() {
            if let Some(effect) = self.nodes.change(effect) {
                self.carry(node, effect);
            }
        }
        self.watch.check(node, self.nodes.root(), &self.goals, self.finished);
    }

    /// Delivers one message of those on their way; false if there is none.
    pub fn step(&mut self) -> bool {
        if self.edges.is_empty() {
            return false;
        }
        let which = self.interleaving.below(self.edges.len());
        let (&edge, queue) = self.edges.iter_mut().nth(which).expect("an edge in use");
        let input = queue.pop_front().expect("only edges in use are kept");
        if queue.is_empty() {
            self.edges.remove(&edge);
        }
        self.messages += 1;
        match edge {
            Edge::Down(child) => self.give(child, input),
            Edge::Up(child) => self.give(self.nodes.parent(child), input),
        }
        true
    }

    /// Whether root wants a turn, and nothing is on its way to it: then it can be given one.
    pub fn is_at_rest(&self) -> bool {
        self.edges.is_empty() && !self.is_turn_due()
    }

    pub fn is_turn_due(&self) -> bool {
        let is_for_root = |edge: &Edge| matches!(edge, Edge::Up(child) if self.nodes.parent(*child) == NodeId(0));
        self.root().wants_turn() && !self.edges.keys().any(is_for_root)
    }

    /// # Panics
    /// When it comes to nothing and another one is wanted: they would never end.
    pub fn turn(&mut self) {
        let before = self.records.len();
        self.give(NodeId(0), Input::Turn);
        let is_idle = !self.records[before..].iter().any(|record| !matches!(record, Record::Turn { .. }));
        assert!(!(is_idle && self.root().wants_turn() && self.edges.is_empty()), "turns without end");
    }

    /// Delivers messages, and gives root its turns, until there is nothing left of either.
    pub fn rest(&mut self) {
        self.rest_watched(|_| ());
    }

    /// The same; `watch` sees all records behind each turn.
    pub fn rest_watched(&mut self, mut watch: impl FnMut(&[Record])) {
        loop {
            if self.step() {
                continue;
            }
            if !self.root().wants_turn() {
                break;
            }
            self.turn();
            watch(&self.records);
        }
        self.watch.rested();
    }

    fn carry(&mut self, node: NodeId, effect: Effect) {
        match effect {
            Effect::Down(child, down) => {
                assert_eq!(self.nodes.parent(child), node, "down goes to children");
                self.watch.said_down(child, &down);
                self.lockstep.iter_mut().for_each(|lockstep| lockstep.said_down(child, &down));
                self.send(Edge::Down(child), Input::Down(down));
            }
            Effect::Up(up) => {
                self.watch.said_up(node, &up);
                self.lockstep.iter_mut().for_each(|lockstep| lockstep.said_up(node, &up));
                self.send(Edge::Up(node), Input::Up(up));
            }
            Effect::Start(goal) => {
                assert_eq!(goal.leaf, node, "a leaf starts itself");
                self.outside.push(Outside::Start(node));
                let before = self.goals.insert(node, goal);
                assert!(before.is_none(), "{node:?} starts twice");
            }
            Effect::Worked(number, worked) => self.worked.push((number, worked)),
            Effect::Mission(mission) => {
                self.watch.know(&mission);
                self.lockstep.iter_mut().for_each(|lockstep| lockstep.know(&mission));
            }
            Effect::Spawn { .. } | Effect::Retire { .. } => unreachable!("nodes came and went"),
            Effect::TakenUp(change, uptake) => self.taken_up.push((change, uptake)),
            Effect::Stop(leaf) => {
                // What ended in the meantime is not told any more.
                if self.goals.contains_key(&leaf) {
                    self.outside.push(Outside::Stop(leaf));
                }
            }
            Effect::Record(record) => {
                self.watch.recorded(&record);
                self.records.push(*record);
            }
            Effect::Finished(end) => {
                assert!(self.finished.is_none(), "a mission ends once");
                self.finished = Some(end);
            }
        }
    }

    fn send(&mut self, edge: Edge, input: Input) {
        self.edges.entry(edge).or_default().push_back(input);
    }
}
