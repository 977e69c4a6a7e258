//! The task tree as the paper draws it (Fig. 3 and 4): task nodes above, behaviors as leaves.

use std::collections::BTreeSet;

use ambidex_model::{EntryKind, Header, NodeId};
use ambidex_record::{History, LeafState};

use super::label::{Label, Tree};
use super::layout;
use super::plan::{Edge, Placed, Plan};
use crate::svg::fit::{self, NOTE, TITLE};
use crate::svg::marks::{Mark, mark};
use crate::svg::page::{MARGIN, PAGE_WIDTH, Shape, page};
use crate::text::count;
use crate::text::phrase::did_it;

/// Most nodes that are drawn; of a larger tree the first.
const MAX_NODES: usize = 2000;
/// Height of title and note above the tree.
const HEAD: f64 = 44.0;
/// Height of the line below it.
const FOOT: f64 = 24.0;

/// The tree of a mission and, where a history is given, the state of each node.
///
/// It is drawn downwards, to the right, or to the right in columns: whichever is shrunk least to fit a page.
pub fn picture(header: &Header, history: Option<&History>) -> String {
    let state = |leaf: NodeId| history.map(|history| history.state(leaf));
    let tree = Tree::new(header, history, MAX_NODES);
    let plan = layout::best(&tree);
    let width = plan.width.max(PAGE_WIDTH - 2.0 * MARGIN);
    let indent = MARGIN + (width - plan.width) / 2.0;
    let plan = plan.moved(indent, HEAD);
    let mut shapes = head(header, &tree, &plan, width);
    shapes.extend(plan.edges.iter().map(edge));
    shapes.extend(plan.edges.iter().filter_map(order));
    let states: BTreeSet<LeafState> = plan.nodes.iter().filter_map(|placed| state(tree.id(placed.node))).collect();
    let way = |node| history.and_then(|history| history.instead_of(node));
    shapes.extend(plan.nodes.iter().map(|placed| {
        let id = tree.id(placed.node);
        node(placed, state(id)).titled(&said(header, id, state(id), way(id)))
    }));
    let bottom = HEAD + plan.height;
    shapes.extend(foot(&plan, &states, bottom + FOOT - 4.0));
    let title = format!("{}: task tree", header.mission);
    let description =
        format!("Task tree of the mission {} for the robot {}: {}.", header.mission, header.robot, figures(header));
    page(&title, &description, (width + 2.0 * MARGIN, bottom + FOOT + MARGIN), shapes)
}

fn figures(header: &Header) -> String {
    let leaves = header.nodes.iter().filter(|node| node.kind.is_behavior()).count();
    format!("{}, {}", count(header.nodes.count(), "node"), count(leaves, "behavior"))
}

fn head(header: &Header, tree: &Tree, plan: &Plan, width: f64) -> Vec<Shape> {
    let title = fit::clip(&header.mission, TITLE, width);
    let mut note = format!("robot {} · {}", header.robot, figures(header));
    if tree.is_cut() {
        note = format!("the first {} of {}", tree.len(), note);
    }
    if plan.nodes.iter().any(|placed| placed.is_again) {
        note += " · a dashed task node is the one of the first column once more";
    }
    vec![
        Shape::text("title", (MARGIN, MARGIN + 12.0), &title),
        Shape::text("note", (MARGIN, MARGIN + 26.0), &fit::clip(&note, NOTE, width)),
    ]
}

fn edge(edge: &Edge) -> Shape {
    Shape::path("edge", &edge.way, false)
}

/// The place of a child of a THEN, on its edge.
fn order(edge: &Edge) -> Option<Shape> {
    let (order, (x, y)) = (edge.order?, edge.order_at);
    let text = order.to_string();
    let radius = (fit::width(&text, fit::SMALL) / 2.0 + 1.5).max(5.5);
    let ground = Shape::circle("paper", (x, y), radius);
    Some(Shape::group("order", [ground, Shape::text("small middle", (x, y + 3.2), &text)]))
}

fn node(placed: &Placed, state: Option<LeafState>) -> Shape {
    let frame = placed.frame;
    let (class, ink) = match (placed.is_leaf, state) {
        (false, _) if placed.is_again => ("again", "text"),
        (false, _) => ("node", "text"),
        (true, None | Some(LeafState::NotAsked | LeafState::NotNeeded)) => ("leaf", "text"),
        (true, Some(LeafState::Waiting)) => ("leaf-waiting", "text"),
        (true, Some(LeafState::Active)) => ("active", "inner-active"),
        (true, Some(LeafState::Done)) => ("leaf-done", "text"),
        (true, Some(LeafState::Skipped)) => ("leaf-skipped", "text"),
        (true, Some(LeafState::Failed | LeafState::Canceled)) => ("leaf-failed", "text"),
    };
    let round = if placed.is_leaf { 2.0 } else { frame.height.min(24.0) / 2.0 };
    let mut shapes = vec![Shape::rect(class, frame, round)];
    let Label { lines, .. } = &placed.label;
    let room = placed.text_frame(state.is_some());
    let first = room.y + room.height / 2.0 - (lines.len() as f64 - 1.0) * 6.0 + 3.5;
    for (index, line) in lines.iter().enumerate() {
        let at = (room.x + room.width / 2.0, first + index as f64 * 12.0);
        let class = if placed.is_leaf || index > 0 { format!("{ink} middle") } else { "head middle".to_owned() };
        shapes.push(Shape::text(&class, at, line));
    }
    shapes.extend(state.map(|state| mark(sign(state), placed.mark_at(), 4.0)));
    Shape::group(if placed.is_leaf { "behavior" } else { "task" }, shapes)
}

/// What is said where a pointer rests on a node.
fn said(header: &Header, node: NodeId, state: Option<LeafState>, way: Option<NodeId>) -> String {
    let name = header.names.node(node);
    let kind = &header.nodes[node.index()].kind;
    let rule = match kind {
        EntryKind::Root => "keeps resources and world",
        EntryKind::And => "all children, in any order",
        EntryKind::Tasks => "tasks that come and go, each by itself",
        EntryKind::Or => "one child",
        EntryKind::Then => "all children, in order",
        EntryKind::Cleanup => "the first child; where that fails or is given up, then the second",
        EntryKind::Behavior(_) => "behavior",
    };
    let way = way.filter(|_| state == Some(LeafState::NotNeeded));
    let why = way.map_or(String::new(), |way| format!(": {}", did_it(way, &header.names)));
    match state {
        None => format!("{name} ({}): {rule}", kind.word()),
        Some(state) if kind.is_behavior() => format!("{name} ({}): {}{why}", kind.word(), state.word()),
        Some(state) => format!("{name} ({}): {rule}; {}{why}", kind.word(), state.word()),
    }
}

fn sign(state: LeafState) -> Mark {
    match state {
        LeafState::Waiting => Mark::Waiting,
        LeafState::Active => Mark::Active,
        LeafState::Done => Mark::Done,
        LeafState::Skipped => Mark::Skipped,
        LeafState::Failed => Mark::Failed,
        LeafState::Canceled => Mark::Canceled,
        LeafState::NotAsked => Mark::NotAsked,
        LeafState::NotNeeded => Mark::NotNeeded,
    }
}

/// What signs and numbers mean that occur.
fn foot(plan: &Plan, states: &BTreeSet<LeafState>, y: f64) -> Vec<Shape> {
    let mut shapes = Vec::new();
    let mut x = MARGIN;
    for state in states {
        shapes.push(mark(sign(*state), (x + 4.0, y - 3.2), 4.0));
        shapes.push(Shape::text("note", (x + 12.0, y), state.word()));
        x += 12.0 + fit::width(state.word(), NOTE) + 14.0;
    }
    if plan.edges.iter().any(|edge| edge.order.is_some()) {
        shapes.push(Shape::text("note", (x, y), "1, 2, … order of the children of a THEN"));
    }
    shapes
}
