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

/// At what a mission ended that is not done, and what was wrong there, without when: the same for runs that ended alike.
pub(crate) fn shortest_cause(history: &History, end: MissionEnd) -> (Option<String>, String) {
    let names = history.names();
    let node = |node| Some(names.node(node).to_owned());
    match end {
        MissionEnd::Failed(leaf) => {
            let infeasible = history.state_of_run().infeasible().get(&leaf);
            let why = match (infeasible, history.leaf(leaf)) {
                (Some(reason), _) => format!("it can never run: {}", reason.sentence(names)),
                (None, None) => "it took too long".into(),
                (None, Some(leaf)) => {
                    leaf.failures().map_or("it failed".into(), |failures| failures.fault.sentence(names))
                }
            };
            (node(leaf), why)
        }
        MissionEnd::Stalled => {
            let cause = history.causes().into_iter().next();
            let leaf = cause.as_ref().and_then(|(leaf, _)| node(*leaf));
            let why = cause.map_or_else(|| "nothing runs and nothing can".into(), |(_, why)| why.sentence(names));
            (leaf, why)
        }
        MissionEnd::ControllerLost(controller) => (Some(names.controller(controller).to_owned()), "it was lost".into()),
        MissionEnd::NodeLost(lost) => (node(lost), "its task is gone, which is a defect of ambidex".into()),
        MissionEnd::Done | MissionEnd::Canceled | MissionEnd::NotAttached | MissionEnd::TaskLost => {
            (None, cause(history, end).unwrap_or_default())
        }
    }
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
