//! A goal's life: parts begin together, the achieved ones end it, the maintained ones are shared and left.

use std::collections::VecDeque;

use super::command_queue::Active;
use super::script::Plan;
use super::{Dispatch, Effect, loses};
use ambidex_model::{
    Change, Command, CommandId, ControllerId, ControllerMessage, ControllerState, End, Fault, Goal, Mode, NodeId,
    Outcome, Part, PartEnd, Rejection, ResourceId, Time, ToController,
};

/// A goal under way.
#[derive(Debug)]
pub(super) struct Running {
    /// Controllers that still work on it, with the resource and mode of the part.
    parts: Vec<(ControllerId, ResourceId, Mode)>,
    /// When it may end, at the earliest.
    earliest_end: Time,
    deadline: Option<Time>,
    /// On purpose: the controller that gives up once all is achieved.
    gives_up: Option<ControllerId>,
    /// On purpose: it does not end by itself.
    hangs: bool,
    /// How it will have ended when the last part has.
    end: Option<End>,
    /// What its controllers said of the world as their parts ended.
    changes: Vec<Change>,
}

impl Running {
    pub(super) fn deadline(&self) -> Option<Time> {
        let earliest_end = self.can_end().then_some(self.earliest_end);
        self.deadline.map(|deadline| earliest_end.map_or(deadline, |earliest_end| earliest_end.min(deadline)))
    }

    /// Whether only its time keeps it.
    fn can_end(&self) -> bool {
        self.is_achieved() && !self.hangs
    }

    /// Whether nothing is left to achieve.
    fn is_achieved(&self) -> bool {
        self.parts.iter().all(|(.., mode)| *mode == Mode::Maintain)
    }
}

impl Dispatch {
    /// Begins a goal, of which comes what the plan says.
    pub(super) fn start(&mut self, now: Time, goal: Goal, plan: &Plan) {
        let leaf = goal.leaf;
        let robot = &self.mission.robot;
        let moved = |part: Part| Some((robot.resources[part.resource.index()].controller?, part));
        let parts: Vec<_> = goal.parts.into_iter().filter_map(moved).collect();
        if let Some(end) = self.obstacle(&parts) {
            self.effects.push(Effect::Ended(leaf, Outcome { end, changes: Vec::new() }));
            return;
        }
        let achieves = |(_, part): &&(ControllerId, Part)| part.mode == Mode::Achieve;
        let worker = parts.iter().find(achieves).or(parts.first()).map(|(controller, _)| *controller);
        let under_way = parts.iter().map(|(controller, part)| (*controller, part.resource, part.mode)).collect();
        let (earliest_end, deadline) = (now + goal.takes + plan.late, Some(now + goal.timeout));
        let running = Running {
            parts: under_way,
            earliest_end,
            deadline,
            gives_up: worker.filter(|_| plan.fails),
            hangs: plan.hangs,
            end: None,
            changes: Vec::new(),
        };
        self.goals.insert(leaf, running);
        for (controller, part) in parts {
            self.begin(now, controller, leaf, part);
        }
        self.settle(now, leaf);
    }

    /// Why a goal ends before it begins: everything ends, or a controller that it needs is gone.
    fn obstacle(&self, parts: &[(ControllerId, Part)]) -> Option<End> {
        let is_gone = |id: &ControllerId| !self.attachments[id.index()].is_ready();
        let gone = parts.iter().map(|(controller, _)| *controller).find(is_gone);
        let canceled = self.is_ending.then_some(End::Canceled);
        let lost = |controller: ControllerId| match self.attachments[controller.index()].loss() {
            Some(why) => loses(controller, why),
            None => End::Failed(Fault::Lost(controller)),
        };
        canceled.or_else(|| gone.map(lost))
    }

    /// Ends a goal before its time.
    pub(super) fn stop(&mut self, now: Time, leaf: NodeId, end: End) {
        let Some(running) = self.goals.get_mut(&leaf) else {
            return;
        };
        running.end.get_or_insert(end);
        running.deadline = None;
        let controllers: Vec<_> = running.parts.iter().map(|(controller, ..)| *controller).collect();
        for controller in controllers {
            self.leave(now, controller, leaf);
        }
        self.settle(now, leaf);
    }

    pub(super) fn woke(&mut self, now: Time) {
        let late: Vec<_> = self
            .goals
            .iter()
            .filter(|(_, running)| running.deadline.is_some_and(|deadline| deadline <= now))
            .map(|(&leaf, _)| leaf)
            .collect();
        for leaf in late {
            self.stop(now, leaf, End::Failed(Fault::TimedOut));
        }
        for leaf in self.goals.keys().copied().collect::<Vec<_>>() {
            self.settle(now, leaf);
        }
        self.pass_on(now);
        for index in 0..self.queues.len() {
            let controller = ControllerId::from(index);
            if self.queues[index].deadline().is_some_and(|deadline| deadline <= now) {
                self.unanswered(now, controller);
            }
            if self.attachments[index].deadline().is_some_and(|deadline| deadline <= now) {
                self.configure(now, controller);
            }
        }
    }

    pub(super) fn rejected(&mut self, now: Time, controller: ControllerId, why: Rejection) {
        let end = End::Failed(self.not_held(controller, why).unwrap_or(Fault::Rejected(controller, why)));
        match why {
            Rejection::Busy => self.hang(now, controller, end),
            Rejection::Inhibited(why) => self.inhibited(now, controller, why),
            Rejection::Version
            | Rejection::Stale
            | Rejection::Unknown
            | Rejection::Malformed
            | Rejection::NotFinite
            | Rejection::NotConfigured
            | Rejection::Unsupported
            | Rejection::OutOfReach
            | Rejection::NoSuchName => self.drop_current(now, controller, end),
        }
    }

    /// An arm can put things down, but for what it does not hold: that is no matter of reach or kind.
    fn not_held(&self, controller: ControllerId, why: Rejection) -> Option<Fault> {
        let part = &self.queues[controller.index()].current.as_ref()?.part;
        let is_put = matches!(part.command, Command::Put { .. }) && why == Rejection::Unsupported;
        is_put.then_some(Fault::Contradicted(part.resource))
    }

    pub(super) fn closed(&mut self, now: Time, controller: ControllerId, id: CommandId) {
        if self.queues[controller.index()].knows(id) {
            self.record(now, controller, ControllerMessage::Refused { id: Some(id), why: Rejection::Unknown });
            self.drop_current(now, controller, End::Failed(Fault::Aborted(controller)));
        }
    }

    pub(super) fn part_ended(&mut self, now: Time, controller: ControllerId, end: PartEnd, state: ControllerState) {
        let Some(active) = self.queues[controller.index()].current.take() else {
            return;
        };
        let fault = match (active.part.mode, end) {
            (_, PartEnd::Inhibited(why)) => {
                active.holders.iter().for_each(|leaf| self.tell_changes(*leaf, active.part.resource, state));
                self.queues[controller.index()].current = Some(active);
                return self.inhibited(now, controller, why);
            }
            (Mode::Achieve, PartEnd::Succeeded) => None,
            (Mode::Achieve, PartEnd::Aborted | PartEnd::Canceled) => Some(Fault::Aborted(controller)),
            (Mode::Maintain, PartEnd::Succeeded | PartEnd::Aborted | PartEnd::Canceled) => {
                Some(Fault::NotMaintained(controller))
            }
        };
        for leaf in active.holders {
            self.tell_changes(leaf, active.part.resource, state);
            self.forget_part(leaf, active.part.resource, active.part.mode);
            match fault {
                Some(fault) => self.stop(now, leaf, End::Failed(fault)),
                None => self.settle(now, leaf),
            }
        }
        self.next(now, controller);
    }

    /// What is under way ends so, what waits as something else.
    pub(super) fn queue_lost(&mut self, now: Time, controller: ControllerId, of_waiting: End, end: End) {
        for (leaf, part) in std::mem::take(&mut self.queues[controller.index()].waiting) {
            self.forget_part(leaf, part.resource, part.mode);
            self.stop(now, leaf, of_waiting);
        }
        self.drop_current(now, controller, end);
    }

    fn begin(&mut self, now: Time, controller: ControllerId, leaf: NodeId, part: Part) {
        if let Some(active) = self.queues[controller.index()].shared(&part) {
            active.holders.insert(leaf);
            let id = active.id;
            self.record(now, controller, ControllerMessage::Joined { leaf, id });
            return;
        }
        self.queues[controller.index()].waiting.push_back((leaf, part));
        self.next(now, controller);
    }

    /// Sends the next command of a controller that is free.
    fn next(&mut self, now: Time, controller: ControllerId) {
        // What is away gets nothing; what waits for it is given up with it.
        if !self.attachments[controller.index()].is_ready() {
            return;
        }
        if self.queues[controller.index()].current.is_some() {
            return;
        }
        let Some((leaf, part)) = self.queues[controller.index()].waiting.pop_front() else {
            return;
        };
        let id = self.send(now, controller, leaf, &part);
        let deadline = Some(now + self.limits.accept);
        let active = Active { id, part, holders: [leaf].into(), deadline, is_canceled: false };
        self.queues[controller.index()].current = Some(active);
        let waiting = std::mem::take(&mut self.queues[controller.index()].waiting);
        for (leaf, part) in waiting {
            self.begin(now, controller, leaf, part);
        }
    }

    /// A goal no longer needs a controller; the last to leave stops the command.
    fn leave(&mut self, now: Time, controller: ControllerId, leaf: NodeId) {
        let grace = self.mission.robot.controllers[controller.index()].cancel_grace;
        let deadline = Some(now + self.limits.robot(grace));
        let waiting = std::mem::take(&mut self.queues[controller.index()].waiting);
        let (gone, waiting): (VecDeque<_>, _) = waiting.into_iter().partition(|(waiting, _)| *waiting == leaf);
        self.queues[controller.index()].waiting = waiting;
        for (_, part) in gone {
            self.forget_part(leaf, part.resource, part.mode);
        }
        let current = &mut self.queues[controller.index()].current;
        let Some(active) = current.as_mut().filter(|active| active.holders.contains(&leaf)) else {
            return;
        };
        if active.holders.len() > 1 {
            active.holders.remove(&leaf);
            let (resource, mode) = (active.part.resource, active.part.mode);
            self.forget_part(leaf, resource, mode);
        } else if !active.is_canceled {
            active.is_canceled = true;
            active.deadline = deadline;
            let id = active.id;
            self.tell(now, controller, Some(leaf), ToController::Cancel { id });
        }
    }

    fn unanswered(&mut self, now: Time, controller: ControllerId) {
        let Some(active) = &self.queues[controller.index()].current else {
            return;
        };
        let id = active.id;
        if !active.is_canceled {
            self.tell(now, controller, None, ToController::Cancel { id });
        }
        self.hang(now, controller, End::Failed(Fault::Unanswered(controller)));
    }

    /// Gives up what a controller is doing; whatever it says of it later is stale.
    pub(super) fn drop_current(&mut self, now: Time, controller: ControllerId, end: End) {
        if let Some(active) = self.queues[controller.index()].current.take() {
            for leaf in active.holders {
                self.forget_part(leaf, active.part.resource, active.part.mode);
                self.stop(now, leaf, end);
            }
        }
        self.next(now, controller);
    }

    /// A goal may have two parts for one resource, one after the other: one of them is over.
    fn forget_part(&mut self, leaf: NodeId, resource: ResourceId, mode: Mode) {
        let Some(running) = self.goals.get_mut(&leaf) else {
            return;
        };
        if let Some(over) = running.parts.iter().position(|(_, part, of)| (*part, *of) == (resource, mode)) {
            running.parts.remove(over);
        }
    }

    /// What a controller says of the world goes into the outcome of the goal.
    fn tell_changes(&mut self, leaf: NodeId, resource: ResourceId, state: ControllerState) {
        if let Some(running) = self.goals.get_mut(&leaf) {
            running.changes.extend(state.changes([resource]));
        }
    }

    /// Once nothing is left to achieve the rest is left; once nothing is left at all the leaf hears of it.
    fn settle(&mut self, now: Time, leaf: NodeId) {
        let Some(running) = self.goals.get_mut(&leaf) else {
            return;
        };
        if running.can_end() && running.earliest_end <= now && running.end.is_none() {
            let end = running.gives_up.map_or(End::Succeeded, |id| End::Failed(Fault::Aborted(id)));
            self.stop(now, leaf, end);
        } else if running.parts.is_empty()
            && running.end.is_some()
            && let Some(running) = self.goals.remove(&leaf)
        {
            let end = running.end.expect("a goal without parts has ended");
            self.effects.push(Effect::Ended(leaf, Outcome { end, changes: running.changes }));
        }
    }
}
