//! What a behavior's siblings in its THEN are: the `move` before it, and what the later ones claim.

use std::collections::BTreeMap;

use super::{Draft, DraftKind};
use crate::kinds::Stop;
use ambidex_model::{NodeId, Topology, TypeId};

/// Where the nearest earlier `move` of each node's THEN goes; a node below an AND or OR has that of the node above it.
pub(super) fn moves_before(drafts: &[Draft], topology: &Topology) -> Vec<Option<Stop>> {
    let mut befores = vec![None; drafts.len()];
    for (index, draft) in drafts.iter().enumerate() {
        let is_then = matches!(draft.kind, Some(DraftKind::Then));
        let mut before = befores[index];
        for child in topology.children(NodeId::from(index)) {
            befores[child.index()] = before;
            if let Some(DraftKind::Behavior(call)) = &drafts[body(drafts, child.index())].kind
                && is_then
            {
                before = call.stop.or(before);
            }
        }
    }
    befores
}

/// A node without its cleanup.
fn body(drafts: &[Draft], mut index: usize) -> usize {
    while let Some(DraftKind::Cleanup) = drafts[index].kind
        && index + 1 < drafts.len()
    {
        index += 1;
    }
    index
}

/// What later siblings of each node in its THEN claim, by type.
pub(super) struct Afters {
    claimed: BTreeMap<TypeId, Vec<bool>>,
}

impl Afters {
    /// Of every node and type, a pass from the last node to the first for each.
    pub(super) fn of(drafts: &[Draft], topology: &Topology, types: impl IntoIterator<Item = TypeId>) -> Self {
        let claimed = types.into_iter().map(|ty| (ty, claimed_after(ty, drafts, topology)));
        Self { claimed: claimed.collect() }
    }

    /// Whether a node behind this one in its THEN claims the type.
    pub(super) fn claims(&self, node: usize, ty: TypeId) -> bool {
        self.claimed.get(&ty).is_some_and(|after| after[node])
    }
}

fn claimed_after(ty: TypeId, drafts: &[Draft], topology: &Topology) -> Vec<bool> {
    let (mut within, mut after) = (vec![false; drafts.len()], vec![false; drafts.len()]);
    for index in (0..drafts.len()).rev() {
        if let Some(DraftKind::Behavior(call)) = &drafts[index].kind {
            within[index] = call.types.contains(&ty);
        }
        let is_then = matches!(drafts[index].kind, Some(DraftKind::Then));
        let children: Vec<_> = topology.children(NodeId::from(index)).collect();
        let has_cleanup = matches!(drafts[index].kind, Some(DraftKind::Cleanup));
        let counted = if has_cleanup { 1 } else { children.len() };
        for child in children.into_iter().take(counted).rev().map(NodeId::index) {
            after[child] = is_then && within[index];
            within[index] |= within[child];
        }
    }
    after
}
