//! Trees that live: tasks that come, are held back and go, parts that are added and removed, objects that come into the room.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Phase, State};
use crate::{Change, EntryKind, Granting, Location, NodeEntry, NodeId, ObjectId, PlaceId, TaskEntry, Time};

/// A task of a run that takes work.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Task {
    /// What it is called.
    pub name: String,
    /// How urgent it is.
    pub priority: i32,
    /// When it was submitted, robot time.
    pub since: Time,
    /// How it is granted what it asks for.
    pub granting: Granting,
    /// Since when it is paused, robot time.
    pub paused: Option<Time>,
    /// Where it is given up: until when its cleanups may take, robot time.
    pub canceled: Option<Time>,
    /// Whether nothing of it runs and nothing can.
    pub is_stalled: bool,
}

impl State {
    /// The lowest node above all tasks: root of a mission, its one child in a run that takes work.
    pub fn stem(&self) -> NodeId {
        self.topology.stem()
    }

    /// The task that a node belongs to; none above all tasks.
    pub fn task_of(&self, node: NodeId) -> Option<NodeId> {
        let stem = self.stem();
        self.topology.path(node).take_while(|above| *above > stem).last()
    }

    /// The tasks of a run that takes work, in the order of their coming.
    pub fn tasks(&self) -> &BTreeMap<NodeId, Task> {
        &self.tasks
    }

    /// How all tasks together are granted what they ask for.
    pub fn granting(&self) -> Granting {
        self.granting
    }

    /// Whether nothing of a task is granted: it is held back by itself or with all others, and not to take a step.
    pub fn is_paused(&self, task: NodeId) -> bool {
        let known = self.tasks.get(&task);
        // What is given up is cleaned up.
        if known.is_some_and(|task| task.canceled.is_some()) {
            return false;
        }
        let own = known.map_or(Granting::Freely, |task| task.granting);
        match (own, self.granting) {
            (Granting::Step, _) | (Granting::Freely, Granting::Freely | Granting::Step) => false,
            (Granting::Paused, Granting::Freely | Granting::Paused | Granting::Step) => true,
            (Granting::Freely, Granting::Paused) => true,
        }
    }

    pub(super) fn add(
        &mut self,
        at: Time,
        (top, under, behind): (NodeId, NodeId, u32),
        nodes: &[NodeEntry],
        task: Option<&TaskEntry>,
    ) -> bool {
        let is_place = self.topology.has(under) && top == self.topology.next() && !nodes.is_empty();
        if !is_place || task.is_some() != (under == self.stem() && under.0 > 0) {
            return false;
        }
        let parents: Vec<NodeId> = nodes.iter().map(|entry| entry.parent).collect();
        let has_cleanup = |node: NodeId| nodes[(node.0 - top.0) as usize].kind == EntryKind::Cleanup;
        Arc::make_mut(&mut self.topology).graft(under, behind as usize, &parents, has_cleanup);
        if let Some(TaskEntry { name, priority, granting }) = task {
            let paused = (*granting == Granting::Paused).then_some(at);
            let (name, priority, granting) = (name.clone(), *priority, *granting);
            let task = Task { name, priority, since: at, granting, paused, canceled: None, is_stalled: false };
            Arc::make_mut(&mut self.tasks).insert(top, task);
        }
        true
    }

    /// A part of the tree that neither runs nor holds anything is gone.
    pub(super) fn remove(&mut self, node: NodeId) -> bool {
        let can_go = node > self.stem() && self.topology.has(node) && !self.is_busy(node);
        if can_go {
            let parent = self.topology.parent(node);
            if self.status(parent).way == Some(node) {
                self.status_mut(parent).way = None;
            }
            let topology = Arc::clone(&self.topology);
            topology.below(node).for_each(|run| self.forget_run(run));
            Arc::make_mut(&mut self.topology).remove(node);
        }
        can_go
    }

    /// Whatever is known of some nodes.
    fn forget_run(&mut self, run: Range<NodeId>) {
        self.forget_moments(run.clone());
        self.nodes.forget(run.start.index()..run.end.index());
        forget(&mut self.redone, &run);
        forget(&mut self.left, &run);
        forget(&mut self.iterations, &run);
        forget(&mut self.urged, &run);
        forget(&mut self.interrupted, &run);
        forget(&mut self.infeasible, &run);
        forget(&mut self.unfit, &run);
        for set in [&mut self.overdue, &mut self.cleaning] {
            if set.range(run.clone()).next().is_some() {
                Arc::make_mut(set).retain(|node| !run.contains(node));
            }
        }
    }

    /// A task is gone. What it holds is free, and full grippers are everybody's.
    pub(super) fn end_task(&mut self, task: NodeId) -> bool {
        if !self.tasks.contains_key(&task) {
            return false;
        }
        let (topology, stem) = (Arc::clone(&self.topology), self.stem());
        Arc::make_mut(&mut self.table).free(|holder| holder == stem || topology.is_within(holder, task));
        Arc::make_mut(&mut self.tasks).remove(&task);
        self.remove(task)
    }

    pub(super) fn set_granting(&mut self, at: Time, task: Option<NodeId>, granting: Granting) -> bool {
        let (before, tasks) = (self.paused_tasks(), Arc::make_mut(&mut self.tasks));
        match task {
            None => self.granting = granting,
            Some(id) => match tasks.get_mut(&id) {
                Some(task) => task.granting = granting,
                None => return false,
            },
        }
        let after = self.paused_tasks();
        for task in after.iter().filter(|task| !before.contains(task)) {
            self.hold_time(*task, at);
        }
        for task in before.iter().filter(|task| !after.contains(task)) {
            self.let_time_run(*task, at);
        }
        true
    }

    fn paused_tasks(&self) -> Vec<NodeId> {
        self.tasks.keys().copied().filter(|task| self.is_paused(*task)).collect()
    }

    /// No time of a task that is paused runs.
    fn hold_time(&mut self, task: NodeId, at: Time) {
        Arc::make_mut(&mut self.tasks).get_mut(&task).into_iter().for_each(|task| task.paused = Some(at));
        let timed: Vec<(Time, NodeId)> =
            self.topology.within(task, &self.timed).map(|(node, until)| (*until, node)).collect();
        let deadlines = Arc::make_mut(&mut self.deadlines);
        for deadline in &timed {
            deadlines.remove(deadline);
        }
    }

    fn let_time_run(&mut self, task: NodeId, at: Time) {
        let Some(known) = Arc::make_mut(&mut self.tasks).get_mut(&task) else { return };
        let paused = known.paused.take().map_or_else(Default::default, |since| at.since(since));
        let timed: Vec<(Time, NodeId)> =
            self.topology.within(task, &self.timed).map(|(node, until)| (*until + paused, node)).collect();
        Arc::make_mut(&mut self.timed).extend(timed.iter().map(|(until, node)| (*node, *until)));
        Arc::make_mut(&mut self.deadlines).extend(timed);
    }

    pub(super) fn cancel(&mut self, task: NodeId, until: Time) -> bool {
        let is_known = self.tasks.contains_key(&task);
        if is_known {
            Arc::make_mut(&mut self.tasks).entry(task).and_modify(|task| task.canceled = Some(until));
            self.end_node(task);
        }
        is_known
    }

    /// A task of which something is granted is stalled no more.
    pub(super) fn goes_on_again(&mut self, leaf: NodeId) {
        let Some(task) = self.task_of(leaf).filter(|_| !self.tasks.is_empty()) else { return };
        if self.tasks.get(&task).is_some_and(|task| task.is_stalled) {
            Arc::make_mut(&mut self.tasks).entry(task).and_modify(|task| task.is_stalled = false);
        }
    }

    pub(super) fn stalled(&mut self, stalled: &[NodeId]) -> bool {
        for (task, known) in Arc::make_mut(&mut self.tasks) {
            known.is_stalled = stalled.contains(task);
        }
        stalled.iter().all(|task| self.tasks.contains_key(task))
    }

    pub(super) fn add_object(&mut self, object: ObjectId, place: PlaceId) -> bool {
        let is_next = object.index() == self.world.objects.len();
        if is_next {
            Arc::make_mut(&mut self.world).objects.push(Location::At(place));
            self.progress += 1;
        }
        is_next
    }

    pub(super) fn remove_object(&mut self, object: ObjectId) -> bool {
        let is_there = self.world.objects.get(object.index()).is_some_and(|at| at.holders().is_empty());
        if is_there {
            Arc::make_mut(&mut self.world).apply(Change::Object(object, Location::Unknown));
            self.progress += 1;
        }
        is_there
    }

    /// Whether a task is complete, has failed, or is given up with nothing left to be done of it.
    pub fn is_task_over(&self, task: NodeId) -> bool {
        match self.phase(task) {
            Phase::Done | Phase::Failed => true,
            Phase::Ending => !self.is_busy(task) && self.owed_cleanup(task, None).is_none(),
            Phase::Pending | Phase::Failing(_) | Phase::Cleaning(_) => false,
        }
    }
}

fn forget<T: Clone>(map: &mut Arc<BTreeMap<NodeId, T>>, run: &Range<NodeId>) {
    if map.range(run.clone()).next().is_some() {
        Arc::make_mut(map).retain(|node, _| !run.contains(node));
    }
}
