//! How records change the state: the one place where anything of it is written.

use std::sync::Arc;

use super::{Bar, Phase, Redone, Stage, State, Status, Unfit, Wait};
use crate::{
    Cause, Change, Consequences, Deadline, End, Failing, Grant, Heir, Kept, MissionEnd, NodeId, NodeRange, Reason,
    Record, Reopened, ResourceId, Service, StopCause, WorldState,
};

impl State {
    /// Takes the next record; those that say nothing of the state are passed over. False if it contradicts the state,
    /// as a grant of what somebody else holds: then whatever contradicts is passed over too.
    pub fn apply(&mut self, record: &Record) -> bool {
        match record {
            Record::Began { world_state, .. } => self.begin(world_state),
            Record::Observed { change, .. } => self.change_world(&[*change]),
            Record::World { change, .. } => self.change(&[*change]),
            Record::Decided { .. } => self.decided(record),
            Record::Reopened { reopened, .. } => self.reopen(reopened),
            Record::Infeasible { leaf, reason, consequences, .. } => self.give_up(*leaf, reason, *consequences),
            Record::TimedOut { node, consequences, .. } => self.time_out(*node, *consequences),
            Record::Overtaken { leaf, skips, goal, consequences, .. } => {
                self.overtake(*leaf, skips, *goal, *consequences)
            }
            Record::Stopped { leaves, cause, .. } => each(leaves, |leaf| self.stop(*leaf, cause)),
            Record::Ending { end, until, .. } => {
                self.ending = Some((*end, *until));
                self.end_node(TOP)
            }
            Record::Leaving { way, .. } => self.end_node(*way),
            Record::Cleaning { node, .. } => self.begin_cleaning(*node),
            Record::Cleaned { node, consequences, .. } => self.cleaned(*node, *consequences),
            Record::Released { at, leaf, end, consequences, changes, waits_until, unfit } => {
                let is_known = self.release(*leaf, *end, *consequences, changes);
                if is_known && !unfit.is_empty() {
                    self.find_unfit(*leaf, unfit);
                }
                if let (true, End::Failed(fault), Some(until)) = (is_known, end, waits_until) {
                    self.wait(*leaf, Wait { since: *at, until: *until, fault: *fault });
                }
                is_known
            }
            Record::Woke { leaves, .. } => each(leaves, |leaf| self.wake(*leaf)),
            Record::Served { resources, service, .. } => {
                (self.is_awaiting, self.awaited_until) = (false, None);
                each(resources, |resource| self.serve(*resource, *service))
            }
            Record::Awaited { until, facts, places, .. } => self.awaits(*until, facts, places),
            Record::Ended { end, .. } => {
                self.finish(*end);
                true
            }
            Record::Added { at, top, under, behind, nodes, task, .. } => {
                self.add(*at, (*top, *under, *behind), nodes, task.as_ref())
            }
            Record::Removed { node, .. } => self.remove(*node),
            Record::Granting { at, task, granting } => self.set_granting(*at, *task, *granting),
            Record::Canceled { task, until, .. } => self.cancel(*task, *until),
            Record::TaskEnded { task, .. } => self.end_task(*task),
            Record::Stalled { tasks, .. } => self.stalled(tasks),
            Record::ObjectAdded { object, place, .. } => self.add_object(*object, *place),
            Record::ObjectRemoved { object, .. } => self.remove_object(*object),
            Record::Denied { .. } | Record::Declined { .. } | Record::Checkpoint { .. } => true,
            Record::Header(_)
            | Record::Told { .. }
            | Record::Turn { .. }
            | Record::Sent { .. }
            | Record::Resource { .. }
            | Record::Controller { .. } => true,
        }
    }

    fn begin(&mut self, world_state: &WorldState) -> bool {
        let is_of_this_world =
            world_state.objects.len() == self.world.objects.len() && world_state.facts.len() == self.world.facts.len();
        if is_of_this_world {
            self.world = Arc::new(world_state.clone());
            self.stage = Stage::Running;
        }
        is_of_this_world
    }

    fn stop(&mut self, leaf: NodeId, cause: &StopCause) -> bool {
        let is_running = self.running.contains_key(&leaf);
        if is_running {
            self.status_mut(leaf).is_stopping = true;
            if cause.interrupts() {
                Arc::make_mut(&mut self.interrupted).insert(leaf, cause.clone());
            }
        }
        is_running
    }

    pub(super) fn wait(&mut self, node: NodeId, wait: Wait) {
        self.wake(node);
        Arc::make_mut(&mut self.waits).insert((wait.until, node));
        self.status_mut(node).wait = Some(Box::new(wait));
    }

    /// The time of a task node runs, unless it does already.
    pub(super) fn begin_time(&mut self, Deadline { node, until }: Deadline) -> bool {
        let is_known = self.topology.has(node);
        if is_known && !self.timed.contains_key(&node) {
            Arc::make_mut(&mut self.timed).insert(node, until);
            Arc::make_mut(&mut self.deadlines).insert((until, node));
        }
        is_known
    }

    pub(super) fn end_time(&mut self, node: NodeId) {
        if let Some(until) = self.timed.get(&node).copied() {
            Arc::make_mut(&mut self.timed).remove(&node);
            Arc::make_mut(&mut self.deadlines).remove(&(until, node));
        }
    }

    /// No time runs below a node any more, but in cleanups, which go on.
    pub(super) fn end_times_of_body(&mut self, node: NodeId) {
        let topology = Arc::clone(&self.topology);
        let in_cleanup =
            |timed| topology.path(timed).take_while(|above| *above > node).any(|at| topology.is_cleanup(at));
        let timed = topology.within(node, &self.timed).map(|(timed, _)| timed);
        let of_body: Vec<NodeId> = timed.filter(|timed| !in_cleanup(*timed)).collect();
        of_body.into_iter().for_each(|timed| self.end_time(timed));
    }

    pub(super) fn end_times(&mut self, nodes: std::ops::Range<NodeId>) {
        let timed: Vec<NodeId> = self.timed.range(nodes).map(|(&node, _)| node).collect();
        timed.into_iter().for_each(|node| self.end_time(node));
    }

    fn find_unfit(&mut self, leaf: NodeId, found: &[ResourceId]) {
        let mut resources = [self.unfit(leaf), found].concat();
        resources.sort_unstable();
        resources.dedup();
        let unfit = Unfit { progress: self.progress, resources };
        Arc::make_mut(&mut self.unfit).insert(leaf, unfit);
    }

    /// It waits no longer.
    pub(super) fn wake(&mut self, leaf: NodeId) -> bool {
        if !self.topology.has(leaf) {
            return false;
        }
        if self.pauses.contains_key(&leaf) {
            Arc::make_mut(&mut self.pauses).remove(&leaf);
            return true;
        }
        let wait = self.status(leaf).wait.as_ref().map(|wait| wait.until);
        let Some(until) = wait else { return false };
        Arc::make_mut(&mut self.waits).remove(&(until, leaf));
        self.status_mut(leaf).wait = None;
        true
    }

    fn serve(&mut self, resource: ResourceId, service: Service) -> bool {
        let is_known = resource.index() < self.table.count();
        if is_known {
            Arc::make_mut(&mut self.table).serve(resource, service);
        }
        is_known
    }

    pub(super) fn status_mut(&mut self, node: NodeId) -> &mut Status {
        self.nodes.get_mut(node.index())
    }

    /// What was skipped is done, the way to the behavior is chosen, and its leases move to it.
    pub(super) fn grant(&mut self, grant: &Grant) -> bool {
        if !self.can_grant(grant) {
            return false;
        }
        let topology = Arc::clone(&self.topology);
        let leaf = grant.leaf();
        for skip in &grant.request.skips {
            self.skip(*skip);
        }
        Arc::make_mut(&mut self.table).take(&topology, grant);
        Arc::make_mut(&mut self.running).insert(leaf, grant.clone());
        self.goes_on_again(leaf);
        let status = self.status_mut(leaf);
        (status.bar, status.is_stopping) = (None, false);
        let mut child = leaf;
        for parent in topology.path(leaf).skip(1) {
            let status = self.status(parent);
            if status.way != Some(child) || !status.is_begun {
                let status = self.status_mut(parent);
                (status.way, status.is_begun) = (Some(child), true);
            }
            child = parent;
        }
        true
    }

    /// What was skipped is done.
    fn skip(&mut self, skip: NodeRange) {
        let topology = Arc::clone(&self.topology);
        let then = topology.parent(skip.from);
        for child in topology.children(then).filter(|child| skip.contains(*child)) {
            self.status_mut(child).phase = Phase::Done;
        }
        self.forget_needs(skip.from..skip.to);
        self.forget_moments(skip.from..skip.to);
    }

    /// What is done or has failed waits for nothing more.
    pub(super) fn forget_moments(&mut self, nodes: std::ops::Range<NodeId>) {
        let waits = self.waits.iter().map(|(_, node)| *node).filter(|node| nodes.contains(node));
        let pauses = self.pauses.range(nodes.clone()).map(|(&node, _)| node);
        let waiting: Vec<NodeId> = waits.chain(pauses).collect();
        each(&waiting, |node| self.wake(*node));
        self.end_times(nodes);
    }

    /// Nothing at or below a node is needed, or waits for anything more.
    pub(super) fn forget_below(&mut self, top: NodeId) {
        let topology = Arc::clone(&self.topology);
        for run in topology.below(top) {
            self.forget_needs(run.clone());
            self.forget_moments(run);
        }
    }

    /// Behaviors that were sent back are done again, or will not be.
    pub(super) fn forget_needs(&mut self, nodes: std::ops::Range<NodeId>) {
        let needed = |redone: &Redone| redone.leaf.is_some();
        let sent: Vec<NodeId> =
            self.redone.range(nodes).filter(|(_, redone)| needed(redone)).map(|(&leaf, _)| leaf).collect();
        for leaf in sent {
            if let Some(redone) = Arc::make_mut(&mut self.redone).get_mut(&leaf) {
                redone.leaf = None;
            }
        }
    }

    pub(super) fn reopen(&mut self, reopened: &Reopened) -> bool {
        if !self.can_reopen(reopened) {
            return false;
        }
        let progress = self.progress;
        match reopened.cause {
            Cause::Lapse { .. } | Cause::Redo { .. } => {}
            Cause::Leave => {
                self.leave(reopened.node, reopened.up_to);
                return true;
            }
            Cause::Retry { fault, since, until } => {
                self.try_again(reopened, Wait { since, until, fault });
                return true;
            }
            Cause::Repeat { since, until } => {
                self.repeat(reopened, since, until);
                return true;
            }
            Cause::Yield => {
                self.end_intentions(&reopened.ended);
                return true;
            }
        }
        let path: Vec<NodeId> = self.topology.path(reopened.node).take_while(|node| *node != reopened.up_to).collect();
        for node in path {
            self.status_mut(node).phase = Phase::Pending;
        }
        for or in &reopened.undecided {
            self.status_mut(*or).way = None;
        }
        if let Cause::Redo { leaf } = reopened.cause {
            self.send_back(reopened, leaf);
        }
        self.status_mut(reopened.node).bar = match &reopened.cause {
            Cause::Lapse { heir, .. } => Some(Box::new(Bar { progress, heir: (**heir).clone() })),
            Cause::Redo { .. } | Cause::Leave | Cause::Retry { .. } | Cause::Repeat { .. } | Cause::Yield => None,
        };
        if let Cause::Lapse { resource, .. } = reopened.cause {
            Arc::make_mut(&mut self.table).lapse(resource, reopened.up_to);
        }
        true
    }

    /// A behavior fails without having run.
    fn give_up(&mut self, leaf: NodeId, reason: &Reason, consequences: Consequences) -> bool {
        if !self.can_fail(leaf, consequences) || self.running.contains_key(&leaf) {
            return false;
        }
        Arc::make_mut(&mut self.infeasible).insert(leaf, reason.clone());
        self.fall(leaf, consequences);
        true
    }

    fn time_out(&mut self, node: NodeId, consequences: Consequences) -> bool {
        if !self.can_fail(node, consequences) {
            return false;
        }
        self.end_time(node);
        self.fall(node, consequences);
        true
    }

    /// What fails with a node that does not run.
    pub(super) fn fall(&mut self, from: NodeId, consequences: Consequences) {
        if consequences.failed.is_some() {
            self.take_back(from, consequences.failed);
        }
        self.go_on(from, consequences);
    }

    /// Full grippers that a node held go up, as far as what has failed; all else is free.
    fn take_back(&mut self, from: NodeId, failed: Option<NodeId>) {
        let (topology, world) = (Arc::clone(&self.topology), Arc::clone(&self.world));
        let is_full = |resource| world.held_by(resource).is_some();
        Arc::make_mut(&mut self.table).take_back(&topology, from, failed, is_full);
    }

    /// What has failed, what begins to, and the cleanup that is over with it.
    fn go_on(&mut self, from: NodeId, consequences: Consequences) {
        if let Some(failed) = consequences.failed {
            self.fail(from, failed);
        }
        if let Some(failing) = consequences.failing {
            self.begin_failing(failing);
        }
        if let Some(cleaned) = consequences.cleaned {
            self.end_cleaning(cleaned);
        }
    }

    fn begin_failing(&mut self, failing: Failing) {
        self.status_mut(failing.node).phase = Phase::Failing(failing);
        if !failing.finishes {
            self.end_times_of_body(failing.node);
            return;
        }
        // Nothing above can be complete any more either.
        let topology = Arc::clone(&self.topology);
        let mut child = failing.node;
        for node in topology.path(failing.node).skip(1).take_while(|node| *node > topology.stem()) {
            // What a cleanup comes to is nothing to those above.
            if topology.is_cleanup(child) {
                break;
            }
            if self.phase(node) == Phase::Pending {
                self.status_mut(node).phase = Phase::Failing(Failing { node, child, ..failing });
            }
            child = node;
        }
    }

    /// Others did what a THEN was about to do.
    fn overtake(&mut self, leaf: NodeId, skips: &[NodeRange], goal: NodeId, consequences: Consequences) -> bool {
        if !self.can_overtake(leaf, skips, goal, consequences) {
            return false;
        }
        skips.iter().for_each(|skip| self.skip(*skip));
        if let Some(completed) = consequences.completed {
            let heir = Heir { node: completed.heir.unwrap_or(completed.node), goes_on: completed.heir.is_some() };
            let topology = Arc::clone(&self.topology);
            let is_skipped = |holder| skips.iter().any(|skip| skip.contains(holder));
            let is_below = |holder| is_skipped(holder) || topology.is_within(holder, completed.node);
            Arc::make_mut(&mut self.table).move_up(is_below, heir);
            self.are_done(goal, completed.node);
        }
        let from = consequences.completed.map_or(goal, |completed| self.topology.parent(completed.node));
        self.fall(from, consequences);
        true
    }

    /// What was kept below the THEN is kept no more, nor is its keeper done.
    fn send_back(&mut self, reopened: &Reopened, leaf: NodeId) {
        let redone = Redone { progress: self.progress, leaf: Some(leaf) };
        Arc::make_mut(&mut self.redone).insert(reopened.node, redone);
        self.end_intentions(&reopened.ended);
        for &Kept { holder, behavior, .. } in &reopened.ended {
            for node in self.topology.path(behavior).take_while(|node| *node != holder).collect::<Vec<_>>() {
                self.status_mut(node).phase = Phase::Pending;
            }
        }
    }

    fn release(&mut self, leaf: NodeId, end: End, consequences: Consequences, changes: &[Change]) -> bool {
        if !self.can_release(leaf, consequences, changes) {
            return false;
        }
        let Some(grant) = Arc::make_mut(&mut self.running).remove(&leaf) else { return false };
        let topology = Arc::clone(&self.topology);
        self.status_mut(leaf).is_stopping = false;
        if self.interrupted.contains_key(&leaf) {
            Arc::make_mut(&mut self.interrupted).remove(&leaf);
        }
        if let End::Failed(_) = end {
            let mut failed_with: Vec<ResourceId> = self.status(leaf).failed_with.clone();
            let claimed = std::iter::zip(&grant.request.claims, &grant.bindings);
            failed_with.extend(claimed.map(|(_, binding)| binding.resource));
            failed_with.sort_unstable();
            failed_with.dedup();
            let status = self.status_mut(leaf);
            (status.failures, status.failed_with) = (status.failures + 1, failed_with);
        }
        let were_occupied = self.occupied();
        self.change_world(changes);
        if let Some(completed) = consequences.completed {
            let heir = Heir { node: completed.heir.unwrap_or(completed.node), goes_on: completed.heir.is_some() };
            Arc::make_mut(&mut self.table).hand_over(&topology, &grant, completed.node, heir);
            self.complete(leaf, completed.node);
        }
        if consequences.completed.is_none() || consequences.failed.is_some() {
            self.take_back(leaf, consequences.failed);
        }
        self.release_emptied(&were_occupied, changes);
        self.go_on(consequences.completed.map_or(leaf, |completed| topology.parent(completed.node)), consequences);
        true
    }

    /// A node and all above it up to another are done, and needed for nothing more.
    fn are_done(&mut self, from: NodeId, top: NodeId) {
        for node in self.topology.path(from).take_while(|node| *node >= top).collect::<Vec<_>>() {
            self.status_mut(node).phase = Phase::Done;
        }
        self.forget_below(top);
    }

    /// The behavior has brought it about that all above it up to a node are done.
    fn complete(&mut self, leaf: NodeId, top: NodeId) {
        self.are_done(leaf, top);
        let status = self.status_mut(leaf);
        let is_first = !std::mem::replace(&mut status.has_completed, true);
        // A cleanup brings nothing nearer.
        let is_cleaning = self.cleaning.range(..leaf).any(|node| self.topology.is_within(leaf, *node));
        self.progress += u64::from(is_first && !is_cleaning);
    }

    /// The nodes on the way from one to another above it have failed.
    fn fail(&mut self, from: NodeId, top: NodeId) {
        for node in self.topology.path(from).take_while(|node| *node >= top).collect::<Vec<_>>() {
            self.status_mut(node).phase = Phase::Failed;
        }
        let parent = self.topology.parent(top);
        if self.status(parent).way == Some(top) {
            self.status_mut(parent).way = None;
        }
        let topology = Arc::clone(&self.topology);
        topology.below(top).for_each(|run| self.forget_moments(run));
    }

    fn change(&mut self, changes: &[Change]) -> bool {
        let were_occupied = self.occupied();
        let is_known = self.change_world(changes);
        self.release_emptied(&were_occupied, changes);
        self.progress += 1;
        is_known
    }

    fn change_world(&mut self, changes: &[Change]) -> bool {
        let known = changes.iter().filter(|change| self.knows(**change)).copied().collect::<Vec<_>>();
        let world = Arc::make_mut(&mut self.world);
        for change in &known {
            world.apply(*change);
        }
        known.len() == changes.len()
    }

    /// Which resources hold an object, by resource.
    fn occupied(&self) -> Vec<bool> {
        self.table.iter().map(|(id, _)| self.world.held_by(id).is_some()).collect()
    }

    /// A physical lease ends when the world shows the gripper empty.
    fn release_emptied(&mut self, were_occupied: &[bool], changes: &[Change]) {
        for (index, was_occupied) in were_occupied.iter().enumerate() {
            let id = ResourceId::from(index);
            let is_said_empty = changes.contains(&Change::Emptied(id));
            if (*was_occupied || is_said_empty) && self.world.held_by(id).is_none() {
                Arc::make_mut(&mut self.table).emptied(id);
            }
        }
    }

    fn finish(&mut self, end: MissionEnd) {
        if let Stage::Over(_) = self.stage {
            return;
        }
        self.stage = Stage::Over(end);
        if end == MissionEnd::Done {
            Arc::make_mut(&mut self.table).clear();
        }
    }
}

/// The top of the task.
const TOP: NodeId = NodeId(1);

/// Does something with each, also behind one that fails; true if none does.
pub(super) fn each<T>(things: &[T], mut apply: impl FnMut(&T) -> bool) -> bool {
    let mut are_sound = true;
    for thing in things {
        are_sound &= apply(thing);
    }
    are_sound
}
