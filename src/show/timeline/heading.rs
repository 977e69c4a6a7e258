//! The words above a timeline: mission, robot, allocator, outcome, makespan.

use ambidex_model::MissionEnd;
use ambidex_record::History;

use crate::text::{NOT_ENDED, count, mission_ended};

/// Robot, allocator, outcome and figures of a run.
pub(super) fn figures(history: &History) -> String {
    format!("robot {} · allocator {} · {}", history.header().robot, allocator(history), came_out(history))
}

/// One of two runs.
pub(super) fn run(history: &History) -> [String; 2] {
    [format!("allocator {}", allocator(history)), came_out(history)]
}

/// The missions of two runs.
pub(super) fn missions(upper: &History, lower: &History) -> String {
    match (&upper.header().mission, &lower.header().mission) {
        (one, other) if one == other => one.clone(),
        (one, other) => format!("{one} and {other}"),
    }
}

/// Both makespans and their ratio, where both runs did what they were to do.
pub(super) fn ratio(upper: &History, lower: &History) -> String {
    let (one, other) = (upper.makespan_s(), lower.makespan_s());
    let both = format!("{} {one:.2} s, {} {other:.2} s", allocator(upper), allocator(lower));
    let longer = if allocator(upper) == allocator(lower) { "the lower run" } else { allocator(lower) };
    let is_done = |history: &History| history.end() == Some(MissionEnd::Done);
    match is_done(upper) && is_done(lower) && one > 0.0 {
        true => format!("makespans: {both}; {longer} takes {:.2} times as long", other / one),
        false => format!("makespans: {both}; not to be compared, since not both runs are done"),
    }
}

fn allocator(history: &History) -> &str {
    &history.header().allocator
}

fn came_out(history: &History) -> String {
    let outcome = match history.end() {
        Some(end) => mission_ended(end, history.names()),
        None => format!("{NOT_ENDED}, at {}", history.now()),
    };
    let (steps, rounds) = (count(history.step_count(), "step"), count(history.rounds(), "round"));
    let (makespan_s, skipped) = (history.makespan_s(), history.skipped().len());
    format!("{outcome} · makespan {makespan_s:.2} s · {steps} · {rounds} · {skipped} skipped")
}
