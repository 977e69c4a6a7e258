//! Which way an OR went, and what that leaves over: leaves that are skipped, that are not needed, that were not asked.

use ambidex_model::{Grant, NodeId, NodeRange, Reason};

use super::states::{Kind, LeafStates};

impl LeafStates {
    /// The leaves that a grant skips and that were not done before.
    pub(super) fn skipped_by(&self, grant: &Grant) -> Vec<NodeId> {
        let is_met = |leaf: NodeId| grant.met.contains(&leaf);
        let is_open = |leaf: NodeId| self.leaf(leaf).is_some_and(|leaf| leaf.state().is_open());
        let skipped = |skip: &NodeRange| {
            let is_wanted = |leaf: &NodeId| is_open(*leaf) && self.is_on_the_way(*leaf, skip.from, &is_met);
            let nodes = skip.nodes(self.nodes.len()).filter(|node| self.topology.has(*node));
            nodes.filter(is_wanted).collect::<Vec<_>>()
        };
        grant.request.skips.iter().flat_map(skipped).collect()
    }

    /// Leaves whose goal is met though they were not needed: done in the end, unless an OR above went another way.
    pub(super) fn met(&self) -> Vec<NodeId> {
        let is_met = |leaf: NodeId| self.leaf(leaf).is_some_and(|leaf| leaf.reason == Some(Reason::Satisfied));
        let leaves = self.topology.nodes().filter(|leaf| is_met(*leaf));
        let is_open = |leaf: &NodeId| self.leaves[leaf.index()].state().is_open();
        leaves.filter(is_open).filter(|leaf| self.is_on_the_way(*leaf, NodeId(0), &is_met)).collect()
    }

    /// Why a leaf was never asked: what stands before it in a THEN, or the way that an OR went instead.
    pub(super) fn not_asked(&self, leaf: NodeId) -> Option<Reason> {
        self.path(leaf).find_map(|node| {
            let parent = self.topology.parent(node);
            let mut siblings = self.topology.children(parent).filter(|sibling| *sibling != node);
            match self.nodes[parent.index()].kind {
                Kind::All { is_ordered: true } => {
                    let before = siblings.take_while(|sibling| self.topology.is_before(*sibling, node));
                    before.into_iter().find(|before| !self.is_done(*before)).map(|after| Reason::NotItsTurn { after })
                }
                Kind::Or => {
                    siblings.find(|sibling| self.has_begun(*sibling)).map(|chosen| Reason::Alternative { chosen })
                }
                Kind::Body => siblings.find(|body| *body < node).map(|after| Reason::NotItsTurn { after }),
                Kind::All { is_ordered: false } | Kind::Tasks | Kind::Leaf => None,
            }
        })
    }

    /// The child by which an OR above a node is done, where the node lies below another one.
    pub(super) fn instead_of(&self, node: NodeId) -> Option<NodeId> {
        self.path(node).filter(|node| node.0 > 0).find_map(|node| {
            let or = self.topology.parent(node);
            let is_left = self.nodes[or.index()].kind == Kind::Or && self.is_done(or) && !self.is_done(node);
            is_left.then(|| self.topology.children(or).find(|child| self.is_done(*child))).flatten()
        })
    }

    /// The topmost ways that ORs did not need, each with the child that did it.
    pub(super) fn ways_left(&self) -> Vec<(NodeId, NodeId)> {
        let nodes = self.topology.nodes().filter(|node| node.0 > 0);
        let is_top = |node: &NodeId| self.instead_of(self.topology.parent(*node)).is_none();
        let left = nodes.filter(|node| !self.nodes[node.index()].is_failed && is_top(node));
        left.filter_map(|node| Some((node, self.instead_of(node)?))).collect()
    }

    /// Whether every OR between a leaf and the node `from` went the leaf's way.
    fn is_on_the_way(&self, leaf: NodeId, from: NodeId, is_met: &impl Fn(NodeId) -> bool) -> bool {
        let above = self.path(leaf).filter(|node| node.0 > 0).map(|node| (node, self.topology.parent(node)));
        let mut ways = above.take_while(|(_, parent)| *parent >= from);
        ways.all(|(node, parent)| self.nodes[parent.index()].kind != Kind::Or || self.way(parent, is_met) == Some(node))
    }

    /// The child by which an OR is done: the one that did it, else the first whose goal is met.
    fn way(&self, or: NodeId, is_met: &impl Fn(NodeId) -> bool) -> Option<NodeId> {
        let open = || self.topology.children(or).filter(|child| !self.nodes[child.index()].is_failed);
        let done = open().find(|child| self.is_done(*child));
        done.or_else(|| open().find(|child| self.is_met(*child, is_met))).or_else(|| open().next())
    }

    fn is_met(&self, node: NodeId, is_leaf_met: &impl Fn(NodeId) -> bool) -> bool {
        let mut children = self.topology.children(node);
        self.is_done(node)
            || match self.nodes[node.index()].kind {
                Kind::Leaf => is_leaf_met(node),
                Kind::Or => children.any(|child| self.is_met(child, is_leaf_met)),
                Kind::Body => children.next().is_some_and(|child| self.is_met(child, is_leaf_met)),
                Kind::All { .. } | Kind::Tasks => children.all(|child| self.is_met(child, is_leaf_met)),
            }
    }

    fn has_begun(&self, node: NodeId) -> bool {
        let node = self.nodes[node.index()];
        node.has_run || node.counts.done > 0
    }
}
