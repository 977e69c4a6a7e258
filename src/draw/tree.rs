//! The task tree as indented text.

use std::fmt::Write;

use crate::model::{Header, NodeId, Tally};

use super::Palette;
use super::course::Course;
use super::text::{MIN_WIDTH, clip, columns};

/// The tree with the kind of each node and, where a tally is given, the state of each leaf.
pub fn tree(header: &Header, tally: Option<&Tally>, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let course = tally.map(Course::new);
    let last = last_children(header);
    let mut text = String::new();
    for node in (0..header.nodes.len()).map(NodeId::from) {
        let branches = clip(&branches(header, &last, node), width / 2);
        let kind = header.nodes[node.index()].kind.word();
        let name = header.names.node(node);
        let state = course.as_ref().filter(|_| header.nodes[node.index()].kind.is_behavior());
        let state = state.map(|course| course.state(node));
        let mark = state.map_or(String::new(), |state| Palette::paint(palette.of(state), state.mark()) + " ");
        let room = width - columns(&branches) - if state.is_some() { 2 } else { 0 };
        let kind = if name.starts_with(kind) { "" } else { kind };
        let name = clip(name, room);
        let kind = clip(kind, room.saturating_sub(columns(&name) + 2));
        let line = format!(
            "{}{mark}{name}{}",
            Palette::paint(palette.faint, branches),
            match kind.len() {
                0 => String::new(),
                _ => format!("  {}", Palette::paint(palette.faint, kind)),
            }
        );
        let _ = writeln!(text, "{line}");
    }
    text
}

/// The last child of each node.
fn last_children(header: &Header) -> Vec<Option<NodeId>> {
    let mut last = vec![None; header.nodes.len()];
    for (node, entry) in header.nodes.iter().enumerate() {
        if let Some(child) = last.get_mut(entry.parent.index()) {
            *child = Some(NodeId::from(node));
        }
    }
    last
}

/// The lines that lead from the ancestors to a node.
fn branches(header: &Header, last: &[Option<NodeId>], node: NodeId) -> String {
    let mut pieces = Vec::new();
    let mut below = node;
    while below.0 > 0 {
        let parent = header.nodes[below.index()].parent;
        if parent >= below {
            break;
        }
        let is_last = last[parent.index()] == Some(below);
        pieces.push(match (below == node, is_last) {
            (true, true) => "└─ ",
            (true, false) => "├─ ",
            (false, true) => "   ",
            (false, false) => "│  ",
        });
        below = parent;
    }
    pieces.into_iter().rev().collect()
}
