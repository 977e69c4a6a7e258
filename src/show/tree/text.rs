//! The task tree as indented text.

use std::fmt::Write;

use ambidex_model::Header;
use ambidex_record::History;

use super::label::{in_order, places_of_parents};
use crate::Palette;
use crate::text::{MIN_WIDTH, branches, clip, columns, last_children, mark, phrase};

/// The tree with the kind of each node and, where a history is given, the state of each, and of a way that an OR did
/// not need what did it.
pub fn text(header: &Header, history: Option<&History>, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let nodes = in_order(header, history);
    let parents = places_of_parents(header, &nodes);
    let branches = branches(&parents, &last_children(&parents, |_| true), width / 2);
    let left = history.map(History::ways_left).unwrap_or_default();
    let mut text = String::new();
    for (&node, branches) in nodes.iter().zip(&branches) {
        let kind = header.nodes[node.index()].kind.word();
        let name = header.names.node(node);
        let state = history.map(|history| history.state(node));
        let sign = state.map_or(String::new(), |state| Palette::paint(palette.of(state), mark(state)) + " ");
        let room = width - columns(branches) - if state.is_some() { 2 } else { 0 };
        let mut kind = if name.starts_with(kind) { String::new() } else { kind.to_owned() };
        if let Some((_, way)) = left.iter().find(|(left, _)| *left == node) {
            let gap = if kind.is_empty() { "" } else { ", " };
            kind += &format!("{gap}not needed: {}", phrase::did_it(*way, &header.names));
        }
        let name = clip(name, room);
        let kind = clip(&kind, room.saturating_sub(columns(&name) + 2));
        let line = format!(
            "{}{sign}{name}{}",
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
