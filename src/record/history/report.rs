//! What came of a mission, as `--json` prints it.

use ambidex_model::{MissionEnd, NodeId};
use serde::Serialize;

use super::History;

/// What came of a mission.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MissionReport {
    /// The mission's name.
    pub mission: String,
    /// How it ended, in a word.
    pub outcome: MissionOutcome,
    /// What was granted between two releases; names sorted.
    pub steps: Vec<Vec<String>>,
    /// What was done without running, in the order in which that was settled.
    pub skipped: Vec<String>,
    /// How many rounds were decided.
    pub rounds: u32,
    /// How many messages went between nodes.
    pub messages: u64,
    /// Robot seconds from the first decision to the last release.
    pub makespan_s: f64,
}

/// How a mission ended, in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, strum::IntoStaticStr)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum MissionOutcome {
    /// The task is complete.
    Done,
    /// The task failed, or what carries it did.
    Failed,
    /// Nothing runs and nothing can.
    Stalled,
    /// It was told to end.
    Canceled,
}

impl MissionOutcome {
    /// The word for it.
    pub fn word(self) -> &'static str {
        self.into()
    }
}

impl From<MissionEnd> for MissionOutcome {
    fn from(end: MissionEnd) -> Self {
        match end {
            MissionEnd::Done => Self::Done,
            MissionEnd::Stalled => Self::Stalled,
            MissionEnd::Canceled => Self::Canceled,
            MissionEnd::Failed(_)
            | MissionEnd::ControllerLost(_)
            | MissionEnd::NotAttached
            | MissionEnd::NodeLost(_)
            | MissionEnd::TaskLost => Self::Failed,
        }
    }
}

impl History {
    /// The report, with names; none before the end. Its steps are those that are kept.
    pub fn report(&self) -> Option<MissionReport> {
        let name = |leaf: NodeId| self.names().node(leaf).to_owned();
        let steps = self.steps().iter().map(|step| {
            let mut names: Vec<String> = step.leaves.iter().copied().map(name).collect();
            names.sort();
            names
        });
        Some(MissionReport {
            mission: self.header().mission.clone(),
            outcome: self.end()?.into(),
            steps: steps.collect(),
            skipped: self.skipped().into_iter().map(|(leaf, _)| name(leaf)).collect(),
            rounds: self.rounds(),
            messages: self.messages(),
            makespan_s: self.makespan_s(),
        })
    }
}
