//! Tasks of a run that takes work, each by itself: how they end, take steps, and stall (`semantics` 6, "Tasks that come and
//! go").

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Down, Effect, Outbox, Root, TOP, Verdict};
use ambidex_model::state::Phase;
use ambidex_model::{Blocked, Granting, MissionEnd, NodeId, Reason, Record, ResourceId, StopCause, Time};

impl Root {
    /// Whether a node is a task as a whole.
    pub(super) fn is_task(&self, node: NodeId) -> bool {
        node.0 > 0 && self.state.topology().parent(node) == self.state.stem()
    }

    /// A task is complete, or has failed at a node. It goes at the end of the turn.
    pub(super) fn note_ended(&mut self, task: NodeId, end: MissionEnd) {
        self.is_wanted = true;
        self.ended.entry(task).or_insert(end);
    }

    /// Tasks that are over are gone: those that ended, those that are satisfied without having run, and those that were
    /// given up once all is cleaned up.
    pub(super) fn end_tasks(&mut self, now: Time, out: &mut Outbox) {
        for task in std::mem::take(&mut self.met) {
            if self.state.phase(task) == Phase::Pending && !self.state.is_busy(task) {
                self.note_ended(task, MissionEnd::Done);
            }
        }
        let given_up = self.state.tasks().iter().filter(|(_, task)| task.canceled.is_some()).map(|(id, _)| *id);
        let over: Vec<NodeId> = given_up.filter(|task| self.is_cleaned_up(*task)).collect();
        over.into_iter().for_each(|task| self.note_ended(task, MissionEnd::Canceled));
        for (task, end) in std::mem::take(&mut self.ended) {
            self.is_wanted = true;
            self.end_task(now, task, end, out);
        }
    }

    /// The run ends: whatever is left of tasks is given up.
    pub(super) fn give_up_tasks(&mut self, now: Time, out: &mut Outbox) {
        let left: Vec<NodeId> = self.state.tasks().keys().copied().collect();
        for task in left {
            let end = self.ended.remove(&task).unwrap_or(MissionEnd::Canceled);
            self.end_task(now, task, end, out);
        }
    }

    fn end_task(&mut self, now: Time, task: NodeId, end: MissionEnd, out: &mut Outbox) {
        self.forget_nodes(task);
        self.edit(Record::TaskEnded { at: now, task, end }, out);
        self.retire(task, out);
    }

    /// Whether nothing of a task that was given up runs, and nothing is left to be cleaned up, or no time for it.
    fn is_cleaned_up(&self, task: NodeId) -> bool {
        let owes = || !self.is_out_of_grace(task) && self.state.owed_cleanup(task, None).is_some();
        !self.state.is_busy(task) && !owes()
    }

    /// Whether all the time is used up that a task has for its cleanups once it is given up.
    pub(super) fn is_out_of_grace(&self, task: NodeId) -> bool {
        let until = self.state.tasks().get(&task).and_then(|task| task.canceled);
        until.is_some_and(|until| until <= self.turned)
    }

    /// Cleanups of tasks whose time for them is over end.
    pub(super) fn stop_late_cleanups(&mut self, now: Time, out: &mut Outbox) {
        let late = |leaf: &NodeId| self.state.task_of(*leaf).is_some_and(|task| self.is_out_of_grace(task));
        let leaves: Vec<NodeId> = match self.state.tasks().is_empty() {
            true => Vec::new(),
            false => self.state.running().keys().copied().filter(late).collect(),
        };
        let stopped = self.stop(now, leaves, StopCause::Ends, out);
        if !stopped.is_empty() {
            out.push(Effect::Down(TOP, Down::Verdict(Arc::new(Verdict::stopping(&self.state, stopped)))));
        }
    }

    /// Whether a behavior might run if a controller came back that is awaited.
    fn is_of_who_is_away(&self, reason: &Reason) -> bool {
        let is_awaited = |id: ResourceId| self.state.table().resource(id).service().is_awaited();
        match *reason.root_cause() {
            Reason::Unavailable { resource, .. } => is_awaited(resource),
            Reason::NoneFree { of } | Reason::TooFew { of, .. } | Reason::NothingAvailable { of } => {
                self.mission.robot.of_type(of).any(is_awaited)
            }
            Reason::Unfit { .. } => self.state.table().iter().any(|(_, resource)| resource.service().is_awaited()),
            Reason::Satisfied
            | Reason::Held { .. }
            | Reason::Missing { .. }
            | Reason::OutOfReach { .. }
            | Reason::OutOfReachLater { .. }
            | Reason::Unreachable { .. }
            | Reason::NoSpot { .. }
            | Reason::NotHeld { .. }
            | Reason::Misheld(_)
            | Reason::Taken { .. }
            | Reason::Elsewhere { .. }
            | Reason::Nowhere { .. }
            | Reason::NotAt { .. }
            | Reason::NoPath { .. }
            | Reason::InTheWay { .. }
            | Reason::PathNotFound { .. }
            | Reason::Fact { .. }
            | Reason::Driving { .. }
            | Reason::BackingOff { .. }
            | Reason::Unwanted
            | Reason::AlreadyDone { .. }
            | Reason::Outbid { .. }
            | Reason::Outdone { .. }
            | Reason::LessUrgent { .. }
            | Reason::DoneOftener { .. }
            | Reason::SameObject { .. }
            | Reason::Clash { .. }
            | Reason::Alternative { .. }
            | Reason::WholeRobot { .. }
            | Reason::WouldDeadlock { .. }
            | Reason::NotItsTurn { .. }
            | Reason::Ending { .. }
            | Reason::Reserved { .. }
            | Reason::TooEarly { .. }
            | Reason::NotYet { .. }
            | Reason::GivenUp { .. }
            | Reason::OutOfTime { .. } => false,
        }
    }

    /// The next moment at which a task that was given up has had its time.
    pub(super) fn next_grace(&self) -> Option<Time> {
        let graces = self.state.tasks().values().filter_map(|task| task.canceled);
        graces.filter(|until| *until > self.turned).min()
    }

    /// Tasks that were to take a step and have, are paused again.
    pub(super) fn end_steps(&mut self, now: Time, granted: &BTreeSet<NodeId>, out: &mut Outbox) {
        let steps = |task: &NodeId| self.state.tasks().get(task).is_some_and(|task| task.granting == Granting::Step);
        let mut stepped: Vec<Option<NodeId>> = granted.iter().copied().filter(steps).map(Some).collect();
        if self.state.granting() == Granting::Step && !granted.is_empty() {
            stepped.push(None);
        }
        for task in stepped {
            self.edit(Record::Granting { at: now, task, granting: Granting::Paused }, out);
        }
    }

    /// The tasks that might have come to a stall in this round: nothing of them runs or was granted.
    pub(super) fn idle_tasks(&self, touched: Option<&[NodeId]>) -> BTreeSet<NodeId> {
        let tasks = self.state.tasks();
        let is_idle = |task: &NodeId| self.is_idle(*task);
        match touched {
            None => tasks.keys().copied().filter(is_idle).collect(),
            Some(touched) => touched.iter().copied().filter(|node| tasks.contains_key(node)).filter(is_idle).collect(),
        }
    }

    /// Whether nothing of a task runs, or waits for a moment that will come, and it is not held back.
    fn is_idle(&self, task: NodeId) -> bool {
        let (state, topology) = (&self.state, self.state.topology());
        let is_of_it = |node: &NodeId| topology.is_within(*node, task);
        !state.is_busy(task)
            && !state.is_paused(task)
            && !self.ended.contains_key(&task)
            && !state.waits().iter().any(|(_, node)| is_of_it(node))
            && topology.within(task, state.pauses()).next().is_none()
    }

    /// Judges tasks of which nothing goes on: what can be tried otherwise is, and else they stall.
    pub(super) fn stall_tasks(&mut self, now: Time, tasks: &BTreeSet<NodeId>, out: &mut Outbox) {
        let nobody_runs = self.state.running().is_empty();
        let before: BTreeSet<NodeId> =
            self.state.tasks().iter().filter(|(_, task)| task.is_stalled).map(|(id, _)| *id).collect();
        let mut stalled = before.clone();
        stalled.retain(|task| self.is_idle(*task));
        for &task in tasks {
            stalled.remove(&task);
            // Whoever waits for what others use has only to wait.
            let waits = !nobody_runs && self.reasons.waits(task);
            let waits = waits || !self.lacks_of_others(Some(task)).is_empty();
            if !waits && self.is_idle(task) && !self.try_otherwise(now, task, out) {
                stalled.insert(task);
            }
        }
        if before != stalled {
            let (tree, topology) = (&self.mission.tree, self.state.topology());
            let said = stalled.difference(&before).flat_map(|task| topology.within(*task, &self.reasons));
            let said = said.filter(|(node, _)| tree.behavior(*node).is_some());
            let blocked = said.map(|(leaf, reason)| Blocked { leaf, reason: reason.clone() }).collect();
            self.edit(Record::Stalled { at: now, tasks: stalled.into_iter().collect(), blocked }, out);
        }
    }

    /// What is left to a task of which nothing goes on: a cleanup that cannot be granted is over, a controller that is away
    /// is awaited, an OR leaves its way.
    fn try_otherwise(&mut self, now: Time, task: NodeId, out: &mut Outbox) -> bool {
        let cleaning = self.state.topology().of_set(task, self.state.cleaning()).next();
        if let Some(node) = cleaning {
            self.end_cleanup(now, node, false, out);
            return true;
        }
        let reasons = || self.state.topology().within(task, &self.reasons);
        let is_away = reasons().any(|(_, reason)| self.is_of_who_is_away(reason));
        if is_away {
            self.await_controllers(now, out);
            return true;
        }
        if let Some((or, way)) = self.way_to_leave(Some(task)) {
            self.leave_way(now, or, way, out);
            return true;
        }
        false
    }
}
