//! The fold: what each record changes.

use ambidex_model::{
    Blocked, Change, Consequences, ControllerId, ControllerMessage, ControllerState, End, FromController, Grant,
    Message, MissionEnd, NodeId, Record, Reopened, ResourceId, Time,
};

use super::{History, Phase, Step};

impl History {
    /// Takes the next record.
    pub fn apply(&mut self, record: &Record) {
        if let Record::Decided { at, .. } = record {
            self.begun.get_or_insert(*at);
        }
        let at = self.moment(record.at());
        self.now = at;
        self.controllers.forget_ended();
        match record {
            Record::Header(_) => {}
            Record::Sent { from, message, .. } => self.sent(*from, message),
            Record::Decided { round, granted, refused, reopened, .. } => {
                self.rounds = *round;
                if let Some(past) = self.past.as_mut().filter(|past| past.rounds.last() != Some(&at)) {
                    past.rounds.push(at);
                }
                granted.iter().for_each(|grant| self.grant(at, grant, refused));
                refused.iter().for_each(|blocked| self.refuse(blocked));
                reopened.iter().for_each(|reopened| self.reopen(at, reopened));
            }
            Record::Released { leaf, end, consequences, changes, .. } => {
                self.release(at, *leaf, *end, *consequences);
                changes.iter().for_each(|change| self.change(*change));
            }
            Record::World { change, .. } => self.change(*change),
            Record::Resource { resource, state, .. } => {
                if let Some(known) = self.resources.get_mut(resource.index()) {
                    known.clone_from(state);
                }
                if let Some(lane) = self.past.as_mut().and_then(|past| past.lanes.get_mut(resource.index())) {
                    lane.change(at, state);
                }
            }
            Record::Controller { controller, message, .. } => {
                self.controllers.apply(at, *controller, message);
                self.hear(at, *controller, message);
            }
            Record::Ended { end, .. } => self.finish(at, *end),
        }
    }

    fn sent(&mut self, from: NodeId, message: &Message) {
        self.messages += 1;
        match message {
            // A behavior that runs asks for nothing: what it was granted with still says most.
            Message::Answer { running: true, potential: None, .. } if self.leaf(from).is_some() => {}
            Message::Answer { potential, .. } => self.ask(from, *potential),
            Message::Activation
            | Message::Verdict { .. }
            | Message::Reopen { .. }
            | Message::Cancel
            | Message::Release { .. } => {}
        }
    }

    fn ask(&mut self, node: NodeId, potential: Option<f64>) {
        if let Some(last) = self.potentials.get_mut(node.index()) {
            *last = potential;
        }
    }

    fn grant(&mut self, at: Time, grant: &Grant, refused: &[Blocked]) {
        let leaf = grant.leaf();
        for skipped in self.skipped_by(grant, refused) {
            self.states.skip(skipped, at);
        }
        let Some(history) = self.states.leaf_mut(leaf) else { return };
        (history.reason, history.last_end) = (None, None);
        self.states.enter(leaf, at, Phase::Active);
        self.running.insert(leaf, grant.clone());
        let is_new = std::mem::take(&mut self.is_step_over);
        self.step_count += usize::from(is_new);
        let Some(past) = &mut self.past else { return };
        match past.steps.last_mut().filter(|_| !is_new) {
            Some(step) => step.leaves.push(leaf),
            None => past.steps.push(Step { at, leaves: vec![leaf] }),
        }
    }

    fn refuse(&mut self, blocked: &Blocked) {
        if let Some(leaf) = self.states.leaf_mut(blocked.leaf) {
            leaf.reason = Some(blocked.reason.clone());
        }
    }

    fn reopen(&mut self, at: Time, reopened: &Reopened) {
        self.is_step_over |= reopened.lapsed.is_some();
        self.states.reopen(reopened.leaf, at);
        if let Some(leaf) = self.states.leaf_mut(reopened.leaf) {
            leaf.reopened = Some(reopened.clone());
        }
    }

    fn release(&mut self, at: Time, leaf: NodeId, end: End, consequences: Consequences) {
        self.is_step_over = true;
        self.controllers.release(leaf);
        self.ask(leaf, None);
        if self.running.remove(&leaf).is_some() {
            self.last_release = Some(self.last_release.map_or(at, |last| last.max(at)));
        }
        let Some(history) = self.states.leaf_mut(leaf) else { return };
        history.last_end = Some(end);
        if let End::Failed(fault) = end {
            history.fail(at, fault);
        }
        let is_final = consequences.failed.is_some() || self.end.is_some();
        self.states.enter(leaf, at, Phase::ended(end, is_final));
        self.states.settle(leaf, at, consequences);
    }

    /// A controller that was configured says how things are, which wins; a base says where it is all the time.
    fn hear(&mut self, at: Time, controller: ControllerId, message: &ControllerMessage) {
        let message = match message {
            ControllerMessage::Heard { message } => message,
            ControllerMessage::Lost { why } => {
                self.lost.insert(controller, (at, *why));
                return;
            }
            ControllerMessage::Attached
            | ControllerMessage::Told { .. }
            | ControllerMessage::Joined { .. }
            | ControllerMessage::Refused { .. } => return,
        };
        match message {
            FromController::Configured { state, .. } => self.observe(state, controller),
            FromController::Feedback { state, .. } | FromController::Result { state, .. } => match state {
                ControllerState::Base { pose, .. } => self.change(Change::Base(*pose)),
                ControllerState::Arm { .. } | ControllerState::Head { .. } => {}
            },
            FromController::Accepted { .. } | FromController::Rejected { .. } => {}
        }
    }

    fn observe(&mut self, state: &ControllerState, controller: ControllerId) {
        let movers = self.header.movers.iter().enumerate();
        let moved = movers.filter(|(_, mover)| **mover == Some(controller)).map(|(index, _)| ResourceId::from(index));
        let changes = state.changes(moved);
        changes.into_iter().for_each(|change| self.change(change));
    }

    fn change(&mut self, change: Change) {
        let is_known = match change {
            Change::Base(_) | Change::Emptied(_) => true,
            Change::Object(object, _) => object.index() < self.world.objects.len(),
            Change::Fact(fact, _) => fact.index() < self.world.facts.len(),
        };
        if is_known {
            self.is_base_known |= matches!(change, Change::Base(_));
            self.world.apply(change);
        }
    }

    fn finish(&mut self, at: Time, end: MissionEnd) {
        if *self.end.get_or_insert(end) == MissionEnd::Done {
            for leaf in self.met() {
                self.states.skip(leaf, at);
            }
            self.states.complete(at);
        }
        self.states.end();
    }
}
