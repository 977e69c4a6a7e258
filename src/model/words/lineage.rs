//! The line of inheritance: whose leases a node may use as its own.

use super::{NodeId, NodeRange, Topology};

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
