//! What goes into a node and what comes out.

use std::sync::Arc;

use super::{Down, Settings, Up};
use ambidex_model::{Change, Goal, MissionEnd, MissionSpec, NodeId, Outcome, Record, Time, Told, Uptake, Worked};

/// What reaches a node. What is rare and large lies behind a pointer: every inbox has room for 32 of these.
#[derive(Debug, Clone)]
pub enum Input {
    /// From its parent.
    Down(Down),
    /// From a child.
    Up(Up),
    /// To a leaf, from its controllers: the goal ended.
    Ended(Box<Outcome>),
    /// To root, from outside the tree.
    Told(Box<Told>),
    /// To root: the base is here while a goal runs; no round comes of it.
    Observed(Change),
    /// To root, when it [`wants one`](super::Root::wants_turn) and nothing else is there for it: take up what came and
    /// decide.
    Turn,
}

impl From<Told> for Input {
    fn from(told: Told) -> Self {
        Self::Told(Box::new(told))
    }
}

/// What a node wants done.
#[derive(Debug)]
pub enum Effect {
    /// Tell a child.
    Down(NodeId, Down),
    /// Tell the parent.
    Up(Up),
    /// Give the goal to its controllers.
    Start(Goal),
    /// Cancel the goal of this leaf.
    Stop(NodeId),
    /// What came of what somebody outside asked to be different.
    TakenUp(Change, Uptake),
    /// What came of the work that was asked for, counted from 1.
    Worked(u64, Worked),
    /// Nodes are there from now on: the first is a child of `under`, each of the others of one that stands before it.
    Spawn {
        /// Whose child the first one is.
        under: NodeId,
        /// Each with its parent.
        nodes: Vec<(NodeId, NodeId)>,
        /// Of which mission.
        mission: Arc<MissionSpec>,
        /// How it is run.
        settings: Box<Settings>,
    },
    /// A node and all below it are gone, and get nothing any more.
    Retire {
        /// Whose child it was.
        under: NodeId,
        /// The node and those below it, the node first.
        nodes: Vec<NodeId>,
    },
    /// The mission as it is from now on, for whoever looks at more than nodes.
    Mission(Arc<MissionSpec>),
    /// Write it down.
    Record(Box<Record>),
    /// The mission is over.
    Finished(MissionEnd),
}

impl Effect {
    /// The record of a message that `from` sends with this effect, to its parent or a child; none for what is no message.
    pub fn message(&self, at: Time, from: NodeId, parent: NodeId) -> Option<Record> {
        let (to, round, message) = match self {
            Self::Down(to, down) => (*to, down.round(), down.record(*to)),
            Self::Up(up) => (parent, up.round(), up.record(from)),
            Self::Start(_) | Self::Stop(_) | Self::Record(_) => return None,
            Self::TakenUp(..) | Self::Worked(..) | Self::Finished(_) => return None,
            Self::Spawn { .. } | Self::Retire { .. } | Self::Mission(_) => return None,
        };
        Some(Record::Sent { at, round, from, to, message })
    }
}

/// Collects the effects of one input.
#[derive(Debug, Default)]
pub struct Outbox {
    effects: Vec<Effect>,
}

impl Outbox {
    /// Adds an effect.
    pub fn push(&mut self, effect: Effect) {
        self.effects.push(effect);
    }

    /// Takes the effects out in order.
    pub fn drain(&mut self) -> std::vec::Drain<'_, Effect> {
        self.effects.drain(..)
    }
}
