//! How well each controller is, and what it does.

use crate::crew::{Member, Presence, Trouble, UnderWay};
use crate::text::listed;
use ambidex_model::{ControllerId, Header, Names, Time};

use super::Status;
use super::snapshot::{ControllerRow, GoalRow, Health, Phase};

/// Wall seconds without a word from a controller that has a goal until it counts as silent: five feedbacks.
const SILENT_S: f64 = 0.5;

impl Status {
    pub(super) fn controller_rows(&self, header: &Header, phase: Phase, now: Time) -> Vec<ControllerRow> {
        let ids = (0..header.names.controllers.len()).map(ControllerId::from);
        ids.map(|id| self.controller_row(id, &header.names, phase, now)).collect()
    }

    fn controller_row(&self, id: ControllerId, names: &Names, phase: Phase, now: Time) -> ControllerRow {
        let (health, why) = self.health(id, names, phase, now);
        let goal = |command: &UnderWay| GoalRow {
            behaviors: command.leaves.iter().map(|&leaf| names.node(leaf).to_owned()).collect(),
            verb: verb(command),
            mode: command.mode,
            progress: command.progress,
        };
        let goals = self.crew.commands(id).map(goal).collect();
        ControllerRow { name: names.controller(id).to_owned(), health, why, goals }
    }

    fn health(&self, id: ControllerId, names: &Names, phase: Phase, now: Time) -> (Health, String) {
        let Some(member) = self.crew.member(id) else {
            let never =
                if matches!(phase, Phase::Ended | Phase::Gone) { "it never attached" } else { "not yet attached" };
            return (Health::Stale, never.into());
        };
        match (member.presence, phase) {
            (Presence::Lost, _) => return (Health::Error, format!("lost at {}", member.since)),
            (Presence::Attached | Presence::Configured, Phase::Gone) => {
                return (Health::Stale, "the daemon is gone".into());
            }
            (Presence::Attached, _) => return (Health::Warn, "attached, not yet configured".into()),
            (Presence::Configured, _) => {}
        }
        if let Some(silent_s) = self.silent_s(id, member, phase, now) {
            return (Health::Stale, format!("silent for {silent_s:.1} s while it has a goal"));
        }
        match &member.trouble {
            Some(trouble) => (Health::Warn, trouble_sentence(trouble, names)),
            None => (Health::Ok, self.occupation(id)),
        }
    }

    /// Wall seconds since a word from a controller that should talk; none while all is as it should be.
    fn silent_s(&self, id: ControllerId, member: &Member, phase: Phase, now: Time) -> Option<f64> {
        self.crew.commands(id).next().filter(|_| phase == Phase::Running)?;
        let silent_s = (now - member.since).as_secs_f64() / self.crew.speed()?;
        (silent_s > SILENT_S).then_some(silent_s)
    }

    fn occupation(&self, id: ControllerId) -> String {
        let verbs: Vec<&str> = self.crew.commands(id).map(verb).collect();
        if verbs.is_empty() { "idle".into() } else { verbs.join(", ") }
    }
}

fn verb(command: &UnderWay) -> &'static str {
    if command.is_canceled { "stopping" } else { command.verb }
}

fn trouble_sentence(trouble: &Trouble, names: &Names) -> String {
    let goal = |leaves: &[_]| match leaves {
        [] => "a goal".to_owned(),
        some => listed(some.iter().map(|&leaf| names.node(leaf))),
    };
    match trouble {
        Trouble::Rejected { leaves, why } => format!("rejected {}: {why}", goal(leaves)),
        Trouble::Aborted { leaves } => format!("gave up {}", goal(leaves)),
        Trouble::Refused(why) => format!("a message of it was not used: {why}"),
    }
}
