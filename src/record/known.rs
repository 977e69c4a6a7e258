//! What a log has to begin with where it goes on in the place of another: who its run is, and what controllers are at.

use std::collections::BTreeMap;

use super::history::History;
use ambidex_model::state::Saved;
use ambidex_model::{ControllerId, ControllerMessage, FromController, Record, Time, ToController};

/// Commands that are remembered before those that have ended are looked for.
const COMMANDS: usize = 64;

/// The records of a log that no saved state stands for.
#[derive(Debug, Clone, Default)]
pub struct Beginning {
    header: Option<Record>,
    controllers: BTreeMap<ControllerId, Known>,
}

/// The last words from and to a controller.
#[derive(Debug, Clone, Default)]
struct Known {
    attached: Option<Record>,
    configured: Option<Record>,
    /// What it said of itself last, as an answer to its configuration.
    said: Option<Record>,
    /// Commands, some of which may have ended.
    commands: Vec<Record>,
}

impl Beginning {
    /// Takes the next record of the log; `history` has it already.
    pub fn take(&mut self, record: &Record, history: &History) {
        if let Record::Header(_) = record {
            self.header = Some(record.clone());
        }
        let Record::Controller { controller, message, .. } = record else { return };
        let known = self.controllers.entry(*controller).or_default();
        match message {
            // Whatever it was told before nobody knows any more.
            ControllerMessage::Attached => {
                *known = Known { attached: Some(record.clone()), ..Known::default() };
            }
            ControllerMessage::Told { message: ToController::Configure { .. }, .. } => {
                known.configured = Some(record.clone());
            }
            ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } => {
                known.commands.push(record.clone());
                if known.commands.len() > COMMANDS {
                    known.commands.retain(|told| is_active(told, history));
                }
            }
            ControllerMessage::Heard { message } => known.hear(*controller, message),
            ControllerMessage::Lost { .. } => {
                *known = Known { configured: known.configured.take(), ..Known::default() }
            }
            ControllerMessage::Refused { .. } => {}
            ControllerMessage::Misreported { .. } | ControllerMessage::Diagnosed { .. } => {}
        }
    }

    /// What a log begins with that follows from what was saved: its header, that, and what controllers are at, as if all
    /// of it had been said at that moment.
    pub fn records(&self, history: &History, at: Time, saved: &Saved) -> Vec<Record> {
        let saved = serde_json::to_string(saved).expect("a state is plain");
        let checkpoint = Record::Checkpoint { at, begun: history.begun().unwrap_or(at), saved };
        let told = self.controllers.values().flat_map(|known| {
            let commands = known.commands.iter().filter(|told| is_active(told, history));
            known.attached.iter().chain(&known.configured).chain(&known.said).chain(commands)
        });
        let told = told.cloned().map(|mut told| {
            told.set_at(at);
            told
        });
        self.header.iter().cloned().chain([checkpoint]).chain(told).collect()
    }
}

impl Known {
    fn hear(&mut self, controller: ControllerId, message: &FromController) {
        let configured = self.configured.as_ref().map(|record| (record.at(), record));
        let Some((at, Record::Controller { message: ControllerMessage::Told { message: told, .. }, .. })) = configured
        else {
            return;
        };
        if let (ToController::Configure { generation, .. }, Some(state)) = (told, message.state()) {
            let message = FromController::Configured { generation: *generation, state };
            let message = ControllerMessage::Heard { message };
            self.said = Some(Record::Controller { at, controller, message });
        }
    }
}

/// Whether the command that a record tells has not ended.
fn is_active(told: &Record, history: &History) -> bool {
    let Record::Controller { controller, message, .. } = told else { return false };
    let id = match message {
        ControllerMessage::Told { message: ToController::Goal { id, .. }, .. } => *id,
        ControllerMessage::Told { message: ToController::Cancel { id, .. }, .. } => *id,
        ControllerMessage::Joined { id, .. } => *id,
        _ => return false,
    };
    history.controllers().command(*controller, id).is_some()
}
