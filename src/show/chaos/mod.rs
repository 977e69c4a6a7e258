//! Runs under chaos: how they ended, what was done to them, and what was found.

mod table;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use ambidex_record::audit::LookedAt;
use serde::Serialize;

pub use table::text;

/// How a run ended, by the exit code of its last daemon.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, strum::IntoStaticStr, strum::VariantArray,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "lowercase")]
pub enum Outcome {
    /// The mission is done.
    Done,
    /// It failed.
    Failed,
    /// Nothing ran and nothing could.
    Stalled,
    /// A controller was lost, or did not attach.
    Lost,
    /// It was told to end.
    Canceled,
    /// Its log is incomplete.
    #[strum(serialize = "log incomplete")]
    LogIncomplete,
    /// It was killed before it had a log.
    #[strum(serialize = "not begun")]
    NotBegun,
    /// It ended by a signal, or with another code.
    #[default]
    #[strum(serialize = "ended otherwise")]
    Otherwise,
}

impl Outcome {
    /// What an exit code says; none is a signal.
    pub fn of(code: Option<i32>) -> Self {
        match code {
            Some(0) => Self::Done,
            Some(1) => Self::Failed,
            Some(3) => Self::Stalled,
            Some(4) => Self::Lost,
            Some(5) => Self::LogIncomplete,
            Some(130) => Self::Canceled,
            Some(_) | None => Self::Otherwise,
        }
    }
}

/// One run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ChaosRun {
    /// What was done follows from it.
    pub seed: u64,
    /// The mission's name.
    pub mission: String,
    /// How it ended.
    pub outcome: Outcome,
    /// How often what was done.
    pub done: BTreeMap<&'static str, u32>,
    /// What does not hold.
    pub findings: Vec<String>,
    /// Records of its log.
    pub records: u64,
    /// What there was to be looked at.
    pub looked_at: LookedAt,
    /// Wall seconds.
    pub wall_s: f64,
}

/// All runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChaosReport {
    /// The seed of the first run.
    pub seed: u64,
    /// In the order of their seeds.
    pub runs: Vec<ChaosRun>,
}
