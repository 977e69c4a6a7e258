//! What a behavior's siblings in its THEN are: the `move` before it, and what the later ones claim.

use super::kinds::{Kind, Stop, Types};
use super::task::{Draft, DraftKind};
use crate::model::{NodeId, Topology, TypeId};

/// Where the nearest earlier `move` of each node's THEN goes; a node below an AND or OR has that of the node above it.
pub(super) fn moves_before(drafts: &[Draft], topology: &Topology) -> Vec<Option<Stop>> {
    let mut befores = vec![None; drafts.len()];
    for (index, draft) in drafts.iter().enumerate() {
        let is_then = matches!(draft.kind, Some(DraftKind::Then));
        let mut before = befores[index];
        for child in topology.children(NodeId::from(index)) {
            befores[child.index()] = before;
            match drafts[child.index()].kind {
                Some(DraftKind::Behavior(Kind::Move { to, .. })) if is_then => before = Some(to),
                Some(_) | None => {}
            }
        }
    }
    befores
}

/// What later siblings of each node in its THEN claim: any behavior the base, some the head and a gripper too.
pub(super) struct Afters {
    any: Vec<bool>,
    handling: Vec<bool>,
}

impl Afters {
    /// Of every node, in one pass from the last to the first.
    pub(super) fn of(drafts: &[Draft], topology: &Topology) -> Self {
        let count = drafts.len();
        let (mut within, mut within_handling) = (vec![false; count], vec![false; count]);
        let (mut any, mut handling) = (vec![false; count], vec![false; count]);
        for index in (0..count).rev() {
            if let Some(DraftKind::Behavior(kind)) = &drafts[index].kind {
                within[index] = true;
                within_handling[index] = kind.is_handling();
            }
            let is_then = matches!(drafts[index].kind, Some(DraftKind::Then));
            let children: Vec<_> = topology.children(NodeId::from(index)).collect();
            for child in children.into_iter().rev().map(NodeId::index) {
                any[child] = is_then && within[index];
                handling[child] = is_then && within_handling[index];
                within[index] |= within[child];
                within_handling[index] |= within_handling[child];
            }
        }
        Self { any, handling }
    }

    /// A `move` is scaled only by a type that something after it claims.
    pub(super) fn scaled(&self, kind: Kind, index: usize, types: &Types) -> Kind {
        let Kind::Move { to, scale_by } = kind else {
            return kind;
        };
        let is_claimed = |ty: &TypeId| {
            let ty = Some(*ty);
            let by_handling = ty == types.gripper || ty == types.head;
            (by_handling && self.handling[index]) || (ty == types.base && self.any[index])
        };
        Kind::Move { to, scale_by: scale_by.filter(is_claimed) }
    }
}
