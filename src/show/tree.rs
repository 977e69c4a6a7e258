//! The task tree as indented text.

use std::fmt::Write;

use ambidex_model::{Header, NodeId, Tally};

use super::Palette;
use super::course::Course;
use super::text::{MIN_WIDTH, clip, columns};

/// The tree with the kind of each node and, where a tally is given, the state of each leaf.
pub fn tree(header: &Header, tally: Option<&Tally>, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let course = tally.map(Course::new);
    let parents: Vec<NodeId> = header.nodes.iter().map(|entry| entry.parent).collect();
    let branches = branches(&parents, &last_children(&parents, |_| true), width / 2);
    let mut text = String::new();
    for node in (0..header.nodes.len()).map(NodeId::from) {
        let branches = &branches[node.index()];
        let kind = header.nodes[node.index()].kind.word();
        let name = header.names.node(node);
        let state = course.as_ref().filter(|_| header.nodes[node.index()].kind.is_behavior());
        let state = state.map(|course| course.state(node));
        let mark = state.map_or(String::new(), |state| Palette::paint(palette.of(state), state.mark()) + " ");
        let room = width - columns(branches) - if state.is_some() { 2 } else { 0 };
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

/// The last child of each node among those that are shown; the root is its own parent.
pub(super) fn last_children(parents: &[NodeId], is_shown: impl Fn(NodeId) -> bool) -> Vec<Option<NodeId>> {
    let mut last = vec![None; parents.len()];
    for (node, parent) in parents.iter().enumerate() {
        let node = NodeId::from(node);
        if let Some(child) = last.get_mut(parent.index()).filter(|_| is_shown(node)) {
            *child = Some(node);
        }
    }
    last
}

/// The lines that lead from the ancestors to each node, cut to a width.
pub(super) fn branches(parents: &[NodeId], last: &[Option<NodeId>], width: usize) -> Vec<String> {
    // What stands before the children of each node: a chain of any length costs no more than its cut.
    let mut rails: Vec<String> = Vec::with_capacity(parents.len());
    let mut branches = Vec::with_capacity(parents.len());
    for (node, parent) in parents.iter().enumerate() {
        let is_last = last[node.min(parent.index())] == Some(NodeId::from(node));
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
