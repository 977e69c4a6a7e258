//! Goals of task nodes, and what of them is to be reached anew (`semantics` 1 and 6).

use super::ordering::{Ordering, is_never};
use crate::behavior;
use crate::world::View;
use ambidex_model::{Lineage, NodeId, NodeKind, TreeSpec};

/// What begins anew below a node that is tried again: not the complete children of an AND, nor those of a THEN up to the
/// last one that was done and whose goal still holds; its last child does in any case. What can never run does not.
pub(super) fn begin_anew(view: &View, node: NodeId, reset: &mut Vec<NodeId>) {
    let (state, tree) = (&view.state, &view.mission.tree);
    let children: Vec<NodeId> = tree.topology.children(node).collect();
    let kept = match Ordering::of(&tree.nodes[node.index()]) {
        None => return,
        Some(Ordering::And) => children.len(),
        Some(Ordering::Or | Ordering::Cleanup) => 0,
        Some(Ordering::Then) => {
            let mut before_last = children[..children.len() - 1].iter();
            before_last.rposition(|child| state.is_done(*child) && holds(view, *child)).map_or(0, |last| last + 1)
        }
    };
    for (index, &child) in children.iter().enumerate() {
        match state.is_done(child) {
            true if index < kept => {}
            true => reset.extend(tree.topology.nodes_below(child)),
            false if is_never(tree, state, child) || tree.topology.is_cleanup(child) => {}
            false => {
                reset.push(child);
                begin_anew(view, child, reset);
            }
        }
    }
}

/// Whether the goal of a node holds: all of an AND's, any of an OR's, the last of a THEN's. A drive is none in itself.
pub(super) fn holds(view: &View, node: NodeId) -> bool {
    let tree = &view.mission.tree;
    reaches(tree, node, &|leaf| is_met(view, leaf))
}

/// Whether the goal of a behavior holds as things are.
pub(super) fn is_met(view: &View, leaf: NodeId) -> bool {
    let line = Lineage { topology: &view.mission.tree.topology, node: leaf, skips: &[] };
    let spec = view.behavior(leaf);
    spec.is_some_and(|spec| behavior::is_satisfied(spec, view, &line))
}

/// The same for goals of behaviors that hold in some way.
pub(super) fn reaches(tree: &TreeSpec, node: NodeId, holds: &dyn Fn(NodeId) -> bool) -> bool {
    let mut children = tree.topology.children(node);
    match &tree.nodes[node.index()] {
        NodeKind::Behavior(spec) => !spec.is_drive() && holds(node),
        NodeKind::And | NodeKind::Tasks | NodeKind::Root => children.all(|child| reaches(tree, child, holds)),
        NodeKind::Or => children.any(|child| reaches(tree, child, holds)),
        NodeKind::Then => children.last().is_some_and(|child| reaches(tree, child, holds)),
        NodeKind::Cleanup => children.next().is_some_and(|child| reaches(tree, child, holds)),
    }
}
