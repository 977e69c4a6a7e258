//! Events of messages between the runtime and controllers.

use tracing::{info, trace, warn};

use ambidex_model::{CommandId, ControllerMessage, FromController, Names, NodeId, PartEnd, Time, ToController};

use super::CONTROLLER;
use ambidex_record::format;

pub(super) fn said(at_s: f64, controller: &str, message: &ControllerMessage, names: &Names) {
    match message {
        ControllerMessage::Attached => {
            info!(target: CONTROLLER, controller, at_s, "attached");
        }
        ControllerMessage::Told { leaf, message } => told(at_s, controller, *leaf, message, names),
        ControllerMessage::Joined { leaf, id } => trace!(
            target: CONTROLLER,
            controller,
            goal = %format::goal(*id),
            leaf = names.node(*leaf),
            at_s,
            "joined"
        ),
        ControllerMessage::Heard { message } => heard(at_s, controller, message),
        ControllerMessage::Refused { why, .. } => {
            warn!(target: CONTROLLER, controller, reason = %why, at_s, "refused");
        }
        ControllerMessage::Misreported { report, why } => {
            warn!(target: CONTROLLER, controller, %report, reason = %why, at_s, "a report was refused");
        }
        ControllerMessage::Lost { why } => warn!(target: CONTROLLER, controller, at_s, %why, "lost"),
    }
}

fn told(at_s: f64, controller: &str, leaf: Option<NodeId>, message: &ToController, names: &Names) {
    match message {
        ToController::Configure { generation, speed, .. } => trace!(
            target: CONTROLLER,
            controller,
            generation,
            speed,
            at_s,
            "configure"
        ),
        ToController::Goal { id, mode, command } => trace!(
            target: CONTROLLER,
            controller,
            goal = %format::goal(*id),
            leaf = leaf.map(|leaf| names.node(leaf)),
            mode = %format::word(*mode),
            command = %format::command(command, names),
            at_s,
            "goal"
        ),
        ToController::Cancel { id } => trace!(
            target: CONTROLLER,
            controller,
            goal = %format::goal(*id),
            leaf = leaf.map(|leaf| names.node(leaf)),
            at_s,
            "cancel"
        ),
    }
}

fn heard(at_s: f64, controller: &str, message: &FromController) {
    match message {
        FromController::Configured { generation, .. } => {
            trace!(target: CONTROLLER, controller, generation, at_s, "configured");
        }
        FromController::Accepted { id, at } => trace!(
            target: CONTROLLER,
            controller,
            goal = %format::goal(*id),
            accepted_s = at.seconds(),
            at_s,
            "accepted"
        ),
        FromController::Rejected { id, why } => warn!(
            target: CONTROLLER,
            controller,
            goal = %format::goal(*id),
            reason = %why,
            at_s,
            "rejected"
        ),
        FromController::Feedback { id, progress, .. } => trace!(
            target: CONTROLLER,
            controller,
            goal = %format::goal(*id),
            progress,
            at_s,
            "feedback"
        ),
        FromController::Result { id, end, began, ended, .. } => result(at_s, controller, *id, *end, (*began, *ended)),
    }
}

fn result(at_s: f64, controller: &str, id: CommandId, end: PartEnd, (began, ended): (Time, Time)) {
    macro_rules! result {
        ($level:ident) => {
            $level!(
                target: CONTROLLER,
                controller,
                goal = %format::goal(id),
                end = format::part_end(end),
                began_s = began.seconds(),
                ended_s = ended.seconds(),
                at_s,
                "result"
            )
        };
    }
    match end {
        PartEnd::Succeeded | PartEnd::Canceled => result!(trace),
        PartEnd::Aborted | PartEnd::Inhibited(_) => result!(warn),
    }
}
