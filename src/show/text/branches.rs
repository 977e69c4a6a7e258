//! The lines that lead from node to node where a tree is indented text.

use ambidex_model::NodeId;

use super::layout::{clip, columns};

/// The last child of each node among those that are shown; the root is its own parent.
pub(crate) fn last_children(parents: &[NodeId], is_shown: impl Fn(NodeId) -> bool) -> Vec<Option<NodeId>> {
    let mut last = vec![None; parents.len()];
    for (node, parent) in parents.iter().enumerate().filter(|(node, _)| is_shown(NodeId::from(*node))) {
        last[parent.index()] = Some(NodeId::from(node));
    }
    last
}

/// The lines that lead from the ancestors to each node, cut to a width.
pub(crate) fn branches(parents: &[NodeId], last: &[Option<NodeId>], width: usize) -> Vec<String> {
    // What stands before the children of each node: a chain of any length costs no more than its cut.
    let mut rails: Vec<String> = Vec::with_capacity(parents.len());
    let mut branches = Vec::with_capacity(parents.len());
    for (node, parent) in parents.iter().enumerate() {
        let is_last = last[parent.index()] == Some(NodeId::from(node));
        let (branch, rail) = if is_last { ("└─ ", "   ") } else { ("├─ ", "│  ") };
        let before = rails.get(parent.index()).map(String::as_str);
        let [branch, rail] = [branch, rail].map(|own| match before {
            Some(before) if columns(before) > width => before.to_owned(),
            Some(before) => format!("{before}{own}"),
            None => String::new(),
        });
        branches.push(clip(&branch, width));
        rails.push(rail);
    }
    branches
}
