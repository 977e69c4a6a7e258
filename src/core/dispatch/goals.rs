//! A goal's life: parts begin together, the achieved ones end it, the maintained ones are shared and left.

use std::collections::VecDeque;

use super::slot::{Active, Work};
use super::{Dispatch, Effect};
use ambidex_model::{
    CommandId, ControllerId, ControllerMessage, ControllerState, End, Fault, Goal, Mode, NodeId, Outcome, Part,
    PartEnd, Rejection, Report, ResourceId, Time, ToController,
};

/// A goal under way.
#[derive(Debug)]
pub(super) struct Running {
    /// Controllers that still work on it, with the resource and mode of the part.
    parts: Vec<(ControllerId, ResourceId, Mode)>,
    /// When it may end, at the earliest.
    ripe: Time,
    due: Option<Time>,
    /// How it will have ended when the last part has.
    end: Option<End>,
    reports: Vec<Report>,
}

impl Running {
    pub(super) fn deadline(&self) -> Option<Time> {
        let ripe = self.is_achieved().then_some(self.ripe);
        self.due.map(|due| ripe.map_or(due, |ripe| ripe.min(due)))
    }

    /// Whether only its time keeps it.
    fn is_achieved(&self) -> bool {
        self.parts.iter().all(|(.., mode)| *mode == Mode::Maintain)
    }
}

impl Dispatch {
    pub(super) fn start(&mut self, now: Time, goal: Goal) {
        let leaf = goal.leaf;
        let work = |part: Part| {
            let controller = self.robot.resources[part.resource.index()].controller?;
            let Part { resource, access, mode, command } = part;
            Some((controller, Work { resource, access, mode, command }))
        };
        let works: Vec<_> = goal.parts.into_iter().filter_map(work).collect();
        if let Some(end) = self.obstacle(&works) {
            self.effects.push(Effect::Ended(leaf, Outcome { end, reports: Vec::new() }));
            return;
        }
        let parts = works.iter().map(|(controller, work)| (*controller, work.resource, work.mode)).collect();
        let (ripe, due) = (now + goal.takes, Some(now + goal.timeout));
        self.goals.insert(leaf, Running { parts, ripe, due, end: None, reports: Vec::new() });
        for (controller, work) in works {
            self.begin(now, controller, leaf, work);
        }
        self.settle(now, leaf);
    }

    /// Why a goal ends before it begins: everything ends, or a controller that it needs is gone.
    fn obstacle(&self, works: &[(ControllerId, Work)]) -> Option<End> {
        let is_gone = |id: &ControllerId| !self.attachments[id.index()].is_ready();
        let gone = works.iter().map(|(controller, _)| *controller).find(is_gone);
        let canceled = self.is_ending.then_some(End::Canceled);
        canceled.or(gone.map(|controller| End::Failed(Fault::Lost(controller))))
    }

    /// Ends a goal before its time.
    pub(super) fn stop(&mut self, now: Time, leaf: NodeId, end: End) {
        let Some(running) = self.goals.get_mut(&leaf) else {
            return;
        };
        running.end.get_or_insert(end);
        running.due = None;
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
            .filter(|(_, running)| running.due.is_some_and(|due| due <= now))
            .map(|(&leaf, _)| leaf)
            .collect();
        for leaf in late {
            self.stop(now, leaf, End::Failed(Fault::TimedOut));
        }
        for leaf in self.goals.keys().copied().collect::<Vec<_>>() {
            self.settle(now, leaf);
        }
        for index in 0..self.slots.len() {
            let controller = ControllerId::from(index);
            if self.slots[index].deadline().is_some_and(|due| due <= now) {
                self.unanswered(now, controller);
            }
            if self.attachments[index].deadline().is_some_and(|due| due <= now) {
                self.configure(now, controller);
            }
        }
    }

    pub(super) fn rejected(&mut self, now: Time, controller: ControllerId, why: Rejection) {
        self.drop_current(now, controller, End::Failed(Fault::Rejected(controller, why)));
    }

    pub(super) fn closed(&mut self, now: Time, controller: ControllerId, id: CommandId) {
        if self.slots[controller.index()].knows(id) {
            self.record(now, controller, ControllerMessage::Refused { why: Rejection::Unknown });
            self.drop_current(now, controller, End::Failed(Fault::Aborted(controller)));
        }
    }

    pub(super) fn part_ended(&mut self, now: Time, controller: ControllerId, end: PartEnd, state: ControllerState) {
        let Some(active) = self.slots[controller.index()].current.take() else {
            return;
        };
        let fault = match (active.work.mode, end) {
            (Mode::Achieve, PartEnd::Succeeded) => None,
            (Mode::Achieve, PartEnd::Aborted | PartEnd::Canceled) => Some(Fault::Aborted(controller)),
            (Mode::Maintain, _) => Some(Fault::NotMaintained(controller)),
        };
        for leaf in active.holders {
            self.report(leaf, active.work.resource, state);
            self.forget_part(leaf, active.work.resource, active.work.mode);
            match fault {
                Some(fault) => self.stop(now, leaf, End::Failed(fault)),
                None => self.settle(now, leaf),
            }
        }
        self.next(now, controller);
    }

    pub(super) fn slot_lost(&mut self, now: Time, controller: ControllerId) {
        let fault = End::Failed(Fault::Lost(controller));
        for (leaf, work) in std::mem::take(&mut self.slots[controller.index()].queue) {
            self.forget_part(leaf, work.resource, work.mode);
            self.stop(now, leaf, fault);
        }
        self.drop_current(now, controller, fault);
    }

    fn begin(&mut self, now: Time, controller: ControllerId, leaf: NodeId, work: Work) {
        if let Some(active) = self.slots[controller.index()].shared(&work) {
            active.holders.insert(leaf);
            let id = active.id;
            self.record(now, controller, ControllerMessage::Joined { leaf, id });
            return;
        }
        self.slots[controller.index()].queue.push_back((leaf, work));
        self.next(now, controller);
    }

    /// Sends the next command of a controller that is free.
    fn next(&mut self, now: Time, controller: ControllerId) {
        if self.slots[controller.index()].current.is_some() {
            return;
        }
        let Some((leaf, work)) = self.slots[controller.index()].queue.pop_front() else {
            return;
        };
        let id = self.send(now, controller, leaf, &work);
        let due = Some(now + self.limits.accept);
        let active = Active { id, work, holders: [leaf].into(), due, is_canceled: false };
        self.slots[controller.index()].current = Some(active);
        let waiting = std::mem::take(&mut self.slots[controller.index()].queue);
        for (leaf, work) in waiting {
            self.begin(now, controller, leaf, work);
        }
    }

    /// A goal no longer needs a controller; the last to leave stops the command.
    fn leave(&mut self, now: Time, controller: ControllerId, leaf: NodeId) {
        let due = Some(now + self.limits.cancel);
        let slot = &mut self.slots[controller.index()];
        let waiting = std::mem::take(&mut slot.queue);
        let (gone, queue): (VecDeque<_>, _) = waiting.into_iter().partition(|(waiting, _)| *waiting == leaf);
        slot.queue = queue;
        for (_, work) in gone {
            self.forget_part(leaf, work.resource, work.mode);
        }
        let slot = &mut self.slots[controller.index()];
        let Some(active) = slot.current.as_mut().filter(|active| active.holders.contains(&leaf)) else {
            return;
        };
        if active.holders.len() > 1 {
            active.holders.remove(&leaf);
            let (resource, mode) = (active.work.resource, active.work.mode);
            self.forget_part(leaf, resource, mode);
        } else if !active.is_canceled {
            active.is_canceled = true;
            active.due = due;
            let id = active.id;
            self.tell(now, controller, Some(leaf), ToController::Cancel { id });
        }
    }

    fn unanswered(&mut self, now: Time, controller: ControllerId) {
        let Some(active) = &self.slots[controller.index()].current else {
            return;
        };
        let id = active.id;
        if !active.is_canceled {
            self.tell(now, controller, None, ToController::Cancel { id });
        }
        self.drop_current(now, controller, End::Failed(Fault::Unanswered(controller)));
    }

    /// Gives up what a controller is doing; whatever it says of it later is stale.
    fn drop_current(&mut self, now: Time, controller: ControllerId, end: End) {
        if let Some(active) = self.slots[controller.index()].current.take() {
            for leaf in active.holders {
                self.forget_part(leaf, active.work.resource, active.work.mode);
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

    fn report(&mut self, leaf: NodeId, resource: ResourceId, state: ControllerState) {
        let report = match state {
            ControllerState::Base { pose, .. } => Report::BaseAt(pose),
            ControllerState::Arm { holds, .. } => Report::Holds(resource, holds),
            ControllerState::Head { .. } => return,
        };
        if let Some(running) = self.goals.get_mut(&leaf) {
            running.reports.push(report);
        }
    }

    /// Once nothing is left to achieve the rest is left; once nothing is left at all the leaf hears of it.
    fn settle(&mut self, now: Time, leaf: NodeId) {
        let Some(running) = self.goals.get_mut(&leaf) else {
            return;
        };
        if running.is_achieved() && running.ripe <= now && running.end.is_none() {
            self.stop(now, leaf, End::Succeeded);
        } else if running.parts.is_empty()
            && running.end.is_some()
            && let Some(running) = self.goals.remove(&leaf)
        {
            let end = running.end.expect("a goal without parts has ended");
            self.effects.push(Effect::Ended(leaf, Outcome { end, reports: running.reports }));
        }
    }
}
