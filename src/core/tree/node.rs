//! One kind of machine for every node.

use std::sync::Arc;

use super::composite::Composite;
use super::effect::{Effect, Input, Outbox};
use super::leaf::Leaf;
use super::ordering::Ordering;
use super::{Release, Root, Settings, Up};
use ambidex_model::state::Saved;
use ambidex_model::{MissionSpec, NodeId, Time, Told};

/// The machine of one node.
#[derive(Debug)]
pub enum Node {
    /// Node 0.
    Root(Box<Root>),
    /// AND, OR, THEN.
    Composite(Box<Composite>),
    /// A behavior at the bottom.
    Leaf(Box<Leaf>),
}

impl Node {
    /// Whether this is root and [`Input::Turn`] is due.
    pub fn wants_turn(&self) -> bool {
        match self {
            Self::Root(root) => root.wants_turn(),
            Self::Composite(_) | Self::Leaf(_) => false,
        }
    }

    /// If this is root, when it has to be told [`Told::Woke`].
    pub fn deadline(&self) -> Option<Time> {
        match self {
            Self::Root(root) => root.deadline(),
            Self::Composite(_) | Self::Leaf(_) => None,
        }
    }

    /// If this is root, all that the run is; none at moments at which that cannot be said.
    pub fn save(&self) -> Option<Saved> {
        match self {
            Self::Root(root) => root.save(),
            Self::Composite(_) | Self::Leaf(_) => None,
        }
    }

    /// Whether this is root, and messages between nodes are told.
    pub fn has_messages(&self) -> bool {
        match self {
            Self::Root(root) => root.has_messages(),
            Self::Composite(_) | Self::Leaf(_) => false,
        }
    }

    /// Takes an input at a moment of robot time and says what is to be done.
    ///
    /// # Panics
    /// On an input that this kind of node never gets: a defect of whoever carries the messages.
    pub fn handle(&mut self, now: Time, input: Input, out: &mut Outbox) {
        match (self, input) {
            (Self::Root(root), Input::Up(Up::Answer { from, answer, news, .. })) => {
                root.on_answer(now, from, &answer, news, out);
            }
            (Self::Root(root), Input::Up(Up::Release(release))) => {
                let Release { leaf, outcome, .. } = *release;
                root.on_told(now, Told::Ended { leaf, outcome }, out);
            }
            (Self::Root(root), Input::Told(told)) => root.on_told(now, *told, out),
            (Self::Root(root), Input::Observed(change)) => root.on_observation(change),
            (Self::Root(root), Input::Turn) => root.turn(now, out),
            (Self::Composite(node), Input::Down(down)) => node.on_down(down, out),
            (Self::Composite(node), Input::Up(Up::Answer { from, answer, news, .. })) => {
                node.on_answer(from, answer, news, out);
            }
            (Self::Composite(_), Input::Up(up @ Up::Release(_))) => out.push(Effect::Up(up)),
            (Self::Leaf(leaf), Input::Down(down)) => leaf.on_down(down, out),
            (Self::Leaf(leaf), Input::Ended(outcome)) => leaf.on_end(*outcome, out),
            (node, input) => panic!("{node:?} cannot take {input:?}"),
        }
    }
}

/// The machines of a mission, by node.
pub fn build(mission: &Arc<MissionSpec>, settings: &Settings) -> Vec<Node> {
    let tree = &mission.tree;
    let nodes = tree.topology.nodes().map(|id| match id.0 {
        0 => Node::Root(Box::new(Root::new(mission, settings))),
        _ => below_root(id, mission, settings),
    });
    nodes.collect()
}

/// The machine of a node that is not root.
pub fn below_root(id: NodeId, mission: &MissionSpec, settings: &Settings) -> Node {
    match Ordering::of(&mission.tree.nodes[id.index()]) {
        Some(ordering) => Node::Composite(Box::new(Composite::new(id, ordering, mission, settings))),
        None => Node::Leaf(Box::new(Leaf::new(id))),
    }
}
