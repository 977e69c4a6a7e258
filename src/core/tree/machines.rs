//! The machines of a tree that lives: each with its parent, while it is there.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Effect, Input, Node, Outbox, Root, Settings, below_root, build};
use ambidex_model::{MissionSpec, NodeId, Time};

/// The machines of a tree by node.
#[derive(Debug)]
pub struct Machines {
    by_node: BTreeMap<NodeId, (NodeId, Node)>,
}

impl FromIterator<(NodeId, NodeId, Node)> for Machines {
    fn from_iter<T: IntoIterator<Item = (NodeId, NodeId, Node)>>(nodes: T) -> Self {
        Self { by_node: nodes.into_iter().map(|(id, parent, node)| (id, (parent, node))).collect() }
    }
}

impl Machines {
    /// Those of a mission.
    pub fn new(mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        let topology = &mission.tree.topology;
        let nodes = std::iter::zip(topology.nodes(), build(mission, settings));
        Self { by_node: nodes.map(|(id, node)| (id, (topology.parent(id), node))).collect() }
    }

    /// The machine of root.
    pub fn root(&self) -> &Root {
        match &self.by_node[&NodeId(0)].1 {
            Node::Root(root) => root,
            Node::Composite(_) | Node::Leaf(_) => unreachable!("node 0 is root"),
        }
    }

    pub(super) fn root_mut(&mut self) -> &mut Root {
        match self.by_node.get_mut(&NodeId(0)) {
            Some((_, Node::Root(root))) => root,
            Some((_, Node::Composite(_) | Node::Leaf(_))) | None => unreachable!("node 0 is root"),
        }
    }

    /// The parent of a node.
    pub fn parent(&self, node: NodeId) -> NodeId {
        self.by_node[&node].0
    }

    /// Gives a node what reaches it. What comes of it for the tree is done before it is told.
    ///
    /// # Panics
    /// When the node is not there: a defect of whoever carries the messages.
    pub fn handle(&mut self, now: Time, to: NodeId, input: Input, out: &mut Outbox) {
        self.by_node.get_mut(&to).expect("messages go to who is there").1.handle(now, input, out);
    }

    /// Nodes come and go, as an effect of root has it; what that is not comes back.
    pub fn change(&mut self, effect: Effect) -> Option<Effect> {
        match effect {
            Effect::Spawn { nodes, mission, settings, .. } => {
                let machine = |(id, parent)| (id, (parent, below_root(id, &mission, &settings)));
                self.by_node.extend(nodes.into_iter().map(machine));
                None
            }
            Effect::Retire { nodes, .. } => {
                nodes.iter().for_each(|node| drop(self.by_node.remove(node)));
                None
            }
            effect => Some(effect),
        }
    }

    /// All of them with their parents, in the order of ids.
    pub fn into_nodes(self) -> impl Iterator<Item = (NodeId, NodeId, Node)> {
        self.by_node.into_iter().map(|(id, (parent, node))| (id, parent, node))
    }
}
