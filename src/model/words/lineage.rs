//! The line of inheritance: whose leases a node may use as its own.

use serde::{Deserialize, Serialize};

use super::{NodeId, Topology};

/// A run of nodes in preorder, `from` included, `to` not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct NodeRange {
    /// The first node.
    pub from: NodeId,
    /// The first node behind it.
    pub to: NodeId,
}

impl NodeRange {
    /// Whether `node` lies in the run.
    pub fn contains(&self, node: NodeId) -> bool {
        (self.from..self.to).contains(&node)
    }

    /// The nodes of the run that a tree of so many has: a run read from a file can be of any length.
    pub fn nodes(&self, of: usize) -> impl Iterator<Item = NodeId> + Clone + use<> {
        let end = self.to.index().min(of);
        (self.from.index().min(end)..end).map(NodeId::from)
    }
}

/// The line of a node: itself, its ancestors, and what was skipped to reach it.
#[derive(Debug, Clone, Copy)]
pub struct Lineage<'a> {
    /// The shape of the tree.
    pub topology: &'a Topology,
    /// Where the line ends; it begins at root.
    pub node: NodeId,
    /// Children skipped tentatively on the way down; leases held in them count as inherited.
    pub skips: &'a [NodeRange],
}

impl Lineage<'_> {
    /// Whether a lease of `holder` is the node's own or inherited.
    pub fn contains(&self, holder: NodeId) -> bool {
        self.topology.is_within(self.node, holder) || self.skips.iter().any(|skip| skip.contains(holder))
    }
}
