//! Many runs of one mission in which something goes wrong by chance: how often it is done, how long it takes, and why
//! not.

mod table;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use ambidex_model::{Failures, FlawKind, Mishap, MissionEnd};
use ambidex_record::{History, MissionOutcome};
use serde::Serialize;

use crate::text::shortest_cause;
pub use table::text;

/// What can go wrong, in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, strum::IntoStaticStr)]
#[serde(rename_all = "snake_case")]
pub enum Wrong {
    /// A controller gives up.
    #[strum(serialize = "a behavior gives up")]
    GivesUp,
    /// A behavior does not end by itself.
    #[strum(serialize = "a behavior hangs")]
    Hangs,
    /// A behavior takes longer.
    #[strum(serialize = "a behavior is late")]
    Late,
    /// A gripper loses what it holds.
    #[strum(serialize = "something is dropped")]
    Drops,
    /// The process of a controller ends.
    #[strum(serialize = "a controller is lost")]
    Lost,
    /// A controller does nothing any more.
    #[strum(serialize = "a controller hangs")]
    Hung,
    /// An emergency stop is pressed.
    #[strum(serialize = "an emergency stop is pressed")]
    Inhibited,
    /// A fact is set or cleared, an object is moved.
    #[strum(serialize = "the world changes")]
    World,
    /// The disk of the log is full or slow.
    #[strum(serialize = "the disk is full or slow")]
    Disk,
    /// The mission is told to end.
    #[strum(serialize = "the mission is told to end")]
    Canceled,
}

/// Why a mission did not get to its end, without when.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Cause {
    /// What it ended at: a behavior, a node or a controller; none where it is nobody's.
    pub at: Option<String>,
    /// What was wrong there.
    pub why: String,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// What went wrong follows from it.
    pub seed: u64,
    /// How it ended.
    pub outcome: MissionOutcome,
    /// Why it was not done; none where it was.
    pub cause: Option<Cause>,
    /// Robot seconds from the first decision to the last release.
    pub makespan_s: f64,
    /// How often what went wrong.
    pub wrong: BTreeMap<Wrong, u32>,
}

impl Trial {
    /// What a run came to that has ended; none of one that has not.
    pub fn of(seed: u64, history: &History, failures: &Failures) -> Option<Self> {
        let end = history.end()?;
        let mut wrong = BTreeMap::new();
        let flaws = failures.flaws.iter().map(|flaw| of_flaw(flaw.kind));
        let mishaps = failures.mishaps.iter().filter(|(at, _)| *at <= history.now());
        for kind in flaws.chain(mishaps.filter_map(|(_, mishap)| of_mishap(*mishap))) {
            *wrong.entry(kind).or_default() += 1;
        }
        let cause = (end != MissionEnd::Done).then(|| {
            let (at, why) = shortest_cause(history, end);
            Cause { at, why }
        });
        Some(Self { seed, outcome: end.into(), cause, makespan_s: history.makespan_s(), wrong })
    }
}

fn of_flaw(kind: FlawKind) -> Wrong {
    match kind {
        FlawKind::Fails => Wrong::GivesUp,
        FlawKind::Hangs => Wrong::Hangs,
        FlawKind::Late(_) => Wrong::Late,
        FlawKind::Drops(_) => Wrong::Drops,
    }
}

/// Who returns does nothing wrong.
fn of_mishap(mishap: Mishap) -> Option<Wrong> {
    match mishap {
        Mishap::Lose(_) => Some(Wrong::Lost),
        Mishap::Hang(_) => Some(Wrong::Hung),
        Mishap::Inhibit(_) => Some(Wrong::Inhibited),
        Mishap::World(_) => Some(Wrong::World),
        Mishap::Disk(_) => Some(Wrong::Disk),
        Mishap::Cancel => Some(Wrong::Canceled),
        Mishap::Return(_) => None,
    }
}

/// All runs of one mission.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trials {
    /// The mission's name.
    pub mission: String,
    /// Of an attempt of a behavior to go wrong, from 0 to 1.
    pub probability: f64,
    /// Robot seconds that it takes when nothing goes wrong; none where it is not done then either.
    pub undisturbed_s: Option<f64>,
    /// The runs in the order of their seeds.
    pub trials: Vec<Trial>,
}

/// Runs that ended alike.
#[derive(Debug, Clone, PartialEq)]
struct Group<'a> {
    cause: &'a Cause,
    outcome: MissionOutcome,
    count: usize,
    /// One of them.
    seed: u64,
}

impl Trials {
    fn count(&self, outcome: MissionOutcome) -> usize {
        self.trials.iter().filter(|trial| trial.outcome == outcome).count()
    }

    /// Times of the runs that were done, in their order; robot seconds.
    fn times_s(&self) -> Vec<f64> {
        let done = self.trials.iter().filter(|trial| trial.outcome == MissionOutcome::Done);
        let mut times: Vec<f64> = done.map(|trial| trial.makespan_s).collect();
        times.sort_by(f64::total_cmp);
        times
    }

    /// Why runs were not done, the most frequent first.
    fn groups(&self) -> Vec<Group<'_>> {
        let mut groups: BTreeMap<(&Cause, &str), Group<'_>> = BTreeMap::new();
        for trial in &self.trials {
            let Some(cause) = &trial.cause else { continue };
            let fresh = Group { cause, outcome: trial.outcome, count: 0, seed: trial.seed };
            groups.entry((cause, trial.outcome.word())).or_insert(fresh).count += 1;
        }
        let mut groups: Vec<_> = groups.into_values().collect();
        groups.sort_by_key(|group| std::cmp::Reverse(group.count));
        groups
    }

    /// Of each kind of failure, in how many runs it happened, and how many of these were done.
    fn survived(&self) -> BTreeMap<Wrong, (usize, usize)> {
        let mut survived = BTreeMap::new();
        for trial in &self.trials {
            for kind in trial.wrong.keys() {
                let (runs, done): &mut (usize, usize) = survived.entry(*kind).or_default();
                *runs += 1;
                *done += usize::from(trial.outcome == MissionOutcome::Done);
            }
        }
        survived
    }
}

/// Bounds of a share of which so many of so many were seen, with 95 % confidence: Wilson's interval.
fn bounds(seen: usize, of: usize) -> (f64, f64) {
    const Z: f64 = 1.96;
    let (count, share) = (of as f64, seen as f64 / of as f64);
    let middle = (share + Z * Z / (2.0 * count)) / (1.0 + Z * Z / count);
    let half = Z / (1.0 + Z * Z / count) * (share * (1.0 - share) / count + Z * Z / (4.0 * count * count)).sqrt();
    ((middle - half).max(0.0), (middle + half).min(1.0))
}
