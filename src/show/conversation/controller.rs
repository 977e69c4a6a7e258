//! What the runtime and a controller tell each other, in words.

use ambidex_model::{ControllerMessage, FromController, Mode, Names, ToController};
use ambidex_record::format;

/// What is said, and whether the controller says it.
pub(super) fn said(message: &ControllerMessage, names: &Names) -> (String, bool) {
    match message {
        ControllerMessage::Attached => ("attached".into(), true),
        ControllerMessage::Told { message, .. } => (told(message, names), false),
        ControllerMessage::Joined { id, .. } => (format!("shares goal {}", format::goal(*id)), false),
        ControllerMessage::Heard { message } => (heard(message), true),
        ControllerMessage::Refused { why, .. } => (format!("something that is not used: {why}"), true),
        ControllerMessage::Misreported { report, why } => (format!("{report}, which is not heard: {why}"), true),
        ControllerMessage::Lost { why } => (format!("lost: {why}"), true),
        ControllerMessage::Diagnosed { level, message, .. } => (format!("{level}: {message}"), true),
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
            format!("goal {}: {}{lasts}", format::goal(*id), format::command(command, names))
        }
        ToController::Cancel { id } => format!("stop goal {}", format::goal(*id)),
    }
}

fn heard(message: &FromController) -> String {
    match message {
        FromController::Configured { generation, .. } => format!("configured, generation {generation}"),
        FromController::Accepted { id, .. } => format!("accepted goal {}", format::goal(*id)),
        FromController::Rejected { id, why } => format!("rejected goal {}: {why}", format::goal(*id)),
        FromController::Feedback { id, progress, .. } => {
            format!("goal {} is at {:.0} %", format::goal(*id), progress * 100.0)
        }
        FromController::Result { id, end, began, ended, .. } => {
            let took_s = (*ended - *began).as_secs_f64();
            format!("goal {} {} after {took_s:.2} s", format::goal(*id), format::part_end(*end))
        }
    }
}
