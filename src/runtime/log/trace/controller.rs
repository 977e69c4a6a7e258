//! Events of messages between the runtime and controllers.

use tracing::{debug, info, trace, warn};

use ambidex_model::{
    CommandId, ControllerMessage, Diagnostics, FromController, Names, NodeId, PartEnd, Time, ToController,
};

use super::{CONTROLLER, DIAGNOSTICS};
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
        // Its event is made where it is diagnosed, each second.
        ControllerMessage::Diagnosed { .. } => {}
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

pub(super) fn diagnosed(at_s: f64, diagnostics: &Diagnostics, is_change: bool, controller: &str) {
    let Diagnostics { level, message, values, .. } = diagnostics;
    macro_rules! diagnosed {
        ($level:ident) => {
            $level!(
                target: DIAGNOSTICS,
                controller,
                level = level.word(),
                heartbeat_age_ms = values.heartbeat_age_ms,
                worst_gap_ms = values.worst_gap_ms,
                states_per_s = values.states_per_s,
                attachments = values.attachments,
                generation = values.generation,
                refused = values.refused,
                foreign = values.foreign,
                queued = values.queued,
                last_fault = values.last_fault.map(display),
                inhibited = values.inhibited.map(display),
                hung = values.hung,
                at_s,
                "{message}"
            )
        };
    }
    if is_change { diagnosed!(info) } else { diagnosed!(debug) }
}
