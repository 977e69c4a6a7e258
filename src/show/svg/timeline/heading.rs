//! The words above a timeline: mission, robot, allocator, outcome, makespan.

use crate::text::count;
use ambidex_model::{Header, MissionEnd};

use super::super::History;

/// The mission's name.
pub(super) fn mission(history: &History) -> String {
    header(history).map_or_else(String::new, |header| header.mission.clone())
}

/// Robot, allocator, outcome and figures of a run.
pub(super) fn figures(history: &History) -> String {
    let robot = header(history).map_or("?", |header| header.robot.as_str());
    format!("robot {robot} · allocator {} · {}", allocator(history), came_out(history))
}

/// One of two runs.
pub(super) fn run(history: &History) -> [String; 2] {
    [format!("allocator {}", allocator(history)), came_out(history)]
}

/// The missions of two runs.
pub(super) fn missions(upper: &History, lower: &History) -> String {
    match (mission(upper), mission(lower)) {
        (one, other) if one == other => one,
        (one, other) => format!("{one} and {other}"),
    }
}

/// Both makespans and their ratio, where both runs did what they were to do.
pub(super) fn ratio(upper: &History, lower: &History) -> String {
    let (one, other) = (upper.tally().makespan_s(), lower.tally().makespan_s());
    let both = format!("{} {one:.2} s, {} {other:.2} s", allocator(upper), allocator(lower));
    let longer = if allocator(upper) == allocator(lower) { "the lower run" } else { allocator(lower) };
    let is_done = |history: &History| history.tally().end == Some(MissionEnd::Done);
    match is_done(upper) && is_done(lower) && one > 0.0 {
        true => format!("makespans: {both}; {longer} takes {:.2} times as long", other / one),
        false => format!("makespans: {both}; not to be compared, since not both runs are done"),
    }
}

fn header(history: &History) -> Option<&Header> {
    history.tally().header.as_deref()
}

fn allocator(history: &History) -> &str {
    header(history).map_or("?", |header| header.allocator.as_str())
}

fn came_out(history: &History) -> String {
    let tally = history.tally();
    format!(
        "{} · makespan {:.2} s · {} · {} · {} skipped",
        outcome(history),
        tally.makespan_s(),
        count(tally.steps.len(), "step"),
        count(tally.rounds as usize, "round"),
        tally.skipped.len(),
    )
}

fn outcome(history: &History) -> String {
    let name = |leaf| header(history).map_or("?", |header| header.names.node(leaf));
    match history.tally().end {
        None => format!("not ended, the log stops at {}", history.tally().now),
        Some(MissionEnd::Done) => "done".into(),
        Some(MissionEnd::Failed(leaf)) => format!("failed at {}", name(leaf)),
        Some(MissionEnd::Stalled) => "stalled".into(),
        Some(MissionEnd::Canceled) => "cancelled".into(),
        Some(MissionEnd::ControllerLost(controller)) => {
            let controller = header(history).map_or("?", |header| header.names.controller(controller));
            format!("failed, the controller {controller} was lost")
        }
        Some(MissionEnd::NotAttached) => "failed, not every controller attached".into(),
        Some(MissionEnd::NodeLost(_) | MissionEnd::TaskLost) => "failed by a defect".into(),
    }
}
