//! Leaves get slots one beside the other, a task node stands in the middle of its children.

use ambidex_model::NodeId;

use super::label::{Label, Tree};
use super::plan::{Edge, MARK, Placed, Plan};
use crate::svg::page::Frame;

/// Most columns side by side.
const MAX_COLUMNS: usize = 8;
/// Between neighbors across the direction of growth.
const GAP: f64 = 5.0;
/// Between the lowest leaves of two task nodes.
const FAMILY_GAP: f64 = 4.0;
/// From one level to the next when the tree grows downwards, between their frames.
const FALL: f64 = 42.0;
/// The same above an only child, where no number has to stand.
const LONE_FALL: f64 = 20.0;
/// As `FALL`, to the right.
const STRIDE: f64 = 30.0;
/// Height of a text line.
const LINE: f64 = 12.0;

/// Where a node may stand.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Growth {
    Down { in_two_lines: bool },
    Right { columns: usize },
}

/// The arrangement that is shrunk least to fit a page; of equals the one nearest to the paper's.
pub(super) fn best(tree: &Tree) -> Plan {
    let down = [false, true].map(|in_two_lines| Growth::Down { in_two_lines });
    let right = (1..=MAX_COLUMNS).map(|columns| Growth::Right { columns });
    let plans = down.into_iter().chain(right).map(|growth| plan(tree, growth));
    let least = plans.reduce(|best, other| if other.shrink() < best.shrink() { other } else { best });
    least.expect("there are several arrangements")
}

fn plan(tree: &Tree, growth: Growth) -> Plan {
    match growth {
        Growth::Down { in_two_lines } => down(tree, in_two_lines),
        Growth::Right { columns } => right(tree, columns),
    }
}

/// What a node takes without its children.
fn size(tree: &Tree, node: NodeId, label: &Label, has_mark_below: bool) -> (f64, f64) {
    let has_mark = tree.has_marks;
    let height = label.lines.len() as f64 * LINE + if tree.is_leaf(node) { 5.0 } else { 8.0 };
    match (has_mark, has_mark_below) {
        (false, _) => (label.width, height),
        (true, true) => (label.width, height + MARK),
        (true, false) => (label.width + MARK - 2.0, height),
    }
}

/// The middles of all nodes across the direction of growth, and how much room they take: a slot for every leaf, as
/// much for a task node as its children or itself take.
fn spread(tree: &Tree, nodes: &[NodeId], own: &[f64]) -> (Vec<f64>, f64) {
    let mut room = own.to_vec();
    let mut inner = vec![0.0; tree.len()];
    for &node in nodes.iter().rev() {
        let drawn = tree.children(node).iter().filter(|child| own[child.index()] > 0.0);
        let taken: f64 = drawn.map(|child| room[child.index()] + gap(tree, *child)).sum();
        inner[node.index()] = taken;
        room[node.index()] = room[node.index()].max(taken);
    }
    let mut start = vec![0.0; tree.len()];
    let mut middle: Vec<f64> = vec![0.0; tree.len()];
    for &node in nodes {
        let mut next = start[node.index()] + (room[node.index()] - inner[node.index()]) / 2.0;
        for child in tree.children(node).iter().filter(|child| own[child.index()] > 0.0) {
            start[child.index()] = next + gap(tree, *child) / 2.0;
            next += room[child.index()] + gap(tree, *child);
        }
    }
    for &node in nodes.iter().rev() {
        let mut drawn = tree.children(node).iter().filter(|child| own[child.index()] > 0.0);
        let first = drawn.next();
        let last = drawn.next_back().or(first);
        middle[node.index()] = match first.zip(last) {
            Some((first, last)) if inner[node.index()] >= own[node.index()] => {
                let half = own[node.index()] / 2.0;
                let wanted = (middle[first.index()] + middle[last.index()]) / 2.0;
                wanted.clamp(start[node.index()] + half, start[node.index()] + room[node.index()] - half)
            }
            Some(_) | None => start[node.index()] + room[node.index()] / 2.0,
        };
    }
    let total = nodes.first().map_or(0.0, |top| room[top.index()]);
    (middle, total)
}

fn gap(tree: &Tree, node: NodeId) -> f64 {
    GAP + if tree.is_leaf(node) { 0.0 } else { FAMILY_GAP }
}

fn down(tree: &Tree, in_two_lines: bool) -> Plan {
    let nodes: Vec<NodeId> = tree.nodes().collect();
    let labels: Vec<Label> = nodes.iter().map(|&node| tree.label(node, in_two_lines)).collect();
    let sizes: Vec<(f64, f64)> =
        nodes.iter().zip(&labels).map(|(&node, label)| size(tree, node, label, true)).collect();
    let own: Vec<f64> = sizes.iter().map(|size| size.0).collect();
    let (middle, width) = spread(tree, &nodes, &own);
    let tops = levels(tree, sizes.iter().map(|size| size.1), FALL, LONE_FALL);
    let frame = |node: NodeId| {
        let (width, height) = sizes[node.index()];
        Frame { x: middle[node.index()] - width / 2.0, y: tops[tree.depth(node)], width, height }
    };
    let placed = |(&node, label): (&NodeId, &Label)| Placed {
        node,
        frame: frame(node),
        label: label.clone(),
        is_leaf: tree.is_leaf(node),
        is_again: false,
        has_mark_below: true,
    };
    let edges = nodes.iter().flat_map(|&node| {
        let from = frame(node);
        let from = (from.x + from.width / 2.0, from.y + from.height);
        numbered(tree, node).map(move |(child, order)| {
            let to = frame(child);
            let to = (to.x + to.width / 2.0, to.y);
            let along = |share: f64| (from.0 + (to.0 - from.0) * share, from.1 + (to.1 - from.1) * share);
            Edge { way: vec![from, to], order, order_at: along(0.72) }
        })
    });
    let height = nodes.iter().map(|&node| frame(node).y + frame(node).height).fold(0.0, f64::max);
    Plan { edges: edges.collect(), nodes: nodes.iter().zip(&labels).map(placed).collect(), width, height }
}

/// Columns beside one another: the children of the first node that has several are dealt out to them in order.
fn right(tree: &Tree, columns: usize) -> Plan {
    let labels: Vec<Label> = tree.nodes().map(|node| tree.label(node, false)).collect();
    let sizes: Vec<(f64, f64)> =
        tree.nodes().zip(&labels).map(|(node, label)| size(tree, node, label, false)).collect();
    let lefts = levels(tree, sizes.iter().map(|size| size.0), STRIDE, STRIDE);
    let deepest = tree.nodes().map(|node| lefts[tree.depth(node)] + sizes[node.index()].0).fold(0.0, f64::max);
    let mut plan = Plan { nodes: Vec::new(), edges: Vec::new(), width: 0.0, height: 0.0 };
    for (index, nodes) in deal(tree, columns).iter().enumerate() {
        let left = index as f64 * (deepest + STRIDE);
        let mut own = vec![0.0; tree.len()];
        nodes.iter().for_each(|node| own[node.index()] = sizes[node.index()].1);
        let (middle, height) = spread(tree, nodes, &own);
        let frame = |node: NodeId| {
            let (width, height) = sizes[node.index()];
            Frame { x: left + lefts[tree.depth(node)], y: middle[node.index()] - height / 2.0, width, height }
        };
        for &node in nodes {
            plan.nodes.push(Placed {
                node,
                frame: frame(node),
                label: labels[node.index()].clone(),
                is_leaf: tree.is_leaf(node),
                is_again: index > 0 && plan.nodes.iter().any(|placed| placed.node == node),
                has_mark_below: false,
            });
            let drawn = numbered(tree, node).filter(|(child, _)| own[child.index()] > 0.0);
            plan.edges.extend(drawn.map(|(child, order)| elbow(frame(node), frame(child), order)));
        }
        plan.width = left + deepest;
        plan.height = plan.height.max(height);
    }
    plan
}

/// From the right of a frame to the left of another, with the number in front of it.
fn elbow(from: Frame, to: Frame, order: Option<usize>) -> Edge {
    let start = (from.x + from.width, from.y + from.height / 2.0);
    let end = (to.x, to.y + to.height / 2.0);
    let bend = end.0 - STRIDE * 0.6;
    Edge { way: vec![start, (bend, start.1), (bend, end.1), end], order, order_at: (end.0 - STRIDE * 0.25, end.1) }
}

/// The nodes of each column in preorder, each with the nodes above it.
fn deal(tree: &Tree, columns: usize) -> Vec<Vec<NodeId>> {
    let mut split = NodeId(0);
    while let [only] = tree.children(split) {
        split = *only;
    }
    let children = tree.children(split);
    let above: Vec<NodeId> = tree.nodes().take_while(|&node| node <= split).collect();
    let end = |index: usize| children.get(index).map_or(tree.len(), |next| next.index());
    let below = |index: usize| (children[index].index()..end(index + 1)).map(NodeId::from);
    let leaves = |index: usize| below(index).filter(|&node| tree.is_leaf(node)).count();
    let all: usize = (0..children.len()).map(leaves).sum();
    let mut dealt = vec![above.clone()];
    let mut count = 0;
    for index in 0..children.len() {
        let due = count * columns >= all * dealt.len() && count > 0 && dealt.len() < columns;
        if due {
            dealt.push(above.clone());
        }
        dealt.last_mut().expect("it begins with a column").extend(below(index));
        count += leaves(index);
    }
    dealt
}

/// The children of a node, numbered where order matters.
fn numbered<'a>(tree: &'a Tree, node: NodeId) -> impl Iterator<Item = (NodeId, Option<usize>)> + use<'a> {
    let is_then = tree.is_then(node);
    tree.children(node).iter().zip(1..).map(move |(&child, number)| (child, is_then.then_some(number)))
}

/// Where each level begins along the direction of growth; `lone` is the distance to a level of only children.
fn levels(tree: &Tree, lengths: impl Iterator<Item = f64>, between: f64, lone: f64) -> Vec<f64> {
    let mut levels: Vec<(f64, f64)> = Vec::new();
    for (node, length) in tree.nodes().zip(lengths) {
        let depth = tree.depth(node);
        if levels.len() <= depth {
            levels.resize(depth + 1, (0.0, lone));
        }
        let (longest, behind) = levels[depth];
        let behind = if tree.children(node).len() > 1 || tree.is_then(node) { between } else { behind };
        levels[depth] = (longest.max(length), behind);
    }
    let mut next = 0.0;
    let begin = |(longest, behind): (f64, f64)| {
        let at = next;
        next += longest + behind;
        at
    };
    levels.into_iter().map(begin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;
    use ambidex_model::{EntryKind, Header, NodeEntry};
    use ambidex_record::History;

    /// A tree from parents and kinds, named after both.
    fn header(nodes: &[(u32, &str)]) -> Header {
        let mut header = sample::header();
        let entry = |&(parent, kind): &(u32, &str)| NodeEntry {
            parent: NodeId(parent),
            kind: EntryKind::from(kind.to_owned()),
        };
        header.nodes = nodes.iter().map(entry).collect();
        header.names.nodes =
            nodes.iter().enumerate().map(|(index, (_, kind))| format!("{kind} number {index}")).collect();
        header
    }

    /// An AND over THENs of `length` behaviors each.
    fn wide(thens: usize, length: usize) -> Header {
        let mut nodes = vec![(0, "root"), (0, "and")];
        for _ in 0..thens {
            let then = u32::try_from(nodes.len()).unwrap();
            nodes.push((1, "then"));
            nodes.extend(std::iter::repeat_n((then, "move"), length));
        }
        header(&nodes)
    }

    fn chain(length: u32) -> Header {
        let nodes: Vec<_> =
            (0..length).map(|node| (node.saturating_sub(1), if node == 0 { "root" } else { "then" })).collect();
        header(&[nodes, vec![(length - 1, "move")]].concat())
    }

    fn check(header: &Header) {
        let history = History::new(header);
        for history in [None, Some(&history)] {
            let tree = Tree::new(header, history, 500);
            for growth in [
                Growth::Down { in_two_lines: false },
                Growth::Down { in_two_lines: true },
                Growth::Right { columns: 1 },
                Growth::Right { columns: 3 },
            ] {
                let plan = plan(&tree, growth);
                let frames: Vec<Frame> = plan.nodes.iter().map(|placed| placed.frame).collect();
                for (index, one) in frames.iter().enumerate() {
                    let is_inside = one.x > -0.01 && one.y > -0.01 && one.x + one.width < plan.width + 0.01;
                    assert!(is_inside && one.y + one.height < plan.height + 0.01, "{growth:?}: {one:?} sticks out");
                    for other in &frames[..index] {
                        let is_apart = one.x + one.width <= other.x
                            || other.x + other.width <= one.x
                            || one.y + one.height <= other.y
                            || other.y + other.height <= one.y;
                        assert!(is_apart, "{growth:?}: {one:?} lies on {other:?}");
                    }
                }
                let nodes: std::collections::BTreeSet<_> = plan.nodes.iter().map(|placed| placed.node).collect();
                assert_eq!(nodes.len(), tree.len(), "{growth:?}: every node is drawn");
                let again = plan.nodes.iter().filter(|placed| placed.is_again).count();
                assert_eq!(plan.nodes.len() - again, tree.len(), "{growth:?}: no node is drawn twice unsaid");
            }
        }
    }

    #[test]
    fn nothing_overlaps_or_sticks_out() {
        check(&sample::header());
        check(&wide(1, 1));
        check(&wide(20, 4));
        check(&wide(1, 40));
        check(&chain(30));
        check(&header(&[(0, "root"), (0, "a behavior that stands alone and has a very long kind")]));
        check(&header(&[
            (0, "root"),
            (0, "or"),
            (1, "then"),
            (2, "x"),
            (1, "and"),
            (4, "or"),
            (5, "y"),
            (5, "z"),
            (4, "w"),
        ]));
    }

    #[test]
    fn the_shape_decides() {
        let best = |header: &Header| best(&Tree::new(header, None, 500));
        let grows_down = |plan: &Plan| plan.edges.iter().all(|edge| edge.way.len() == 2);
        assert!(grows_down(&best(&sample::header())), "experiment 1 as the paper draws it");
        assert!(!grows_down(&best(&wide(12, 5))), "what is wide grows to the right");
        let many = best(&wide(40, 4));
        assert!(many.shrink() < 1.6, "200 nodes are shrunk {:.2} times", many.shrink());
        assert!(many.nodes.iter().any(|placed| placed.is_again), "in columns");
    }

    #[test]
    fn children_of_a_then_are_numbered_and_of_no_other() {
        let header = sample::header();
        let plan = best(&Tree::new(&header, None, 500));
        let numbers: Vec<_> = plan.edges.iter().filter_map(|edge| edge.order).collect();
        assert_eq!(numbers, [1, 2, 3, 4].repeat(4));
    }
}
