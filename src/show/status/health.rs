//! How well each controller is, and what it does.

use ambidex_model::{ControllerId, Diagnosis, Diagnostics, Level, Loss, Names, Time};
use ambidex_record::{ActiveCommand, ControllerView, History, LastError, Presence};

use super::snapshot::{ControllerRow, DiagnosticsRow, GoalRow, Phase};
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
    let diagnostics = history.controllers().diagnostics(id).map(|(_, diagnostics)| diagnostics);
    let (health, why) = health(history, id, phase, now);
    let is_living = matches!(phase, Phase::Waiting | Phase::Running);
    let (health, why) =
        diagnostics.filter(|_| is_living).and_then(|known| beside(known, health)).unwrap_or((health, why));
    let goal = |command: &ActiveCommand| GoalRow {
        behaviors: command.holders().iter().map(|&leaf| names.node(leaf).to_owned()).collect(),
        verb: verb(command),
        mode: command.mode,
        progress: command.progress,
    };
    let goals = history.controllers().commands(id).map(goal).collect();
    let diagnostics = diagnostics.map(|diagnostics| DiagnosticsRow::new(diagnostics, false));
    ControllerRow { name: names.controller(id).to_owned(), health, why, goals, diagnostics }
}

/// What only the diagnosis knows: it counts what no record tells. What went wrong by the records comes first, since they
/// tell since when and with what.
fn beside(diagnostics: &Diagnostics, health: Level) -> Option<(Level, String)> {
    let adds = match diagnostics.message {
        Diagnosis::Late | Diagnosis::Doubled | Diagnosis::Backlog => health == Level::Ok,
        Diagnosis::Unheard(_) => health == Level::Stale,
        Diagnosis::Serves | Diagnosis::Unconfigured | Diagnosis::Troubled(_) => false,
        Diagnosis::Lost(_) | Diagnosis::Absent => false,
    };
    adds.then(|| (diagnostics.level, diagnostics.message.to_string()))
}

impl DiagnosticsRow {
    /// What is said of a controller, by its daemon itself or by the log.
    pub(super) fn new(diagnostics: &Diagnostics, live: bool) -> Self {
        let Diagnostics { level, message, values, .. } = *diagnostics;
        Self { level, message: message.to_string(), live, values }
    }
}

fn health(history: &History, id: ControllerId, phase: Phase, now: Time) -> (Level, String) {
    let Some(view) = history.controllers().view(id) else {
        let never = if matches!(phase, Phase::Ended | Phase::Gone) { "it never attached" } else { "not yet attached" };
        return (Level::Stale, never.into());
    };
    match (view.presence, phase) {
        (Presence::Lost, _) => {
            if let Some((_, Loss::Inhibited(why))) = history.lost(id) {
                return (Level::Error, format!("inhibited since {}: {why}", view.since));
            }
            let why = history.lost(id).map_or(String::new(), |(_, why)| format!(": {why}"));
            return (Level::Error, format!("lost at {}{why}", view.since));
        }
        (Presence::Attached | Presence::Configured, Phase::Gone) => {
            return (Level::Stale, "the daemon is gone".into());
        }
        (Presence::Attached, _) => return (Level::Warn, "attached, not yet configured".into()),
        (Presence::Configured, _) => {}
    }
    if let Some(silent_s) = silent_s(history, id, view, phase, now) {
        return (Level::Stale, format!("silent for {silent_s:.1} s while it has a goal"));
    }
    match &view.error {
        Some(error) => (Level::Warn, error_sentence(error, history.names())),
        None => (Level::Ok, occupation(history, id)),
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
