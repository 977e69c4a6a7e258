//! Why each behavior does not run, as far as the records tell.

use std::collections::BTreeSet;

use ambidex_model::{EntryKind, Header, NodeId, Reason, Tally};

use super::LeafState;
use super::course::Course;

/// The last reason of every leaf that is not done and does not run, in tree order.
///
/// A leaf that was never asked is said to come after the sibling that stands before it, or to be passed over for the
/// other child of an OR; none where neither is so.
pub fn last_reasons(tally: &Tally) -> Vec<(NodeId, Option<Reason>)> {
    let course = Course::new(tally);
    let not_asked = tally.header.as_deref().map(|header| NotAsked::new(header, |leaf| course.standing(leaf)));
    let open = course.leaves().into_iter().filter(|&leaf| match course.state(leaf) {
        LeafState::Waiting | LeafState::Failed | LeafState::Canceled => true,
        LeafState::Active | LeafState::Done | LeafState::Skipped => false,
    });
    open.map(|leaf| {
        let told = tally.reasons.get(&leaf).cloned();
        let reason = told.or_else(|| not_asked.as_ref().and_then(|tree| tree.reason(leaf)));
        (leaf, reason)
    })
    .collect()
}

/// The tree as far as it says why a leaf was not asked.
pub(super) struct NotAsked<'a> {
    header: &'a Header,
    children: Vec<Vec<NodeId>>,
    done: BTreeSet<NodeId>,
    begun: BTreeSet<NodeId>,
}

impl<'a> NotAsked<'a> {
    /// `standing` says of a leaf whether it is done, and whether it has begun.
    pub(super) fn new(header: &'a Header, standing: impl Fn(NodeId) -> (bool, bool)) -> Self {
        let mut children = vec![Vec::new(); header.nodes.len()];
        for (node, entry) in header.nodes.iter().enumerate().skip(1) {
            if let Some(siblings) = children.get_mut(entry.parent.index()) {
                siblings.push(NodeId::from(node));
            }
        }
        let mut tree = Self { header, children, done: BTreeSet::new(), begun: BTreeSet::new() };
        for node in (0..header.nodes.len()).rev().map(NodeId::from) {
            let (done, begun) = match tree.kind(node).is_behavior() {
                true => standing(node),
                false => tree.standing(node),
            };
            tree.done.extend(done.then_some(node));
            tree.begun.extend(begun.then_some(node));
        }
        tree
    }

    /// Whether a node is done.
    pub(super) fn is_done(&self, node: NodeId) -> bool {
        self.done.contains(&node)
    }

    /// Whether a node with children is done, and whether anything below it has begun; its children are known.
    fn standing(&self, node: NodeId) -> (bool, bool) {
        let children = &self.children[node.index()];
        let is_done = |child: &NodeId| self.done.contains(child);
        let done = match self.kind(node) {
            EntryKind::Or => children.iter().any(is_done),
            EntryKind::Root | EntryKind::And | EntryKind::Then | EntryKind::Behavior(_) => children.iter().all(is_done),
        };
        (done, children.iter().any(|child| self.begun.contains(child)))
    }

    fn kind(&self, node: NodeId) -> &EntryKind {
        &self.header.nodes[node.index()].kind
    }

    /// What stands before the node, looked for upwards.
    pub(super) fn reason(&self, leaf: NodeId) -> Option<Reason> {
        let mut node = leaf;
        while node.0 > 0 {
            let parent = self.header.nodes[node.index()].parent;
            if parent >= node {
                return None;
            }
            let siblings = self.children[parent.index()].iter().copied();
            let mut siblings = siblings.filter(|&sibling| sibling != node);
            match self.kind(parent) {
                EntryKind::Then => {
                    let before = siblings.find(|&before| before < node && !self.done.contains(&before));
                    if let Some(after) = before {
                        return Some(Reason::NotItsTurn { after });
                    }
                }
                EntryKind::Or => {
                    if let Some(chosen) = siblings.find(|sibling| self.begun.contains(sibling)) {
                        return Some(Reason::Alternative { chosen });
                    }
                }
                EntryKind::Root | EntryKind::And | EntryKind::Behavior(_) => {}
            }
            node = parent;
        }
        None
    }
}
