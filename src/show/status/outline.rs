//! The tree of a snapshot as lines; where there are too few of them, what matters least is not shown.

use std::collections::HashMap;

use ambidex_model::NodeId;
use ambidex_record::LeafState;

use crate::Palette;
use crate::text::{branches, clip, columns, last_children, mark};

use super::snapshot::NodeRow;
use crate::text::table::{Column, NARROW, head, line, rest};

/// A tree and the columns that it is drawn in.
#[derive(Debug)]
pub(crate) struct Outline<'a> {
    nodes: &'a [NodeRow],
    /// Of each row the place of that of its parent; the first is its own.
    parents: Vec<NodeId>,
    table: [Column; 3],
    palette: Palette,
}

impl<'a> Outline<'a> {
    /// The tree's column is as wide as the whole tree, so that nothing moves when other parts of it are shown.
    pub(crate) fn new(nodes: &'a [NodeRow], width: usize, palette: Palette) -> Self {
        let places: HashMap<u32, usize> = nodes.iter().enumerate().map(|(place, node)| (node.id, place)).collect();
        let above = |node: &NodeRow| node.parent.and_then(|parent| places.get(&parent).copied());
        let parents = nodes.iter().enumerate().map(|(place, node)| NodeId::from(above(node).unwrap_or(place)));
        let parents: Vec<NodeId> = parents.collect();
        let most = width * 2 / 5;
        let branches = branches(&parents, &last_children(&parents, |_| true), most);
        let widest = nodes
            .iter()
            .zip(&branches)
            .map(|(node, branches)| columns(branches) + 2 + columns(&node.name) + columns(&kind(node)));
        let task = Column::wide("task", widest.max().unwrap_or_default().clamp(4, most));
        let potential = Column::number(if width < NARROW { "pot." } else { "potential" }, 5);
        let state = Column::wide("state, and why", rest(&[task, potential], width));
        Self { nodes, parents, table: [task, potential, state], palette }
    }

    /// Lines of the whole tree.
    pub(crate) fn height(&self) -> usize {
        self.nodes.len() + 1
    }

    /// At most so many lines.
    pub(crate) fn lines(&self, height: usize) -> Vec<String> {
        let shown = self.shown(height.saturating_sub(1));
        let last = last_children(&self.parents, |node| shown[node.index()]);
        let branches = branches(&self.parents, &last, self.table[0].width.saturating_sub(3));
        let hidden = self.hidden(&shown);
        let rows = self.nodes.iter().enumerate().zip(&hidden).filter(|((place, _), _)| shown[*place]);
        let rows = rows.map(|((place, node), hidden)| {
            let next = self.next_below(place).filter(|(leaf, _, _)| !shown[*leaf]);
            let note = match next {
                Some((_, leaf, reason)) => format!("{}/{} done, {}: {reason}", node.done, node.of, leaf.name),
                None => note(node, *hidden),
            };
            self.line(node, note, &branches[place])
        });
        std::iter::once(head(&self.table, &self.palette)).chain(rows).take(height).collect()
    }

    fn line(&self, node: &NodeRow, note: String, branches: &str) -> String {
        let [task, potential, state] = &self.table;
        let style = self.palette.of(node.state);
        let room = task.width.saturating_sub(columns(branches) + 2);
        let name = clip(&node.name, room);
        let kind = clip(&kind(node), room.saturating_sub(columns(&name)));
        let free = " ".repeat(room.saturating_sub(columns(&name) + columns(&kind)));
        let own = node.potential.map_or(String::new(), |potential| format!("{potential:.3}"));
        let is_open = node.of == 1 && node.state == LeafState::Waiting;
        let note_style = if is_open { Palette::plain().strong } else { style };
        format!(
            "{}{} {name}{}{free}  {}",
            Palette::paint(self.palette.faint, branches),
            Palette::paint(style, mark(node.state)),
            Palette::paint(self.palette.faint, kind),
            line(&[*potential, *state], &[(self.palette.faint, own), (note_style, note)]),
        )
    }

    /// Below a node that waits: the first behavior that does, and why.
    fn next_below(&self, place: usize) -> Option<(usize, &NodeRow, &str)> {
        let node = &self.nodes[place];
        let below = self.nodes.iter().enumerate().skip(place + 1);
        let below = below
            .take_while(|(other, _)| self.parents[*other].index() >= place && self.parents[*other].index() < *other);
        let mut waiting = below.filter(|(_, other)| is_leaf(other) && other.state == LeafState::Waiting);
        let is_closed = is_leaf(node) || node.state != LeafState::Waiting;
        let (at, first) = waiting.next().filter(|_| !is_closed)?;
        Some((at, first, first.reason.as_deref()?))
    }

    /// Which nodes are shown: those that matter most, each with all of its ancestors.
    fn shown(&self, room: usize) -> Vec<bool> {
        let mut shown = vec![self.nodes.len() <= room; self.nodes.len()];
        let mut left = if shown.first() == Some(&true) { 0 } else { room };
        let mut order: Vec<usize> = (0..self.nodes.len()).collect();
        order.sort_by_key(|&index| (rank(&self.nodes[index]), index));
        for node in order {
            if left == 0 {
                break;
            }
            // Above what is shown all is.
            let missing = self.path(node).take_while(|&node| !shown[node]);
            let missing: Vec<usize> = missing.take(left + 1).collect();
            if missing.len() <= left {
                left -= missing.len();
                missing.into_iter().for_each(|node| shown[node] = true);
            }
        }
        shown
    }

    /// A node and its ancestors.
    fn path(&self, node: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(node), |&node| {
            let parent = self.parents[node].index();
            (parent < node).then_some(parent)
        })
    }

    /// How many nodes are not shown below each that is, as its next shown ancestor.
    fn hidden(&self, shown: &[bool]) -> Vec<usize> {
        let mut hidden = vec![0; shown.len()];
        for node in (0..shown.len()).rev().filter(|&node| !shown[node]) {
            let parent = self.parents[node].index();
            if parent < node {
                hidden[parent] += hidden[node] + 1;
            }
        }
        hidden
    }
}

fn is_leaf(node: &NodeRow) -> bool {
    !matches!(node.kind.as_str(), "root" | "tasks" | "and" | "or" | "then" | "cleanup")
}

/// The kind behind the name, unless the name begins with it.
fn kind(node: &NodeRow) -> String {
    match node.name.starts_with(&node.kind) {
        true => String::new(),
        false => format!("  {}", node.kind),
    }
}

/// How soon a node is left out, the greatest first.
fn rank(node: &NodeRow) -> u8 {
    let is_asked = node.potential.is_some();
    match (is_leaf(node), node.state) {
        (true, LeafState::Active) => 0,
        (true, LeafState::Failed | LeafState::Canceled) => 1,
        (false, LeafState::Active | LeafState::Failed | LeafState::Canceled) => 2,
        (true, LeafState::Waiting) if is_asked => 3,
        (false, LeafState::Waiting) => 4,
        (true, LeafState::Waiting) => 5,
        (false, LeafState::Done | LeafState::Skipped) => 6,
        (true, LeafState::Done | LeafState::Skipped) => 7,
        (_, LeafState::NotAsked | LeafState::NotNeeded) => 8,
    }
}

/// What is said behind a node.
fn note(node: &NodeRow, hidden: usize) -> String {
    let word = node.state.word();
    let hidden = if hidden > 0 { format!(", {hidden} not shown") } else { String::new() };
    if !is_leaf(node) {
        let done = if node.done < node.of { format!(", {} of {} done", node.done, node.of) } else { String::new() };
        let why = node.reason.as_ref().map_or(String::new(), |reason| format!(": {reason}"));
        return format!("{word}{why}{done}{hidden}");
    }
    match (node.state, &node.reason) {
        (LeafState::Active, _) => match node.progress {
            Some(progress) => format!("{word}, {:.0} %", (progress * 100.0).floor()),
            None => word.to_owned(),
        },
        (LeafState::Waiting, Some(reason)) => reason.clone(),
        (LeafState::Failed | LeafState::Canceled | LeafState::NotAsked | LeafState::NotNeeded, Some(reason)) => {
            format!("{word}: {reason}")
        }
        (
            LeafState::Waiting
            | LeafState::Done
            | LeafState::Skipped
            | LeafState::Failed
            | LeafState::Canceled
            | LeafState::NotAsked
            | LeafState::NotNeeded,
            _,
        ) => word.to_owned(),
    }
}
