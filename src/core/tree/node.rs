//! One kind of machine for every node.

use std::sync::Arc;

use super::composite::Composite;
use super::effect::{Input, Outbox};
use super::leaf::Leaf;
use super::ordering::Ordering;
use super::{Root, Settings, Up};
use ambidex_model::{MissionSpec, NodeId, NodeKind, Time};

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
    /// Takes an input at a moment of robot time and says what is to be done.
    ///
    /// # Panics
    /// On an input that this kind of node never gets: a defect of whoever carries the messages.
    pub fn handle(&mut self, now: Time, input: Input, out: &mut Outbox) {
        match (self, input) {
            (Self::Root(root), Input::Up(_, Up::Answer(answer))) => root.on_answer(now, *answer, out),
            (Self::Root(root), Input::Up(_, Up::Release(release))) => root.on_release(now, *release, out),
            (Self::Root(root), Input::Begin(world_state)) => root.begin(now, *world_state, out),
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
    let composite = |id, ordering| Node::Composite(Box::new(Composite::new(id, ordering, mission, settings)));
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
