//! What the runtime and a controller tell each other, in words.

use ambidex_model::{ControllerMessage, FromController, Mode, Names, ToController};
use ambidex_record::words;

/// What is said, and whether the controller says it.
pub(super) fn said(message: &ControllerMessage, names: &Names) -> (String, bool) {
    match message {
        ControllerMessage::Attached => ("attached".into(), true),
        ControllerMessage::Told { message, .. } => (told(message, names), false),
        ControllerMessage::Joined { id, .. } => (format!("shares goal {}", words::goal(*id)), false),
        ControllerMessage::Heard { message } => (heard(message), true),
        ControllerMessage::Refused { why, .. } => (format!("something that is not used: {why}"), true),
        ControllerMessage::Lost { .. } => ("lost".into(), true),
    }
}

fn told(message: &ToController, names: &Names) -> String {
    match message {
        ToController::Configure { generation, speed, .. } => {
            format!("configuration: generation {generation}, speed {speed}")
        }
        ToController::Goal { id, mode, command } => {
            let lasts = match mode {
                Mode::Achieve => "",
                Mode::Maintain => ", until told to stop",
            };
            format!("goal {}: {}{lasts}", words::goal(*id), words::command(command, names))
        }
        ToController::Cancel { id } => format!("stop goal {}", words::goal(*id)),
    }
}

fn heard(message: &FromController) -> String {
    match message {
        FromController::Configured { generation, .. } => format!("configured, generation {generation}"),
        FromController::Accepted { id, .. } => format!("accepted goal {}", words::goal(*id)),
        FromController::Rejected { id, why } => format!("rejected goal {}: {why}", words::goal(*id)),
        FromController::Feedback { id, progress, .. } => {
            format!("goal {} is at {:.0} %", words::goal(*id), progress * 100.0)
        }
        FromController::Result { id, end, began, ended, .. } => {
            let took_s = (*ended - *began).as_secs_f64();
            format!("goal {} {} after {took_s:.2} s", words::goal(*id), words::part_end(*end))
        }
    }
}
