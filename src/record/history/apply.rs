//! The fold: what each record changes.

use std::sync::Arc;

use ambidex_model::state::Stage;
use ambidex_model::{
    Blocked, Cause, Change, Consequences, ControllerId, ControllerMessage, ControllerState, End, FromController, Grant,
    Message, MissionEnd, NodeId, Record, Reopened, ResourceId, Time, Told,
};

use super::{History, Interruption, LeafState, OutsideChange, Phase, Step};

impl History {
    /// Takes the next record.
    pub fn apply(&mut self, record: &Record) {
        if let Record::Decided { at, .. } = record {
            self.begun.get_or_insert(*at);
        }
        if let Record::Checkpoint { begun, .. } = record {
            self.begun = Some(*begun);
        }
        let at = self.moment(record.at());
        self.now = at;
        self.controllers.forget_ended();
        self.apply_to_leaves(at, record);
        self.makers.apply(at, record, &self.header.names);
        let base = self.state.world().base;
        self.state.apply(record);
        if let Record::Checkpoint { saved, .. } = record {
            self.go_on_from(at, saved);
        }
        if let Record::Decided { reopened: Some(reopened), .. } = record {
            self.reopen_skipped(at, reopened);
        }
        if self.state.world().base != base {
            self.base = Some(self.state.world().base);
        }
    }

    /// What the record says of leaves, steps and controllers, before the state has it.
    fn apply_to_leaves(&mut self, at: Time, record: &Record) {
        match record {
            Record::Sent { from, message, .. } => self.sent(*from, message),
            Record::Decided { granted, refused, reopened, .. } => {
                if let Some(past) = self.past.as_mut().filter(|past| past.rounds.last() != Some(&at)) {
                    past.rounds.push(at);
                }
                granted.iter().for_each(|grant| self.grant(at, grant));
                refused.iter().for_each(|blocked| self.refuse(blocked));
                reopened.iter().for_each(|reopened| self.reopen(at, reopened));
            }
            Record::Released { leaf, end, consequences, .. } => self.release(at, *leaf, *end, *consequences),
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
            Record::Told { input: Told::Resumed, .. } => self.controllers.begin_anew(),
            Record::Header(_) | Record::Told { .. } | Record::Turn { .. } | Record::Began { .. } => {}
            Record::Observed { .. } | Record::Stopped { .. } => {}
            Record::World { change, origin, .. } => {
                let is_base = matches!(change, Change::Base(_));
                if let Some(past) = self.past.as_mut().filter(|_| !is_base) {
                    past.outside.push(OutsideChange { at, change: *change, origin: *origin });
                }
            }
            Record::Added { .. } => self.add(record),
            Record::Removed { node, .. } => self.remove(at, *node, None),
            Record::TaskEnded { task, end, .. } => self.remove(at, *task, Some(*end)),
            Record::ObjectAdded { object, name, .. } => {
                if object.index() == self.header.names.objects.len() {
                    let mut name = name.clone();
                    ambidex_model::make_legible(&mut name);
                    Arc::make_mut(&mut self.header).names.objects.push(name);
                }
            }
            Record::Stalled { blocked, .. } => blocked.iter().for_each(|blocked| self.refuse(blocked)),
            Record::Granting { .. } | Record::Canceled { .. } => {}
            Record::ObjectRemoved { object, .. } => drop(self.removed.insert(*object)),
            Record::Declined { .. } | Record::Checkpoint { .. } => {}
            Record::Denied { .. } => {}
            Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } => {}
            Record::Infeasible { leaf, reason, consequences, .. } => {
                if let Some(history) = self.states.leaf_mut(*leaf) {
                    history.reason = Some(reason.clone());
                }
                self.states.enter(*leaf, at, Phase::Infeasible);
                self.states.settle(*leaf, at, *consequences);
            }
            Record::TimedOut { node, consequences, .. } => self.states.settle(*node, at, *consequences),
            Record::Ending { .. } | Record::Leaving { .. } => {}
            Record::Cleaning { node, .. } => self.states.begin_cleanup(*node, at),
            Record::Cleaned { node, consequences, .. } => self.cleaned(*node, at, *consequences),
            Record::Reopened { reopened, .. } => self.reopen(at, reopened),
            Record::Overtaken { skips, goal, consequences, .. } => {
                skips.iter().for_each(|skip| self.states.overtake(*skip, at));
                self.states.settle(*goal, at, *consequences);
            }
        }
    }

    fn sent(&mut self, from: NodeId, message: &Message) {
        self.messages += 1;
        match message {
            // A behavior that runs asks for nothing: what it was granted with still says most.
            Message::Answer { running: true, potential: None, .. } if self.leaf(from).is_some() => {}
            Message::Answer { potential, .. } => self.ask(from, *potential),
            Message::Activation | Message::Verdict { .. } | Message::Release { .. } => {}
        }
    }

    fn ask(&mut self, node: NodeId, potential: Option<f64>) {
        if let Some(last) = self.potentials.get_mut(node.index()) {
            *last = potential;
        }
    }

    fn grant(&mut self, at: Time, grant: &Grant) {
        let leaf = grant.leaf();
        for skipped in self.skipped_by(grant) {
            self.states.skip(skipped, at);
        }
        let Some(history) = self.states.leaf_mut(leaf) else { return };
        (history.reason, history.last_end) = (None, None);
        self.states.enter(leaf, at, Phase::Active);
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
        self.is_step_over |= reopened.lapsed().is_some();
        match reopened.cause {
            Cause::Lapse { .. } | Cause::Redo { .. } => {}
            // What was kept is given up, and stays done.
            Cause::Yield => return,
            Cause::Repeat { .. } => {
                self.states.begin_again(&reopened.reset, at, Phase::Again);
                return;
            }
            Cause::Leave => {
                self.states.leave(reopened.node, at);
                return;
            }
            Cause::Retry { .. } => {
                self.states.begin_again(&reopened.reset, at, Phase::Reopened);
                return;
            }
        }
        for leaf in reopened.ended.iter().map(|kept| kept.behavior).chain([reopened.node]) {
            self.states.reopen(leaf, at);
        }
        if let Some(leaf) = self.states.leaf_mut(reopened.node) {
            leaf.reopened = Some(reopened.clone());
        }
    }

    /// What was skipped together with what is not done any more is to be skipped once more, or done.
    fn reopen_skipped(&mut self, at: Time, reopened: &Reopened) {
        let top = self.states.path(reopened.node).take_while(|node| *node != reopened.up_to).last();
        let Some(top) = top else { return };
        let topology = Arc::clone(self.state.topology());
        for leaf in topology.nodes_below(top) {
            let is_skipped = self.states.leaf(leaf).is_some_and(|leaf| leaf.state() == LeafState::Skipped);
            let mut up_to_top = topology.path(leaf).take_while(|node| *node >= top);
            if is_skipped && up_to_top.all(|node| !self.state.is_done(node)) {
                self.states.enter(leaf, at, Phase::Reopened);
            }
        }
    }

    fn release(&mut self, at: Time, leaf: NodeId, end: End, consequences: Consequences) {
        self.is_step_over = true;
        self.controllers.release(leaf);
        self.ask(leaf, None);
        if self.running().contains_key(&leaf) {
            self.last_release = Some(self.last_release.map_or(at, |last| last.max(at)));
        }
        let Some(history) = self.states.leaf_mut(leaf) else { return };
        history.last_end = Some(end);
        if let End::Failed(fault) = end {
            history.fail(at, fault);
        }
        let is_final = consequences.failed.is_some() || self.end.is_some();
        let cause = self.state.interrupted(leaf).filter(|_| end == End::Interrupted);
        if let (Some(past), Some(cause)) = (&mut self.past, cause) {
            past.interruptions.push(Interruption { at, leaf, cause: cause.clone() });
        }
        let phase = Phase::ended(end, is_final, cause);
        self.states.enter(leaf, at, phase);
        self.states.settle(leaf, at, consequences);
        consequences.cleaned.into_iter().for_each(|node| self.states.end_cleanup(node, at));
    }

    fn cleaned(&mut self, node: NodeId, at: Time, consequences: Consequences) {
        self.states.end_cleanup(node, at);
        self.states.settle(node, at, consequences);
    }

    /// A base says where it is all the time. Before the mission begins what controllers say is how things are; afterwards
    /// root says it.
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
            | ControllerMessage::Refused { .. }
            | ControllerMessage::Misreported { .. }
            | ControllerMessage::Diagnosed { .. } => return,
        };
        let Some(state) = message.state() else { return };
        if let ControllerState::Base { pose, .. } = state {
            self.base = Some(pose);
        }
        if self.state.stage() == Stage::Waiting && matches!(message, FromController::Configured { .. }) {
            let movers = self.header.movers.iter().enumerate();
            let moved = movers.filter(|(_, mover)| **mover == Some(controller));
            for change in state.changes(moved.map(|(index, _)| ResourceId::from(index))) {
                self.state.apply(&Record::Observed { at, change });
            }
        }
    }

    fn finish(&mut self, at: Time, end: MissionEnd) {
        if *self.end.get_or_insert(end) == MissionEnd::Done {
            for leaf in self.met() {
                self.states.skip(leaf, at);
            }
            self.states.complete(at);
        }
        if let MissionEnd::Failed(_) = end {
            self.states.fail();
        }
        self.states.end();
    }
}
