//! Which behaviors a controller's command is for, as long as it is under way.

use std::collections::BTreeMap;

use ambidex_model::{CommandId, ControllerId, ControllerMessage, FromController, NodeId, Record, ToController};

type Key = (ControllerId, CommandId);

/// The commands under way with their behaviors.
#[derive(Debug, Clone, Default)]
pub(super) struct Commands {
    holders: BTreeMap<Key, Vec<NodeId>>,
    over: Option<Key>,
}

impl Commands {
    /// Takes the next record; a command that it ends is known until the one after.
    pub(super) fn add(&mut self, record: &Record) {
        if let Some(over) = self.over.take() {
            self.holders.remove(&over);
        }
        match record {
            Record::Controller { controller, message, .. } => self.message(*controller, message),
            Record::Released { leaf, .. } => self.leave(*leaf),
            Record::Header(_)
            | Record::Sent { .. }
            | Record::Decided { .. }
            | Record::World { .. }
            | Record::Resource { .. }
            | Record::Ended { .. } => {}
        }
    }

    /// The behaviors that a command is for; empty for one that is not under way.
    pub(super) fn holders(&self, controller: ControllerId, id: CommandId) -> &[NodeId] {
        self.holders.get(&(controller, id)).map_or(&[], Vec::as_slice)
    }

    fn message(&mut self, controller: ControllerId, message: &ControllerMessage) {
        match message {
            ControllerMessage::Told { leaf, message: ToController::Goal { id, .. } } => {
                self.holders.insert((controller, *id), leaf.iter().copied().collect());
            }
            ControllerMessage::Told {
                message: ToController::Configure { .. } | ToController::Cancel { .. }, ..
            } => {}
            ControllerMessage::Joined { leaf, id } => {
                self.holders.entry((controller, *id)).or_default().push(*leaf);
            }
            ControllerMessage::Heard { message } => match message {
                FromController::Rejected { id, .. } | FromController::Result { id, .. } => {
                    self.over = Some((controller, *id));
                }
                FromController::Configured { .. }
                | FromController::Accepted { .. }
                | FromController::Feedback { .. } => {}
            },
            ControllerMessage::Lost { .. } => self.holders.retain(|(owner, _), _| *owner != controller),
            ControllerMessage::Attached | ControllerMessage::Refused { .. } => {}
        }
    }

    /// A behavior that ended shares nothing any more; a command that was its alone stays its own to the end.
    fn leave(&mut self, leaf: NodeId) {
        for holders in self.holders.values_mut().filter(|holders| holders.len() > 1) {
            holders.retain(|holder| *holder != leaf);
        }
    }
}
