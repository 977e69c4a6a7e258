//! Stalls: whether some schedule would have finished the mission, and by which rule of the page it was not taken.

mod flips;
mod search;

use ambidex::model::MissionSpec;

use super::compare;
use super::counts::Counts;
use super::generator::Case;
use super::reference::{Freedom, Model, Rule};
use super::run::Event;
use search::{Found, Search};

/// A moment of a run, and what happened then; a round if no event is told.
pub struct Moment<'a> {
    pub before: Model<'a>,
    pub event: Option<Event>,
}

/// Why a mission stalled.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// A schedule is left that no rule forbids.
    Unexplained(String),
    /// A schedule is left, but for these rules.
    Forbidden(Vec<Rule>),
    /// No schedule was left from some moment on.
    Lost(flips::Cause),
    /// There never was any.
    Unsolvable,
    CutOff,
}

#[test]
fn no_stall_is_left_unexplained() {
    super::for_all("stalls", 10, |case| {
        let case = case.certified();
        let (counts, verdict) = explain(&case);
        if let Some(verdict) = &verdict {
            println!("STALL {} {} {verdict:?}", case.seed, case.depth);
        }
        counts
    });
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
        Found::CutOff => return Verdict::CutOff,
        Found::Nothing => {}
    }
    match from_here(Freedom::of(&Rule::ALL)) {
        Found::Schedule(_) => forbidding(|freedom| from_here(freedom)),
        Found::Nothing => flips::last(mission, moments),
        Found::CutOff => Verdict::CutOff,
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
