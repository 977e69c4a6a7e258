//! What every node is: leaves as the records tell, composites as their leaves and the records' consequences say.

use std::ops::Range;
use std::sync::Arc;

use ambidex_model::state::{Phase as StatePhase, State};
use ambidex_model::{Consequences, EntryKind, Header, MissionEnd, NodeEntry, NodeId, NodeRange, Runs, Time, Topology};

use super::leaf::{LeafHistory, LeafState, Phase};

/// What every node is at a moment.
#[derive(Debug, Clone)]
pub(super) struct LeafStates {
    pub(super) topology: Arc<Topology>,
    pub(super) nodes: Runs<Node>,
    pub(super) leaves: Runs<LeafHistory>,
    entered: u64,
    keeps_past: bool,
    is_over: bool,
}

/// A node as its leaves make it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) kind: Kind,
    pub(super) counts: Counts,
    children: u32,
    done_children: u32,
    is_complete: bool,
    pub(super) is_failed: bool,
    pub(super) has_run: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Leaf,
    /// Done when one child is.
    Or,
    /// Done when its first child is; the other one is its cleanup.
    Body,
    /// Done never: its children come and go.
    Tasks,
    /// Done when all children are, in order or not.
    All {
        is_ordered: bool,
    },
}

/// How many leaves at or below a node there are, and what they are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// All of them, whatever they are.
    pub of: usize,
    /// Done, skipped ones included.
    pub done: usize,
    /// Done without having run.
    pub skipped: usize,
    /// Granted and not released.
    pub active: usize,
    /// Told to end when they ran last.
    pub canceled: usize,
    /// Not to run any more since a node above failed.
    pub not_asked: usize,
    /// Not to run any more since a node above is done without it.
    pub not_needed: usize,
}

impl Counts {
    /// These are gone.
    fn lose(&mut self, gone: Self) {
        let Self { of, done, skipped, active, canceled, not_asked, not_needed } = self;
        let numbers = [
            (of, gone.of),
            (done, gone.done),
            (skipped, gone.skipped),
            (active, gone.active),
            (canceled, gone.canceled),
            (not_asked, gone.not_asked),
            (not_needed, gone.not_needed),
        ];
        numbers.into_iter().for_each(|(number, gone)| *number = number.saturating_sub(gone));
    }

    fn count(&mut self, state: LeafState, change: isize) {
        let numbers: &mut [&mut usize] = match state {
            LeafState::Waiting | LeafState::Failed => &mut [],
            LeafState::Active => &mut [&mut self.active],
            LeafState::Done => &mut [&mut self.done],
            LeafState::Skipped => &mut [&mut self.done, &mut self.skipped],
            LeafState::Canceled => &mut [&mut self.canceled],
            LeafState::NotAsked => &mut [&mut self.not_asked],
            LeafState::NotNeeded => &mut [&mut self.not_needed],
        };
        numbers.iter_mut().for_each(|number| **number = number.saturating_add_signed(change));
    }
}

impl Node {
    fn new(kind: &EntryKind) -> Self {
        Self {
            kind: match kind {
                EntryKind::Behavior(_) => Kind::Leaf,
                EntryKind::Or => Kind::Or,
                EntryKind::Cleanup => Kind::Body,
                EntryKind::Tasks => Kind::Tasks,
                EntryKind::Then => Kind::All { is_ordered: true },
                EntryKind::Root | EntryKind::And => Kind::All { is_ordered: false },
            },
            counts: Counts { of: usize::from(kind.is_behavior()), ..Counts::default() },
            children: 0,
            done_children: 0,
            is_complete: false,
            is_failed: false,
            has_run: false,
        }
    }
}

impl LeafStates {
    pub(super) fn new(header: &Header, keeps_past: bool) -> Self {
        Self::of(&header.nodes, Arc::new(header.topology()), keeps_past)
    }

    fn of(entries: &Runs<NodeEntry>, topology: Arc<Topology>, keeps_past: bool) -> Self {
        let mut nodes = entries.map(|entry| Node::new(&entry.kind));
        // What is below a node has a greater id.
        for node in topology.nodes().rev().filter(|node| node.0 > 0) {
            let of = nodes[node.index()].counts.of;
            let parent = &mut nodes[topology.parent(node).index()];
            parent.children += 1;
            // A cleanup is no part of what is to be done.
            parent.counts.of += if topology.is_cleanup(node) { 0 } else { of };
        }
        let mut leaves = entries.map(|_| LeafHistory::default());
        for node in topology.cleanups().iter().flat_map(|cleanup| topology.nodes_below(*cleanup)) {
            leaves[node.index()].enter(Time::ZERO, Phase::NotNeeded, 0, keeps_past);
        }
        Self { topology, nodes, leaves, entered: 0, keeps_past, is_over: false }
    }

    /// What nodes are in a state of which nothing is told of how it came to be.
    pub(super) fn restored(entries: &Runs<NodeEntry>, state: &State, at: Time, keeps_past: bool) -> Self {
        let mut states = Self::of(entries, Arc::clone(state.topology()), keeps_past);
        let topology = Arc::clone(&states.topology);
        for node in topology.nodes() {
            let (is_done, is_failed) = (state.is_done(node), state.phase(node) == StatePhase::Failed);
            let phase = match (state.running().contains_key(&node), is_done, state.infeasible().contains_key(&node)) {
                (true, _, _) => Some(Phase::Active),
                (false, true, _) => Some(Phase::Done),
                (false, false, true) => Some(Phase::Infeasible),
                (false, false, false) => is_failed.then_some(Phase::NotAsked),
            };
            phase.into_iter().for_each(|phase| states.enter(node, at, phase));
            let was_done = states.is_done(node);
            let entry = &mut states.nodes[node.index()];
            (entry.is_complete, entry.is_failed) = (is_done, is_failed);
            states.tell_parent(node, was_done);
        }
        states
    }

    /// A part of the tree is there from now on.
    pub(super) fn add(&mut self, top: NodeId, under: NodeId, behind: usize, entries: &[NodeEntry]) {
        let parents: Vec<NodeId> = entries.iter().map(|entry| entry.parent).collect();
        let has_cleanup = |node: NodeId| entries[(node.0 - top.0) as usize].kind == EntryKind::Cleanup;
        Arc::make_mut(&mut self.topology).graft(under, behind, &parents, has_cleanup);
        let mut nodes: Vec<Node> = entries.iter().map(|entry| Node::new(&entry.kind)).collect();
        for index in (1..nodes.len()).rev() {
            let of = nodes[index].counts.of;
            let parent = &mut nodes[parents[index].index()];
            parent.children += 1;
            parent.counts.of += if self.topology.is_cleanup(NodeId(top.0 + index as u32)) { 0 } else { of };
        }
        let was_done = self.is_done(under);
        let of = nodes[0].counts.of;
        self.nodes.add(top.index(), nodes);
        self.leaves.add(top.index(), vec![LeafHistory::default(); entries.len()]);
        self.nodes[under.index()].children += 1;
        self.count_above(top, of as isize);
        self.tell_parent(under, was_done);
        let cleanups: Vec<NodeId> = self.topology.of_set(top, self.topology.cleanups()).collect();
        let topology = Arc::clone(&self.topology);
        for node in cleanups.into_iter().flat_map(|cleanup| topology.nodes_below(cleanup)) {
            self.enter(node, Time::ZERO, Phase::NotNeeded);
        }
    }

    /// A part that comes or goes has so many leaves.
    fn count_above(&mut self, top: NodeId, more: isize) {
        let topology = Arc::clone(&self.topology);
        for node in topology.path(top).take_while(|node| !topology.is_cleanup(*node)).skip(1) {
            let of = &mut self.nodes[node.index()].counts.of;
            *of = of.saturating_add_signed(more);
        }
    }

    /// Nothing of a task, or of another part of the tree, goes on.
    pub(super) fn close(&mut self, node: NodeId, at: Time, end: Option<MissionEnd>) {
        let phase = if end == Some(MissionEnd::Done) { Phase::NotNeeded } else { Phase::NotAsked };
        self.enter_all(node, at, LeafState::Waiting, phase, |_, _| true);
        if self.nodes[node.index()].kind != Kind::Leaf {
            let was_done = self.is_done(node);
            let entry = &mut self.nodes[node.index()];
            entry.is_complete |= end == Some(MissionEnd::Done);
            entry.is_failed |= matches!(end, Some(MissionEnd::Failed(_) | MissionEnd::ControllerLost(_)));
            self.tell_parent(node, was_done);
        }
    }

    /// A part of the tree is gone; gives its ids.
    pub(super) fn remove(&mut self, node: NodeId) -> Vec<Range<NodeId>> {
        let parent = self.topology.parent(node);
        let (counts, is_done, was_done) = (self.nodes[node.index()].counts, self.is_done(node), self.is_done(parent));
        let entry = &mut self.nodes[parent.index()];
        entry.children = entry.children.saturating_sub(1);
        entry.done_children = entry.done_children.saturating_sub(u32::from(is_done));
        let topology = Arc::clone(&self.topology);
        for above in topology.path(node).take_while(|node| !topology.is_cleanup(*node)).skip(1) {
            self.nodes[above.index()].counts.lose(counts);
        }
        self.tell_parent(parent, was_done);
        let runs: Vec<Range<NodeId>> = topology.below(node).collect();
        for run in &runs {
            self.nodes.remove(run.start.index()..run.end.index());
            self.leaves.remove(run.start.index()..run.end.index());
        }
        Arc::make_mut(&mut self.topology).remove(node);
        runs
    }

    /// The same without the past.
    pub(super) fn present(&self) -> Self {
        let leaf = |leaf: &LeafHistory| LeafHistory { phases: Vec::new(), ..leaf.clone() };
        Self { leaves: self.leaves.map(leaf), keeps_past: false, ..self.clone() }
    }

    pub(super) fn leaf(&self, leaf: NodeId) -> Option<&LeafHistory> {
        self.leaves.get(leaf.index()).filter(|_| self.nodes[leaf.index()].kind == Kind::Leaf)
    }

    pub(super) fn leaf_mut(&mut self, leaf: NodeId) -> Option<&mut LeafHistory> {
        self.leaves.get_mut(leaf.index()).filter(|_| self.nodes[leaf.index()].kind == Kind::Leaf)
    }

    pub(super) fn counts(&self, node: NodeId) -> Counts {
        self.nodes.get(node.index()).map_or(Counts::default(), |node| node.counts)
    }

    /// What any node is.
    pub(super) fn state(&self, node: NodeId) -> LeafState {
        if let Some(leaf) = self.leaf(node) {
            return leaf.state();
        }
        let Some(Node { counts, is_failed, .. }) = self.nodes.get(node.index()) else {
            return LeafState::Waiting;
        };
        match *counts {
            _ if *is_failed => LeafState::Failed,
            Counts { active: 1.., .. } => LeafState::Active,
            Counts { of: 1.., done, skipped, .. } if self.is_done(node) && done == skipped => LeafState::Skipped,
            Counts { of: 1.., .. } if self.is_done(node) => LeafState::Done,
            Counts { canceled: 1.., .. } if self.is_over => LeafState::Canceled,
            Counts { of: of @ 1.., not_needed, .. } if of == not_needed => LeafState::NotNeeded,
            Counts { of: of @ 1.., not_asked, not_needed, .. } if of == not_asked + not_needed => LeafState::NotAsked,
            Counts { .. } => LeafState::Waiting,
        }
    }

    /// From now on a leaf is something else; what is above it may be, too.
    pub(super) fn enter(&mut self, leaf: NodeId, at: Time, phase: Phase) {
        let Some(before) = self.leaf(leaf).map(LeafHistory::state) else { return };
        let was_done = self.is_done(leaf);
        self.entered += 1;
        self.leaves[leaf.index()].enter(at, phase, self.entered, self.keeps_past);
        for node in self.path(leaf).collect::<Vec<_>>() {
            let is_cleanup = self.topology.is_cleanup(node);
            let node = &mut self.nodes[node.index()];
            node.counts.count(before, -1);
            node.counts.count(phase.state(), 1);
            node.has_run |= phase == Phase::Active;
            if is_cleanup {
                break;
            }
        }
        self.tell_parent(leaf, was_done);
    }

    /// What the end of a leaf means for the nodes above it, and for what is then not to run any more.
    pub(super) fn settle(&mut self, leaf: NodeId, at: Time, consequences: Consequences) {
        if let Some(completed) = consequences.completed {
            self.mark(leaf, completed.node, |node| node.is_complete = true);
            self.enter_all(completed.node, at, LeafState::Waiting, Phase::NotNeeded, |_, _| true);
        }
        if let Some(failed) = consequences.failed {
            self.mark(leaf, failed, |node| node.is_failed = true);
            self.enter_all(failed, at, LeafState::Waiting, Phase::NotAsked, |_, _| true);
        }
    }

    /// A leaf is done without having run; an OR above it may need its other ways no more.
    pub(super) fn skip(&mut self, leaf: NodeId, at: Time) {
        self.enter(leaf, at, Phase::Skipped);
        for node in self.path(leaf).collect::<Vec<_>>() {
            if self.nodes[node.index()].kind == Kind::Or && self.is_done(node) {
                self.nodes[node.index()].is_complete = true;
                self.enter_all(node, at, LeafState::Waiting, Phase::NotNeeded, |_, _| true);
            }
        }
    }

    /// A leaf is done no more, nor is what is above it; what was not asked for that reason may be asked again.
    pub(super) fn reopen(&mut self, leaf: NodeId, at: Time) {
        let mut top = None;
        for node in self.path(leaf).collect::<Vec<_>>() {
            if self.nodes[node.index()].is_complete {
                top = Some(node);
                let was_done = self.is_done(node);
                self.nodes[node.index()].is_complete = false;
                self.tell_parent(node, was_done);
            }
        }
        self.enter(leaf, at, Phase::Reopened);
        let is_open = |states: &Self, leaf| {
            let is_settled =
                |node: NodeId| states.nodes[node.index()].is_complete || states.nodes[node.index()].is_failed;
            !states.path(leaf).any(is_settled)
        };
        if let Some(top) = top {
            self.enter_all(top, at, LeafState::NotNeeded, Phase::Waiting, is_open);
        }
    }

    /// What begins anew is neither done nor has it failed.
    pub(super) fn begin_again(&mut self, nodes: &[NodeId], at: Time, phase: Phase) {
        let known = |node: &NodeId| self.topology.has(*node);
        let Some(top) = nodes.first().copied() else { return };
        for node in nodes.iter().copied().filter(known).collect::<Vec<_>>().into_iter().rev() {
            let was_done = self.is_done(node);
            let entry = &mut self.nodes[node.index()];
            (entry.is_complete, entry.is_failed) = (false, false);
            self.tell_parent(node, was_done);
            // A cleanup below it is not asked for that.
            let is_asked = !self.path(node).take_while(|above| *above != top).any(|at| self.topology.is_cleanup(at));
            let is_left = |leaf: &LeafHistory| leaf.phase != Phase::Waiting && is_asked;
            if self.leaf(node).is_some_and(is_left) {
                self.enter(node, at, phase);
            }
        }
    }

    /// A cleanup is asked from now on.
    pub(super) fn begin_cleanup(&mut self, node: NodeId, at: Time) {
        let Some(below) = self.cleanup_of(node) else { return };
        for node in below {
            let entry = &mut self.nodes[node.index()];
            (entry.is_complete, entry.is_failed, entry.done_children) = (false, false, 0);
            self.enter(node, at, Phase::Waiting);
        }
    }

    /// A cleanup is asked no more.
    pub(super) fn end_cleanup(&mut self, node: NodeId, at: Time) {
        let Some(below) = self.cleanup_of(node) else { return };
        for node in below {
            if self.leaf(node).is_some_and(|leaf| leaf.state() == LeafState::Waiting) {
                self.enter(node, at, Phase::NotNeeded);
            }
        }
    }

    fn cleanup_of(&self, node: NodeId) -> Option<Vec<NodeId>> {
        let last = self.topology.has(node).then(|| self.topology.children(node).last()).flatten()?;
        self.topology.is_cleanup(last).then(|| self.topology.nodes_below(last).collect())
    }

    /// What an OR leaves is not gone on with, but for what is done.
    pub(super) fn leave(&mut self, way: NodeId, at: Time) {
        self.enter_all(way, at, LeafState::Waiting, Phase::Left, |_, _| true);
    }

    /// Leaves that are passed over since others did what they were to do.
    pub(super) fn overtake(&mut self, skip: NodeRange, at: Time) {
        for leaf in skip.nodes(self.nodes.len()) {
            if self.leaf(leaf).is_some_and(|leaf| leaf.state().is_open()) {
                self.enter(leaf, at, Phase::Overtaken);
            }
        }
    }

    /// The task is complete, whatever was left of it.
    pub(super) fn complete(&mut self, at: Time) {
        self.nodes.iter_mut().take(2).for_each(|node| node.is_complete = true);
        self.enter_all(NodeId(0), at, LeafState::Waiting, Phase::NotNeeded, |_, _| true);
    }

    /// The task has failed, though some of it may have been finished.
    pub(super) fn fail(&mut self) {
        self.nodes.iter_mut().skip(1).take(1).filter(|top| top.kind != Kind::Leaf).for_each(|top| top.is_failed = true);
    }

    /// Nothing is tried again.
    pub(super) fn end(&mut self) {
        self.is_over = true;
        self.leaves.iter_mut().for_each(LeafHistory::give_up);
    }

    pub(super) fn is_done(&self, node: NodeId) -> bool {
        let Node { kind, children, done_children, is_complete, .. } = self.nodes[node.index()];
        match kind {
            Kind::Leaf => self.leaves[node.index()].state().is_done(),
            Kind::Or => is_complete || done_children > 0,
            Kind::Body => {
                let mut children = self.topology.children(node);
                is_complete || children.next().is_some_and(|body| self.is_done(body))
            }
            Kind::Tasks => is_complete,
            Kind::All { .. } => is_complete || done_children == children,
        }
    }

    /// A node and all above it; nothing of a node that the header does not have.
    pub(super) fn path(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        let known = Some(node).filter(|node| self.topology.has(*node));
        known.into_iter().flat_map(|node| self.topology.path(node))
    }

    /// Marks what is above a leaf up to a node.
    fn mark(&mut self, leaf: NodeId, top: NodeId, mark: impl Fn(&mut Node)) {
        let is_task = |node: &NodeId| self.nodes[node.index()].kind != Kind::Leaf;
        for node in self.path(leaf).filter(is_task).take_while(|node| *node >= top).collect::<Vec<_>>() {
            let was_done = self.is_done(node);
            mark(&mut self.nodes[node.index()]);
            self.tell_parent(node, was_done);
        }
    }

    /// Counts a node that is done now or no more, with whatever that makes of the nodes above.
    fn tell_parent(&mut self, mut node: NodeId, mut was_done: bool) {
        while node.0 > 0 && self.is_done(node) != was_done {
            let parent = self.topology.parent(node);
            let (is_done, was_parent_done) = (self.is_done(node), self.is_done(parent));
            let count = &mut self.nodes[parent.index()].done_children;
            *count = if is_done { *count + 1 } else { count.saturating_sub(1) };
            (node, was_done) = (parent, was_parent_done);
        }
    }

    /// Whatever below a node is in a state enters a phase.
    fn enter_all(
        &mut self,
        top: NodeId,
        at: Time,
        from: LeafState,
        to: Phase,
        is_meant: impl Fn(&Self, NodeId) -> bool,
    ) {
        let topology = Arc::clone(&self.topology);
        let below = Some(top).filter(|top| topology.has(*top)).into_iter().flat_map(|top| topology.nodes_below(top));
        for leaf in below {
            if self.leaf(leaf).is_some_and(|leaf| leaf.state() == from) && is_meant(self, leaf) {
                self.enter(leaf, at, to);
            }
        }
    }
}
