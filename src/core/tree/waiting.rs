//! What root waits for: behaviors that failed and ask again later, and controllers that are away (`semantics` 6).

use std::collections::BTreeSet;

use super::{Outbox, Root, TOP};
use ambidex_model::state::Phase;
use ambidex_model::{
    ControllerId, FactId, Loss, MissionEnd, NodeId, PlaceId, Reason, Record, Resource, ResourceId, Service, Time, Told,
};

impl Root {
    /// When it has to be told [`Told::Woke`].
    pub fn deadline(&self) -> Option<Time> {
        // Told once, it is taken up in the next turn.
        let is_told = !self.is_between_rounds() || self.told.contains(&Told::Woke);
        let may_clean = self.ending.is_none() || self.owes_cleanup();
        let is_waiting = !is_told && !self.is_over() && !self.is_suspended && may_clean;
        let waits = self.state.waits().first().map(|(until, _)| *until);
        let is_awaited = self.state.table().iter().any(|(_, resource)| resource.service().is_awaited());
        let awaited = self.state.awaited_until().filter(|_| is_awaited);
        let deadline = self.state.deadlines().first().map(|(until, _)| *until);
        let pause = self.state.pauses().values().map(|pause| pause.until).min();
        let grace = self.state.ending().map(|(_, until)| until);
        let moments = [waits, awaited, deadline, pause, grace, self.next_grace()].into_iter().flatten();
        moments.min().filter(|_| is_waiting)
    }

    /// Nothing can go on. Who is away may come back; whoever was awaited in vain is what the mission failed for.
    pub(super) fn stall(&mut self, now: Time, out: &mut Outbox) {
        if let Some(&node) = self.state.cleaning().first() {
            return self.end_cleanup(now, node, false, out);
        }
        if self.await_controllers(now, out) {
            return;
        }
        if let Some((or, way)) = self.way_to_leave(None) {
            return self.leave_way(now, or, way, out);
        }
        let (facts, places) = (self.lacks_of_others(None), self.shut_off());
        let waits = !facts.is_empty() || !places.is_empty();
        if waits && self.state.awaited_of_others() != (&facts[..], &places[..]) {
            self.edit(Record::Awaited { at: now, until: None, facts, places }, out);
        }
        if self.settings.waits_when_stalled || waits || !self.state.pauses().is_empty() {
            return;
        }
        match self.owes_cleanup() {
            true => self.end(now, self.stalled(), out),
            false => self.finish(now, self.stalled(), out),
        }
    }

    /// Awaits who is away; false where nobody is.
    pub(super) fn await_controllers(&mut self, now: Time, out: &mut Outbox) -> bool {
        let services: Vec<Service> = self.state.table().iter().map(|(_, resource)| resource.service()).collect();
        let awaited = || services.iter().filter(|service| service.is_awaited());
        if awaited().next().is_some() && !self.state.is_awaiting() {
            // Who is inhibited will say when it is over.
            let has_limit = awaited().any(Service::is_awaited_for_a_time);
            let until = has_limit.then(|| now + self.settings.reattach);
            self.edit(Record::Awaited { at: now, until, facts: Vec::new(), places: Vec::new() }, out);
        }
        awaited().next().is_some()
    }

    /// How a mission ends in which nothing can go on: as failed, where something has failed of it already; as lost, where
    /// a controller is awaited no more.
    pub(super) fn stalled(&self) -> MissionEnd {
        if let Phase::Failing(failing) = self.state.phase(TOP) {
            return self.failed_for(failing.cause);
        }
        // Who is still awaited may have been what it needs.
        let is_awaited = self.state.table().iter().any(|(_, resource)| resource.service().is_awaited());
        let is_gone = |(_, resource): &(ResourceId, &Resource)| !is_awaited && !resource.service().is_available();
        let gone = self.state.table().iter().find(is_gone);
        let controller = gone.and_then(|(id, _)| self.mission.robot.resources[id.index()].controller);
        controller.map_or(MissionEnd::Stalled, MissionEnd::ControllerLost)
    }

    /// The last OR in tree order, of a task where one is told, that has another way than the one in which nothing goes on,
    /// with that one.
    pub(super) fn way_to_leave(&self, task: Option<NodeId>) -> Option<(NodeId, NodeId)> {
        let (tree, state) = (&self.mission.tree, &self.state);
        let is_of_it = |or: &NodeId| task.is_none_or(|task| tree.topology.is_within(*or, task));
        self.ors.iter().copied().rev().filter(is_of_it).filter(|or| !state.is_over(*or)).find_map(|or| {
            let way = state.status(or).way.filter(|way| !state.is_done(*way) && !state.was_left(*way))?;
            let mut others = tree.topology.children(or).filter(|other| *other != way);
            others.any(|other| state.phase(other) != Phase::Failed).then_some((or, way))
        })
    }

    /// Facts that behaviors, of a task where one is told, lack and others may set or clear, in their order.
    pub(super) fn lacks_of_others(&self, task: Option<NodeId>) -> Vec<FactId> {
        if !self.mission.world.outside.contains(&true) {
            return Vec::new();
        }
        let reasons = self.state.topology().within(task.unwrap_or(NodeId(0)), &self.reasons);
        let lacking = reasons.filter_map(|(_, reason)| {
            let Reason::Fact { fact, .. } = *reason.root_cause() else { return None };
            self.mission.world.is_outside(fact).then_some(fact)
        });
        lacking.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Places to which no path leads past what came to stand in the room, and may go again: to what no path leads in the bare
    /// room never runs.
    fn shut_off(&self) -> Vec<PlaceId> {
        if self.state.world().obstacles.is_empty() {
            return Vec::new();
        }
        let shut = self.reasons.values().filter_map(|reason| match *reason.root_cause() {
            Reason::NoPath { place } => Some(place),
            _ => None,
        });
        shut.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// What a controller moves is away, or can be granted again.
    pub(super) fn serve(&mut self, now: Time, controller: ControllerId, outage: Option<Loss>, out: &mut Outbox) {
        if let (Some(why), Some(before)) = (outage, self.service(controller).and_then(|service| service.outage())) {
            // One that is away may be lost again while it attaches; it is awaited no longer for that.
            if why == before || !(why.is_inhibition() || before.is_inhibition()) {
                return;
            }
        }
        let service = outage.map_or(Service::Available, |why| Service::Unavailable { why, since: now });
        self.is_wanted = true;
        self.set_service(now, controller, service, out);
    }

    /// Every controller is there, whatever was before.
    pub(super) fn serve_all(&mut self, now: Time, out: &mut Outbox) {
        for controller in (0..self.mission.robot.controllers.len()).map(ControllerId::from) {
            if self.service(controller).is_some_and(|service| !service.is_available()) {
                self.serve(now, controller, None, out);
            }
        }
    }

    /// The service of what a controller moves, which all has the same; none of one that moves nothing.
    fn service(&self, controller: ControllerId) -> Option<Service> {
        let first = self.mission.robot.moved_by(controller).next()?;
        Some(self.state.table().resource(first).service())
    }

    fn set_service(&mut self, now: Time, controller: ControllerId, service: Service, out: &mut Outbox) {
        let resources = self.mission.robot.moved_by(controller).collect();
        self.edit(Record::Served { at: now, controller, resources, service }, out);
    }

    /// A moment came: who waited asks again, and who was awaited too long is awaited no more.
    pub(super) fn wake(&mut self, now: Time, out: &mut Outbox) {
        let due = self.state.waits().iter().take_while(|(until, _)| *until <= now);
        let mut leaves: Vec<NodeId> = due.map(|(_, leaf)| *leaf).collect();
        let paused = self.state.pauses().iter().filter(|(_, pause)| pause.until <= now);
        leaves.extend(paused.map(|(&node, _)| node));
        leaves.sort_unstable();
        if !leaves.is_empty() {
            self.is_wanted = true;
            self.edit(Record::Woke { at: now, leaves }, out);
        }
        self.time_out(now, out);
        if self.is_over() {
            return;
        }
        if self.state.awaited_until().is_some_and(|until| until <= now) {
            self.is_wanted = true;
            for controller in (0..self.mission.robot.controllers.len()).map(ControllerId::from) {
                if let Some(Service::Unavailable { why, since }) = self.service(controller)
                    && !why.is_inhibition()
                {
                    self.set_service(now, controller, Service::Gone { why, since }, out);
                }
            }
        }
    }
}
