//! What controllers are told: each command once, for a behavior that runs, and each ends once.

use std::collections::{BTreeMap, BTreeSet};

use ambidex_model::{
    CommandId, ControllerId, ControllerMessage, FromController, NodeId, PartEnd, Record, Time, ToController, Told,
};

use super::run::Run;
use super::{Found, LookedAt, Rule};

/// Commands of the whole run.
#[derive(Debug, Default)]
pub(super) struct Commands {
    open: BTreeMap<(ControllerId, CommandId), NodeId>,
    told: BTreeSet<(ControllerId, CommandId)>,
    /// When the log began with a run that was saved: what was under way then was told before.
    saved: Option<Time>,
    /// A runtime was killed: what it told last may be lacking, and may have been done.
    pub(super) was_resumed: bool,
    /// Results that were used.
    pub(super) ended: BTreeMap<(ControllerId, CommandId), PartEnd>,
}

impl Commands {
    pub(super) fn take(&mut self, run: &Run, record: &Record, found: &mut Found, looked_at: &mut LookedAt) {
        if let Record::Controller { controller, message, at } = record {
            let was_told_before = self.saved == Some(*at);
            self.message(run, (*controller, was_told_before), message, found, looked_at);
        } else if let Record::Checkpoint { at, .. } = record {
            self.saved = Some(*at);
        } else if let Record::Told { input: Told::Resumed, .. } = record {
            // What was under way ended with the runtime.
            self.open.clear();
            self.was_resumed = true;
        }
    }

    fn message(
        &mut self,
        run: &Run,
        (id, was_told_before): (ControllerId, bool),
        message: &ControllerMessage,
        found: &mut Found,
        looked_at: &mut LookedAt,
    ) {
        let name = run.names.controller(id);
        match message {
            ControllerMessage::Told { leaf, message: ToController::Goal { id: command, .. } } => {
                looked_at.commands += 1;
                let Some(leaf) = *leaf else {
                    found.push(Rule::Commands, format!("{name} is told to do something for nobody"));
                    return;
                };
                if !run.running.contains_key(&leaf) && !was_told_before {
                    let leaf = run.name(leaf);
                    found
                        .push(Rule::Commands, format!("{name} is told to do something for {leaf}, which does not run"));
                }
                if !self.told.insert((id, *command)) {
                    found.push(Rule::Commands, format!("{name} is told command {} twice", shown(*command)));
                }
                self.open.insert((id, *command), leaf);
            }
            ControllerMessage::Heard { message } if message.is_last() => {
                let Some(command) = message.id() else { return };
                if self.open.remove(&(id, command)).is_none() {
                    let said = format!("{name} ends command {}, which is not under way", shown(command));
                    found.push(Rule::Commands, said);
                }
                if let FromController::Result { end, .. } = message {
                    self.ended.insert((id, command), *end);
                }
            }
            ControllerMessage::Lost { .. } => self.open.retain(|(controller, _), _| *controller != id),
            ControllerMessage::Told { .. } | ControllerMessage::Heard { .. } | ControllerMessage::Attached => {}
            ControllerMessage::Joined { .. } | ControllerMessage::Refused { .. } => {}
            ControllerMessage::Misreported { .. } | ControllerMessage::Diagnosed { .. } => {}
        }
    }

    /// Whether a command was over before the log began, with a run that was saved.
    pub(super) fn is_before(&self, controller: ControllerId, command: CommandId) -> bool {
        let first = self.told.iter().find(|(of, _)| *of == controller);
        self.saved.is_some() && first.is_none_or(|(_, first)| command < *first)
    }

    /// Whether a command stands in the log.
    pub(super) fn is_told(&self, id: ControllerId, command: CommandId) -> bool {
        self.told.contains(&(id, command))
    }

    /// The run is over.
    pub(super) fn finish(&self, run: &Run, found: &mut Found) {
        for ((id, command), leaf) in &self.open {
            let is_away = run.mission.as_ref().is_some_and(|mission| {
                let moved = mission.robot.moved_by(*id);
                moved.into_iter().any(|resource| run.services.get(&resource).is_some_and(|at| !at.is_available()))
            });
            if !is_away {
                let (name, leaf) = (run.names.controller(*id), run.name(*leaf));
                let said = format!("command {} of {name} for {leaf} never ends", shown(*command));
                found.push(Rule::Commands, said);
            }
        }
    }
}

pub(super) fn shown(command: CommandId) -> String {
    format!("{}.{}", command.generation, command.number)
}
