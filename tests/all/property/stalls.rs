//! Stalls: whether some schedule would have finished the mission, and by which rule of the page it was not taken.

mod flips;
mod search;
mod table;

use std::sync::Mutex;

use ambidex::model::MissionSpec;

use super::compare;
use super::counts::Counts;
use super::generator::Case;
use super::reference::{Freedom, Model, Rule};
use super::run::Event;
use flips::Cause;
use search::{Found, Search};
use table::Table;

/// A moment of a run, and what happened then; a round if no event is told.
pub struct Moment<'a> {
    pub before: Model<'a>,
    pub event: Option<Event>,
}

/// Why a mission stalled (`semantics` 2, "Stall": what another schedule would have finished).
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// A schedule is left that no rule forbids, or nothing that is known has taken it.
    Unexplained(String),
    /// A schedule is left, but for these rules.
    Forbidden(Vec<Rule>),
    /// No schedule was left from some moment on.
    Lost(Cause),
    /// There never was any.
    Unsolvable,
    /// The run and the reference model differ, or something that must always hold did not.
    NotFollowed,
    /// The search was cut off: before it was known whether any is left, or since when none is.
    CutOff(&'static str),
}

const HERE: &str = "whether one is left";
const BEFORE: &str = "since when none is left";

/// One tree in so many is searched in the normal run.
const SHARE: u32 = 20;

/// Whoever stalls could not have been finished, or is stopped by a rule that the page names.
///
/// `AMBIDEX_TREES=20000 cargo test --release --test all property::stalls -- --nocapture` searches as many trees; with
/// `AMBIDEX_SEED` and `AMBIDEX_DEPTH` one alone.
#[test]
fn no_stall_is_left_unexplained() {
    let share = if super::number::<u32>("AMBIDEX_TREES").is_some() { 1 } else { SHARE };
    let table = Mutex::new(Table::default());
    super::for_all("stalls", share, |case| {
        let case = case.certified();
        // Every tree is tried, whatever is found: what is told is the table of all.
        let explained = std::panic::catch_unwind(|| explain(&case));
        let (counts, verdict) = explained.unwrap_or_else(|_| (Counts::default(), Some(Verdict::NotFollowed)));
        let Some(verdict) = verdict else { return counts };
        if super::number::<u64>("AMBIDEX_SEED").is_some() {
            println!("{verdict:?}");
        }
        table.lock().expect("no other failed").add(&case, &verdict);
        counts
    });
    let table = table.into_inner().expect("none failed");
    println!("{table}");
    table.check();
}

fn explain(case: &Case) -> (Counts, Option<Verdict>) {
    let mut moments = Vec::new();
    let counts = compare::following(case, |model, event| {
        moments.push(Moment { before: model.clone(), event: event.cloned() });
    });
    if counts.stalled() == 0 {
        return (counts, None);
    }
    moments.retain(|moment| !moment.before.is_cleaning_up());
    let mission = bounded(case, &moments);
    let verdict = judge(&mission, &moments);
    (counts, Some(verdict))
}

fn judge(mission: &MissionSpec, moments: &[Moment<'_>]) -> Verdict {
    let stalled = &moments.last().expect("a moment").before;
    let from_here = |freedom| Search::new(mission, freedom).from(stalled);
    match from_here(Freedom::NONE) {
        Found::Schedule(schedule) => return Verdict::Unexplained(format!("{schedule:?}")),
        Found::CutOff => return Verdict::CutOff(HERE),
        Found::Nothing => {}
    }
    match from_here(Freedom::of(&Rule::ALL)) {
        Found::Schedule(_) => forbidding(from_here),
        Found::Nothing => flips::last(mission, moments),
        Found::CutOff => Verdict::CutOff(HERE),
    }
}

/// As few rules as it takes: none of them can be left out.
fn forbidding(from_here: impl Fn(Freedom) -> Found) -> Verdict {
    let mut rules = Rule::ALL.to_vec();
    for rule in Rule::ALL.into_iter().rev() {
        let fewer: Vec<Rule> = rules.iter().copied().filter(|other| *other != rule).collect();
        if let Found::Schedule(_) = from_here(Freedom::of(&fewer)) {
            rules = fewer;
        }
    }
    Verdict::Forbidden(rules)
}

/// What is done without end is done once more than it was.
fn bounded(case: &Case, moments: &[Moment<'_>]) -> MissionSpec {
    let mut mission = MissionSpec::clone(&case.mission);
    for (node, repeat) in &mut mission.tree.repeats {
        let ended = moments.iter().map(|moment| moment.before.iterations_ended(*node)).max();
        repeat.times = repeat.times.or(Some(ended.unwrap_or(0) + 1));
    }
    mission
}
