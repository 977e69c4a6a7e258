//! The tree by node: children, depth, and what is written in each node.

use std::collections::HashMap;

use ambidex_model::{EntryKind, Header, NodeId};
use ambidex_record::History;

use crate::svg::fit::{self, TEXT};

/// Widest text of a node; longer names are cut and shown in full where a pointer rests.
const MAX_TEXT: f64 = 170.0;
/// Text from the sides of its node.
const PAD: f64 = 4.0;

/// The part of a tree that is drawn.
#[derive(Debug)]
pub(super) struct Tree<'a> {
    header: &'a Header,
    /// The nodes of the header, by their places in what is drawn, of which all else speaks.
    ids: Vec<NodeId>,
    children: Vec<Vec<NodeId>>,
    depths: Vec<usize>,
    /// Whether nodes have a sign besides their text.
    pub(super) has_marks: bool,
}

/// What is written in a node, and how wide that is with free space at the sides.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Label {
    pub(super) lines: Vec<String>,
    pub(super) width: f64,
}

impl<'a> Tree<'a> {
    /// The first `limit` nodes in preorder, which are a tree again.
    pub(super) fn new(header: &'a Header, history: Option<&History>, limit: usize) -> Self {
        let mut ids = in_order(header, history);
        ids.truncate(limit);
        let (count, parents) = (ids.len(), places_of_parents(header, &ids));
        let mut children = vec![Vec::new(); count];
        let mut depths = vec![0; count];
        for node in 1..count {
            let parent = parents[node].index();
            // The header is read from a file: a parent that does not come before its child has none.
            if parent < node {
                children[parent].push(NodeId::from(node));
                depths[node] = depths[parent] + 1;
            }
        }
        Self { header, ids, children, depths, has_marks: history.is_some() }
    }

    pub(super) fn len(&self) -> usize {
        self.children.len()
    }

    pub(super) fn is_cut(&self) -> bool {
        self.len() < self.header.nodes.count()
    }

    /// The node of the header at a place.
    pub(super) fn id(&self, node: NodeId) -> NodeId {
        self.ids[node.index()]
    }

    /// Every node that is drawn, in preorder.
    pub(super) fn nodes(&self) -> impl DoubleEndedIterator<Item = NodeId> + use<> {
        (0..self.len()).map(NodeId::from)
    }

    pub(super) fn children(&self, node: NodeId) -> &[NodeId] {
        &self.children[node.index()]
    }

    pub(super) fn depth(&self, node: NodeId) -> usize {
        self.depths[node.index()]
    }

    pub(super) fn is_leaf(&self, node: NodeId) -> bool {
        self.kind(node).is_behavior()
    }

    pub(super) fn is_then(&self, node: NodeId) -> bool {
        *self.kind(node) == EntryKind::Then
    }

    fn kind(&self, node: NodeId) -> &EntryKind {
        &self.header.nodes[self.id(node).index()].kind
    }

    /// The text of a node in one line, or in two.
    pub(super) fn label(&self, node: NodeId, in_two_lines: bool) -> Label {
        let (kind, name) = (self.kind(node).word(), self.header.names.node(self.id(node)));
        let is_told = name.starts_with(kind);
        let lines = match (self.is_leaf(node), is_told) {
            (true, true) => split(name, in_two_lines),
            (true, false) => split(&format!("{name} ({kind})"), in_two_lines),
            (false, true) => vec![kind.to_uppercase()],
            (false, false) => vec![kind.to_uppercase(), name.to_owned()],
        };
        let lines: Vec<String> = lines.iter().map(|line| fit::clip(line, TEXT, MAX_TEXT)).collect();
        // Kinds are written larger and bold.
        let factor = |index: usize| if index == 0 && !self.is_leaf(node) { 1.2 } else { 1.0 };
        let widths = lines.iter().enumerate().map(|(index, line)| fit::width(line, TEXT) * factor(index));
        let width = widths.fold(0.0, f64::max) + 2.0 * PAD;
        Label { width: width.max(24.0), lines }
    }
}

/// Every node in tree order.
pub(super) fn in_order(header: &Header, history: Option<&History>) -> Vec<NodeId> {
    let of_header = || header.nodes.entries().map(|(node, _)| NodeId::from(node)).collect();
    history.map_or_else(of_header, |history| {
        history.nodes().filter(|node| header.nodes.get(node.index()).is_some()).collect()
    })
}

/// Of each of some nodes the place of its parent among them; its own where that is none of them.
pub(super) fn places_of_parents(header: &Header, nodes: &[NodeId]) -> Vec<NodeId> {
    let places: HashMap<NodeId, usize> = nodes.iter().enumerate().map(|(place, node)| (*node, place)).collect();
    let place = |(own, node): (usize, &NodeId)| places.get(&header.nodes[node.index()].parent).copied().unwrap_or(own);
    nodes.iter().enumerate().map(|node| NodeId::from(place(node))).collect()
}

fn split(text: &str, in_two_lines: bool) -> Vec<String> {
    if in_two_lines { fit::two_lines(text, TEXT) } else { vec![text.to_owned()] }
}
