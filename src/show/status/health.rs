//! How well each controller is, and what it does.

use ambidex_model::{ControllerId, Loss, Names, Time};
use ambidex_record::{ActiveCommand, ControllerView, History, LastError, Presence};

use super::snapshot::{ControllerRow, GoalRow, Health, Phase};
use crate::text::listed;

/// Wall seconds without a word from a controller that has a goal until it counts as silent: five feedbacks.
const SILENT_S: f64 = 0.5;

/// Every controller.
pub(super) fn rows(history: &History, phase: Phase, now: Time) -> Vec<ControllerRow> {
    let ids = (0..history.names().controllers.len()).map(ControllerId::from);
    ids.map(|id| row(history, id, phase, now)).collect()
}

fn row(history: &History, id: ControllerId, phase: Phase, now: Time) -> ControllerRow {
    let names = history.names();
    let (health, why) = health(history, id, phase, now);
    let goal = |command: &ActiveCommand| GoalRow {
        behaviors: command.holders().iter().map(|&leaf| names.node(leaf).to_owned()).collect(),
        verb: verb(command),
        mode: command.mode,
        progress: command.progress,
    };
    let goals = history.controllers().commands(id).map(goal).collect();
    ControllerRow { name: names.controller(id).to_owned(), health, why, goals }
}

fn health(history: &History, id: ControllerId, phase: Phase, now: Time) -> (Health, String) {
    let Some(view) = history.controllers().view(id) else {
        let never = if matches!(phase, Phase::Ended | Phase::Gone) { "it never attached" } else { "not yet attached" };
        return (Health::Stale, never.into());
    };
    match (view.presence, phase) {
        (Presence::Lost, _) => {
            if let Some((_, Loss::Inhibited(why))) = history.lost(id) {
                return (Health::Error, format!("inhibited since {}: {why}", view.since));
            }
            let why = history.lost(id).map_or(String::new(), |(_, why)| format!(": {why}"));
            return (Health::Error, format!("lost at {}{why}", view.since));
        }
        (Presence::Attached | Presence::Configured, Phase::Gone) => {
            return (Health::Stale, "the daemon is gone".into());
        }
        (Presence::Attached, _) => return (Health::Warn, "attached, not yet configured".into()),
        (Presence::Configured, _) => {}
    }
    if let Some(silent_s) = silent_s(history, id, view, phase, now) {
        return (Health::Stale, format!("silent for {silent_s:.1} s while it has a goal"));
    }
    match &view.error {
        Some(error) => (Health::Warn, error_sentence(error, history.names())),
        None => (Health::Ok, occupation(history, id)),
    }
}

/// Wall seconds since a word from a controller that should talk; none while all is as it should be.
fn silent_s(history: &History, id: ControllerId, view: &ControllerView, phase: Phase, now: Time) -> Option<f64> {
    history.controllers().commands(id).next().filter(|_| phase == Phase::Running)?;
    let silent_s = (now - view.since).as_secs_f64() / history.controllers().speed()?;
    (silent_s > SILENT_S).then_some(silent_s)
}

fn occupation(history: &History, id: ControllerId) -> String {
    let verbs: Vec<&str> = history.controllers().commands(id).map(verb).collect();
    if verbs.is_empty() { "idle".into() } else { verbs.join(", ") }
}

fn verb(command: &ActiveCommand) -> &'static str {
    if command.is_canceled { "stopping" } else { command.verb }
}

fn error_sentence(error: &LastError, names: &Names) -> String {
    let goal = |leaves: &[_]| match leaves {
        [] => "a goal".to_owned(),
        some => listed(some.iter().map(|&leaf| names.node(leaf))),
    };
    match error {
        LastError::Rejected { leaves, why } => format!("rejected {}: {why}", goal(leaves)),
        LastError::Aborted { leaves } => format!("gave up {}", goal(leaves)),
        LastError::Misreported { report, why } => format!("its report that {report} is not heard: {why}"),
        LastError::Refused(why) => format!("a message of it was not used: {why}"),
    }
}
