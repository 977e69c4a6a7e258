//! One kind of machine for every node, what goes in and what comes out.

use std::sync::Arc;

use super::composite::Composite;
use super::leaf::Leaf;
use super::ordering::Ordering;
use super::{Begin, Down, Root, Settings, Up};
use ambidex_model::{
    Change, Goal, MissionEnd, MissionSpec, NodeId, NodeKind, NodeRange, Outcome, Record, Time, Topology,
};

/// What reaches a node. What is rare and large lies behind a pointer: every inbox has room for 32 of these.
#[derive(Debug, Clone)]
pub enum Input {
    /// From its parent.
    Down(Down),
    /// From a child.
    Up(NodeId, Up),
    /// To a leaf, from its controllers: the goal ended.
    Ended(Box<Outcome>),
    /// To root: begin the mission.
    Begin(Box<Begin>),
    /// To root: the world is different, and nobody in the tree did it.
    World(Change),
    /// To root: the base is here while a goal runs; no round comes of it.
    Observed(Change),
    /// To root: end the mission in order, for this cause: no new round, what runs is canceled first.
    End(MissionEnd),
}

/// What a node wants done.
#[derive(Debug, Clone)]
pub enum Effect {
    /// Tell a child.
    Down(NodeId, Down),
    /// Tell the parent.
    Up(Up),
    /// Give the goal to its controllers.
    Start(Goal),
    /// Cancel the goal of this leaf.
    Stop(NodeId),
    /// Write it down.
    Record(Box<Record>),
    /// The mission is over.
    Finished(MissionEnd),
}

impl Effect {
    /// The record of a message that `from` sends with this effect; none for what is no message.
    pub fn message(&self, at: Time, from: NodeId, topology: &Topology) -> Option<Record> {
        let (to, round, message) = match self {
            Self::Down(to, down) => {
                let below = NodeRange { from: *to, to: topology.end(*to) };
                (*to, down.round(), down.record(below))
            }
            Self::Up(up) => (topology.parent(from), up.round(), up.record(from)),
            Self::Start(_) | Self::Stop(_) | Self::Record(_) | Self::Finished(_) => return None,
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

/// The machine of one node.
#[derive(Debug)]
pub enum Node {
    /// Node 0.
    Root(Box<Root>),
    /// AND, OR, THEN.
    Composite(Box<Composite>),
    /// A behavior.
    Leaf(Box<Leaf>),
}

impl Node {
    /// Takes an input at a moment of robot time and says what is to be done.
    ///
    /// # Panics
    /// On an input that this kind of node never gets: a defect of whoever carries the messages.
    pub fn handle(&mut self, now: Time, input: Input, out: &mut Outbox) {
        match (self, input) {
            (Self::Root(root), Input::Up(_, Up::Answer(answer))) => root.on_answer(now, *answer, out),
            (Self::Root(root), Input::Up(_, Up::Release(release))) => root.on_release(now, *release, out),
            (Self::Root(root), Input::Begin(begin)) => root.begin(now, *begin, out),
            (Self::Root(root), Input::World(change)) => root.on_world_change(now, change, out),
            (Self::Root(root), Input::Observed(change)) => root.on_observation(change),
            (Self::Root(root), Input::End(end)) => root.end(now, end, out),
            (Self::Composite(node), Input::Down(down)) => node.on_down(down, out),
            (Self::Composite(node), Input::Up(child, Up::Answer(answer))) => node.on_answer(child, *answer, out),
            (Self::Composite(node), Input::Up(child, Up::Release(release))) => {
                node.on_release(child, *release, out);
            }
            (Self::Leaf(leaf), Input::Down(down)) => leaf.on_down(down, out),
            (Self::Leaf(leaf), Input::Ended(outcome)) => leaf.on_end(*outcome, out),
            (node, input) => panic!("{node:?} cannot take {input:?}"),
        }
    }
}

/// The machines of a mission, by node.
pub fn build(mission: &Arc<MissionSpec>, settings: &Settings) -> Vec<Node> {
    let tree = &mission.tree;
    let composite = |id, ordering| {
        let children = tree.topology.children(id).collect();
        Node::Composite(Box::new(Composite::new(id, ordering, children, mission, settings)))
    };
    let nodes = tree.nodes.iter().enumerate().map(|(index, kind)| {
        let id = NodeId::from(index);
        match kind {
            NodeKind::Root => Node::Root(Box::new(Root::new(mission, settings))),
            NodeKind::And => composite(id, Ordering::And),
            NodeKind::Or => composite(id, Ordering::Or),
            NodeKind::Then => composite(id, Ordering::Then),
            NodeKind::Behavior(_) => Node::Leaf(Box::new(Leaf::new(id, mission))),
        }
    });
    nodes.collect()
}
