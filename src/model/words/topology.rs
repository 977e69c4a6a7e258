//! The shape of the task tree. Ids are given in tree order and never again; what is added to a live tree later gets the next
//! ones, so that all at or below a node is one run of ids, or a few where something was added below it.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{NodeId, Runs};

/// A run of nodes in preorder, `from` included, `to` not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct NodeRange {
    /// The first node.
    pub from: NodeId,
    /// The first node behind it.
    pub to: NodeId,
}

impl NodeRange {
    /// Whether `node` lies in the run.
    pub fn contains(&self, node: NodeId) -> bool {
        (self.from..self.to).contains(&node)
    }

    /// The nodes of the run that a tree of so many has: a run read from a file can be of any length.
    pub fn nodes(&self, of: usize) -> impl Iterator<Item = NodeId> + Clone + use<> {
        let end = self.to.index().min(of);
        (self.from.index().min(end)..end).map(NodeId::from)
    }
}

/// The shape of a tree.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Topology {
    shapes: Runs<Shape>,
    /// The first id that was never given.
    next: NodeId,
    stem: NodeId,
    /// Nodes that are asked only where what stands before them has failed or is given up.
    cleanups: BTreeSet<NodeId>,
    /// Nodes at or below which children were added or removed.
    edited: BTreeMap<NodeId, Edited>,
    version: u64,
}

/// Where a node stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Shape {
    parent: NodeId,
    /// The first id behind the run that it begins.
    end: NodeId,
    is_gone: bool,
}

#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Edited {
    /// In their order.
    children: Vec<NodeId>,
    /// What is below it beyond its own run, in the order of ids.
    more: Vec<Range<NodeId>>,
}

impl Topology {
    /// From each node's parent in preorder; the root is its own parent.
    ///
    /// # Panics
    /// When the parents are not those of a tree in preorder.
    pub fn new(parents: Vec<NodeId>) -> Self {
        let ends = ends(&parents);
        let shape = |(parent, end)| Shape { parent, end, is_gone: false };
        let next = NodeId::from(parents.len());
        let shapes = std::iter::zip(parents, ends).map(shape).collect();
        let (stem, version) = (NodeId(0), 0);
        Self { shapes, next, stem, version, cleanups: BTreeSet::new(), edited: BTreeMap::new() }
    }

    /// The same where tasks come and go below a node, each by itself.
    #[must_use]
    pub fn with_stem(self, stem: NodeId) -> Self {
        Self { stem, ..self }
    }

    /// The lowest node above all tasks.
    pub fn stem(&self) -> NodeId {
        self.stem
    }

    /// Grows with every change.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Whether something was added or removed at or below a node, so that its children are not in the order of ids, or
    /// what is below it is more than one run.
    pub fn is_edited(&self, node: NodeId) -> bool {
        !self.edited.is_empty() && self.edited.contains_key(&node)
    }

    /// The same, where some nodes have a body and, behind it, a cleanup.
    #[must_use]
    pub fn with_cleanups_of(mut self, has_cleanup: impl Fn(NodeId) -> bool) -> Self {
        self.find_cleanups(NodeId(1)..self.next, has_cleanup);
        self
    }

    fn find_cleanups(&mut self, nodes: Range<NodeId>, has_cleanup: impl Fn(NodeId) -> bool) {
        let nodes = (nodes.start.0..nodes.end.0).map(NodeId);
        // The body stands right behind its parent.
        let is_cleanup = |node: &NodeId| has_cleanup(self.parent(*node)) && self.parent(*node).0 + 1 < node.0;
        let cleanups: Vec<NodeId> = nodes.filter(is_cleanup).collect();
        self.cleanups.extend(cleanups);
    }

    /// Whether there is such a node.
    pub fn has(&self, node: NodeId) -> bool {
        self.shapes.get(node.index()).is_some_and(|shape| !shape.is_gone)
    }

    /// The first id that was never given: one behind that of the last node.
    pub fn next(&self) -> NodeId {
        self.next
    }

    /// All nodes in the order of their ids.
    pub fn nodes(&self) -> impl DoubleEndedIterator<Item = NodeId> {
        self.shapes.entries().filter(|(_, shape)| !shape.is_gone).map(|(index, _)| NodeId::from(index))
    }

    /// Whether a node is a cleanup.
    pub fn is_cleanup(&self, node: NodeId) -> bool {
        !self.cleanups.is_empty() && self.cleanups.contains(&node)
    }

    /// Whether a node is a cleanup or below one.
    pub fn is_in_cleanup(&self, node: NodeId) -> bool {
        !self.cleanups.is_empty() && self.path(node).any(|above| self.cleanups.contains(&above))
    }

    /// The nodes that are cleanups.
    pub fn cleanups(&self) -> &BTreeSet<NodeId> {
        &self.cleanups
    }

    /// A node and those above it, root last.
    pub fn path(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        std::iter::successors(Some(node), |node| (node.0 > 0).then(|| self.parent(*node)))
    }

    /// The parent of a node; the root's is itself.
    pub fn parent(&self, node: NodeId) -> NodeId {
        self.shapes[node.index()].parent
    }

    /// Whether `node` is `top` or below it.
    pub fn is_within(&self, node: NodeId, top: NodeId) -> bool {
        let is_own = top <= node && node < self.shapes[top.index()].end;
        is_own || self.more(top).iter().any(|run| run.contains(&node))
    }

    /// The runs of ids at and below a node: its own, and those of what was added below it. What is gone may be in them.
    pub fn below(&self, node: NodeId) -> impl Iterator<Item = Range<NodeId>> + Clone + use<'_> {
        let own = node..self.shapes[node.index()].end;
        std::iter::once(own).chain(self.more(node).iter().cloned())
    }

    fn more(&self, node: NodeId) -> &[Range<NodeId>] {
        // As in all that never changes.
        if self.edited.is_empty() {
            return &[];
        }
        self.edited.get(&node).map_or(&[], |edited| &edited.more)
    }

    /// The runs of ids at and below several nodes, those that follow each other in one.
    pub fn runs(&self, nodes: impl IntoIterator<Item = NodeId>) -> Vec<NodeRange> {
        let mut runs: Vec<NodeRange> = Vec::new();
        for run in nodes.into_iter().flat_map(|node| self.below(node)) {
            match runs.last_mut().filter(|last| last.to == run.start) {
                Some(last) => last.to = run.end,
                None => runs.push(NodeRange { from: run.start, to: run.end }),
            }
        }
        runs
    }

    /// A node and all below it.
    pub fn nodes_below(&self, node: NodeId) -> impl Iterator<Item = NodeId> + Clone + use<'_> {
        self.below(node).flat_map(|run| (run.start.0..run.end.0).map(NodeId)).filter(|node| self.has(*node))
    }

    /// A node and all below it in tree order.
    pub fn in_order(&self, node: NodeId) -> impl Iterator<Item = NodeId> + use<'_> {
        let mut next = vec![node];
        std::iter::from_fn(move || {
            let node = next.pop()?;
            let behind = next.len();
            next.extend(self.children(node));
            next[behind..].reverse();
            Some(node)
        })
    }

    /// What a map has of a node and of all below it.
    pub fn within<'a, T>(
        &'a self,
        node: NodeId,
        map: &'a BTreeMap<NodeId, T>,
    ) -> impl Iterator<Item = (NodeId, &'a T)> + Clone + use<'a, T> {
        self.below(node).flat_map(|run| map.range(run).map(|(&node, thing)| (node, thing)))
    }

    /// Which of a node and all below it are in a set.
    pub fn of_set<'a>(
        &'a self,
        node: NodeId,
        set: &'a BTreeSet<NodeId>,
    ) -> impl Iterator<Item = NodeId> + Clone + use<'a> {
        self.below(node).flat_map(|run| set.range(run).copied())
    }

    /// The children of a node in order.
    pub fn children(&self, node: NodeId) -> Children<'_> {
        let edited = if self.edited.is_empty() { None } else { self.edited.get(&node) };
        match edited {
            Some(edited) => Children::Listed(edited.children.iter()),
            None => {
                let (next, end) = (NodeId(node.0 + 1), self.shapes[node.index()].end);
                Children::InARow { topology: self, next, end }
            }
        }
    }

    /// Whether one of two different nodes, of which neither is above the other, comes before the other in tree order.
    pub fn is_before(&self, node: NodeId, other: NodeId) -> bool {
        if self.edited.is_empty() {
            return node < other;
        }
        let above = |node| self.path(node).collect::<Vec<_>>().into_iter().rev();
        let fork = std::iter::zip(above(node), above(other)).find(|(one, another)| one != another);
        let Some((one, another)) = fork else { return node < other };
        self.children(self.parent(one)).find(|child| *child == one || *child == another) == Some(one)
    }

    /// Adds a subtree of so many nodes, each with its parent among them, as a child of a node that comes at some place
    /// among the others; gives the id of its top, behind which the others follow.
    ///
    /// # Panics
    /// When the parents are not those of a tree in preorder, or there is no such node.
    pub fn graft(
        &mut self,
        under: NodeId,
        place: usize,
        parents: &[NodeId],
        has_cleanup: impl Fn(NodeId) -> bool,
    ) -> NodeId {
        self.version += 1;
        let (from, count) = (self.next, parents.len());
        let moved = |node: NodeId| NodeId(from.0 + node.0);
        let to = NodeId::from(from.index() + count);
        let shapes = std::iter::zip(parents, ends(parents)).enumerate().map(|(index, (parent, end))| {
            let parent = if index == 0 { under } else { moved(*parent) };
            Shape { parent, end: moved(end), is_gone: false }
        });
        let shapes = shapes.collect();
        for above in self.path(under).collect::<Vec<_>>() {
            self.edit(above);
            let own = self.shapes[above.index()].end;
            let edited = self.edited.get_mut(&above).expect("it was made just now");
            if own == from {
                self.shapes[above.index()].end = to;
            } else if let Some(last) = edited.more.last_mut().filter(|last| last.end == from) {
                last.end = to;
            } else {
                edited.more.push(from..to);
            }
        }
        let siblings = &mut self.edited.get_mut(&under).expect("it was made just now").children;
        siblings.insert(place.min(siblings.len()), from);
        self.shapes.add(from.index(), shapes);
        self.next = to;
        self.find_cleanups(NodeId(from.0 + 1)..to, has_cleanup);
        from
    }

    /// Whatever below a node changes from here on, its children are listed.
    fn edit(&mut self, node: NodeId) {
        if !self.edited.contains_key(&node) {
            let children = self.children(node).collect();
            self.edited.insert(node, Edited { children, more: Vec::new() });
        }
    }

    /// A node and all below it are gone.
    ///
    /// # Panics
    /// When it is root, or there is no such node.
    pub fn remove(&mut self, node: NodeId) {
        self.version += 1;
        let parent = self.parent(node);
        let gone: Vec<Range<NodeId>> = self.below(node).collect();
        for above in self.path(parent).collect::<Vec<_>>() {
            self.edit(above);
            let edited = self.edited.get_mut(&above).expect("it was made just now");
            edited.more.retain(|run| !gone.iter().any(|gone| gone.start <= run.start && run.end <= gone.end));
        }
        self.edited.get_mut(&parent).expect("it was made just now").children.retain(|child| *child != node);
        for run in &gone {
            for node in (run.start.0..run.end.0).map(NodeId) {
                self.cleanups.remove(&node);
                self.edited.remove(&node);
            }
            self.shapes.remove(run.start.index()..run.end.index());
            for index in run.start.index()..run.end.index() {
                self.shapes.get_mut(index).into_iter().for_each(|shape| shape.is_gone = true);
            }
        }
    }
}

/// By node in preorder, the first one behind its subtree.
fn ends(parents: &[NodeId]) -> Vec<NodeId> {
    let mut ends: Vec<NodeId> = (1..=parents.len()).map(NodeId::from).collect();
    for node in (1..parents.len()).rev() {
        let parent = parents[node].index();
        assert!(parent < node && ends[parent].index() > 0, "not in preorder: {parents:?}");
        ends[parent] = ends[parent].max(ends[node]);
    }
    for node in 1..parents.len() {
        let (parent, before) = (parents[node], NodeId::from(node - 1));
        assert!(parent <= before && before < ends[parent.index()], "not in preorder: {parents:?}");
    }
    ends
}

/// The children of a node in order.
#[derive(Debug, Clone)]
pub enum Children<'a> {
    /// They stand one behind the other.
    InARow {
        /// Where.
        topology: &'a Topology,
        /// The next one, if it comes before the end.
        next: NodeId,
        /// The first node behind the parent's run.
        end: NodeId,
    },
    /// Something was added or removed below their parent.
    Listed(std::slice::Iter<'a, NodeId>),
}

impl Iterator for Children<'_> {
    type Item = NodeId;

    fn next(&mut self) -> Option<NodeId> {
        match self {
            Self::Listed(listed) => listed.next().copied(),
            Self::InARow { topology, next, end } => {
                let child = (*next < *end).then_some(*next)?;
                *next = topology.shapes[child.index()].end;
                Some(child)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids<const N: usize>(ids: [u32; N]) -> Vec<NodeId> {
        ids.map(NodeId).to_vec()
    }

    /// Root, a node for tasks, and two tasks of three nodes each.
    fn two_tasks() -> Topology {
        let mut topology = Topology::new(ids([0, 0]));
        for place in 0..2 {
            topology.graft(NodeId(1), place, &ids([0, 0, 0]), |_| false);
        }
        topology
    }

    fn below(topology: &Topology, node: u32) -> Vec<u32> {
        topology.nodes_below(NodeId(node)).map(|node| node.0).collect()
    }

    fn children(topology: &Topology, node: u32) -> Vec<u32> {
        topology.children(NodeId(node)).map(|node| node.0).collect()
    }

    #[test]
    fn tasks_come_behind_each_other_and_go() {
        let mut topology = two_tasks();
        assert_eq!(children(&topology, 1), [2, 5]);
        assert_eq!(topology.below(NodeId(1)).count(), 1, "tasks are one run with the node that they are added to");
        topology.remove(NodeId(2));
        assert_eq!((children(&topology, 1), below(&topology, 1)), (vec![5], vec![1, 5, 6, 7]));
        assert!(!topology.has(NodeId(3)) && topology.has(NodeId(6)));
        topology.remove(NodeId(5));
        assert_eq!((children(&topology, 1), below(&topology, 0)), (vec![], vec![0, 1]));
        let third = topology.graft(NodeId(1), usize::MAX, &ids([0]), |_| false);
        assert_eq!((third, topology.next()), (NodeId(8), NodeId(9)), "no id is given twice");
        assert_eq!(topology.parent(third), NodeId(1));
    }

    #[test]
    fn what_is_added_below_a_task_belongs_to_all_above_it() {
        let mut topology = two_tasks();
        // As the first child of the first task, then below that.
        let added = topology.graft(NodeId(2), 0, &ids([0, 0]), |_| false);
        let deeper = topology.graft(added, 1, &ids([0]), |_| false);
        assert_eq!((added, deeper), (NodeId(8), NodeId(10)));
        assert_eq!((children(&topology, 2), children(&topology, 8)), (vec![8, 3, 4], vec![9, 10]));
        assert_eq!(below(&topology, 2), [2, 3, 4, 8, 9, 10]);
        assert_eq!((below(&topology, 5), below(&topology, 4)), (vec![5, 6, 7], vec![4]));
        assert!(topology.is_within(NodeId(10), NodeId(2)) && !topology.is_within(NodeId(10), NodeId(5)));
        let order = [8, 3, 4, 5].map(NodeId);
        for (index, node) in order.iter().enumerate() {
            for (other, another) in order.iter().enumerate().filter(|(other, _)| *other != index) {
                assert_eq!(topology.is_before(*node, *another), index < other, "{node:?} {another:?}");
            }
        }
        assert!(topology.is_before(NodeId(10), NodeId(4)), "what is below comes where its top does");
        topology.remove(NodeId(8));
        assert_eq!((below(&topology, 2), children(&topology, 2)), (vec![2, 3, 4], vec![3, 4]));
        assert_eq!(topology.below(NodeId(2)).count(), 1, "nothing is kept of what is gone");
        topology.remove(NodeId(3));
        assert_eq!((below(&topology, 2), topology.has(NodeId(3))), (vec![2, 4], false));
    }

    #[test]
    fn cleanups_are_found_in_what_is_added() {
        let mut topology = Topology::new(ids([0, 0]));
        let top = topology.graft(NodeId(1), 0, &ids([0, 0, 0]), |node| node == NodeId(2));
        assert_eq!(topology.cleanups().iter().copied().collect::<Vec<_>>(), [NodeId(4)]);
        topology.remove(top);
        assert!(topology.cleanups().is_empty());
    }
}
