//! Who keeps something for what comes next is in front of something that comes next.

use super::Seen;
use crate::fault::Faults;
use ambidex_model::{Claim, NodeId, NodeKind, Retention};

pub(super) fn check(seen: &Seen<'_>, faults: &mut Faults) {
    for leaf in seen.mission.tree.leaves() {
        check_leaf(seen, leaf, faults);
    }
}

/// An intention lives only while a THEN that is not complete holds it.
fn check_leaf(seen: &Seen<'_>, leaf: NodeId, faults: &mut Faults) {
    let tree = &seen.mission.tree;
    let keeps = |claim: &Claim| matches!(claim.keep, Retention::Intention(_));
    let parent = tree.topology.parent(leaf);
    let is_loose = matches!(tree.nodes[parent.index()], NodeKind::And | NodeKind::Or);
    if !is_loose || !seen.behavior(leaf).claims.iter().any(keeps) {
        return;
    }
    let mut node = leaf;
    while node.0 > 0 {
        let parent = tree.topology.parent(node);
        let has_heirs = tree.topology.children(parent).last() != Some(node);
        if matches!(tree.nodes[parent.index()], NodeKind::Then) && has_heirs {
            return;
        }
        node = parent;
    }
    let message = "nobody inherits what it keeps: other behaviors may undo it at once".to_owned();
    seen.warn(leaf, message, "put it in a `then`, before what it is done for", faults);
}
