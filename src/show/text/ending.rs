//! How a mission and a behavior ended, in words and in the state that gives the color.

use ambidex_model::{End, MissionEnd, Names};
use ambidex_record::{History, LeafState, MissionOutcome};

/// The state with whose color an end is shown.
pub(crate) fn of_end(end: MissionOutcome) -> LeafState {
    match end {
        MissionOutcome::Done => LeafState::Done,
        MissionOutcome::Canceled => LeafState::Canceled,
        MissionOutcome::Failed | MissionOutcome::Stalled => LeafState::Failed,
    }
}

/// The state that the end of a behavior looks like.
pub(crate) fn ended(end: End) -> LeafState {
    match end {
        End::Succeeded => LeafState::Done,
        End::Failed(_) => LeafState::Failed,
        End::Canceled => LeafState::Canceled,
        End::Interrupted => LeafState::Waiting,
    }
}

/// What a mission came to: its color, the word for it, and at what; nothing at what where there is nothing to say.
pub(crate) fn ending(history: &History) -> (LeafState, &'static str, Option<String>) {
    match history.end() {
        None => (LeafState::Canceled, "not ended", Some(format!("{NOT_ENDED}, at {}", history.now()))),
        Some(end) => {
            let outcome = MissionOutcome::from(end);
            (of_end(outcome), outcome.word(), cause(history, end))
        }
    }
}

/// At what a mission ended.
fn cause(history: &History, end: MissionEnd) -> Option<String> {
    let names = history.names();
    Some(match end {
        MissionEnd::Done => return None,
        MissionEnd::Stalled => "nothing runs and nothing can".into(),
        MissionEnd::Canceled => "it was told to end".into(),
        MissionEnd::Failed(leaf) => {
            let name = names.node(leaf);
            if let Some(reason) = history.state_of_run().infeasible().get(&leaf) {
                return Some(format!("{name} can never run: {}", reason.sentence(names)));
            }
            if history.leaf(leaf).is_none() {
                return Some(format!("{name} took too long"));
            }
            match history.leaf(leaf).and_then(|leaf| leaf.failures()) {
                None => format!("{name} failed"),
                Some(failures) => {
                    let fault = failures.fault.sentence(names);
                    match failures.times {
                        1 => format!("{name} failed at {}: {fault}", failures.at),
                        times => format!("{name} failed {times} times, at last at {}: {fault}", failures.at),
                    }
                }
            }
        }
        MissionEnd::ControllerLost(controller) => {
            let lost = history.lost(controller).map_or(String::new(), |(at, why)| format!(" at {at}: {why}"));
            format!("the controller {} was lost{lost}", names.controller(controller))
        }
        MissionEnd::NotAttached => NOT_ATTACHED.into(),
        MissionEnd::TaskLost => TASK_LOST.into(),
        MissionEnd::NodeLost(node) => node_lost(names.node(node)),
    })
}

const NOT_ATTACHED: &str = "not every controller attached in time";
const TASK_LOST: &str = "a task of the runtime is gone, which is a defect of ambidex";

fn node_lost(node: &str) -> String {
    format!("the task of node {node} is gone, which is a defect of ambidex")
}

/// How a mission ended, in one line.
pub(crate) fn mission_ended(end: MissionEnd, names: &Names) -> String {
    match end {
        MissionEnd::Done | MissionEnd::Stalled | MissionEnd::Canceled => MissionOutcome::from(end).word().into(),
        MissionEnd::Failed(leaf) => format!("failed at {}", names.node(leaf)),
        MissionEnd::ControllerLost(controller) => format!("failed: {} was lost", names.controller(controller)),
        MissionEnd::NotAttached => format!("failed: {NOT_ATTACHED}"),
        MissionEnd::TaskLost => format!("failed: {TASK_LOST}"),
        MissionEnd::NodeLost(node) => format!("failed: {}", node_lost(names.node(node))),
    }
}

/// What is said of a mission that has no end.
pub(crate) const NOT_ENDED: &str = "the log ends before the mission did";
