//! What is told of each task.

use ambidex_model::state::Task;
use ambidex_model::{MissionEnd, NodeId, make_legible};
use ambidex_record::{Counts, EndedTask, History, LeafState, MissionOutcome};
use serde::{Deserialize, Serialize};

use crate::text::ending;

/// The node at the top of the mission's own task.
pub(super) const TOP: NodeId = NodeId(1);
/// The number of the mission's own task.
const OWN: u32 = 1;

/// How far a task is.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, strum::IntoStaticStr, strum::EnumString, strum::Display,
)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum TaskState {
    /// Something of it runs.
    Running,
    /// Nothing of it runs for now.
    Waiting,
    /// It was paused.
    Paused,
    /// Nothing of it runs and nothing can, unless others change the world.
    Stalled,
    /// It was told to end, and comes to rest or is cleaned up.
    Ending,
    /// It is done.
    Done,
    /// It failed.
    Failed,
    /// It was told to end and has ended.
    Canceled,
}

/// A task and how far it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct TaskSummary {
    /// Its number, from 1 in the order in which tasks came.
    pub task: u32,
    /// Its name.
    pub name: String,
    /// How far it is.
    pub state: TaskState,
    /// How urgent it is: the greater, the more.
    pub priority: i32,
    /// When it came, robot time since the mission began, seconds.
    pub since_s: f64,
    /// Why it does not go on, or at what it ended, as a sentence.
    pub said: Option<String>,
    /// Behaviors of it that are done or skipped.
    pub done: usize,
    /// How many behaviors it has.
    pub of: usize,
}

impl TaskState {
    /// The word for it.
    pub fn word(self) -> &'static str {
        self.into()
    }

    /// Whether nothing more comes of it, whatever others do.
    pub fn is_end(self) -> bool {
        match self {
            Self::Done | Self::Failed | Self::Canceled => true,
            Self::Running | Self::Waiting | Self::Paused | Self::Stalled | Self::Ending => false,
        }
    }

    /// The state of a node that looks like it.
    pub(super) fn looks_like(self) -> LeafState {
        match self {
            Self::Running | Self::Ending => LeafState::Active,
            Self::Waiting | Self::Paused => LeafState::Waiting,
            Self::Done => LeafState::Done,
            Self::Stalled | Self::Failed => LeafState::Failed,
            Self::Canceled => LeafState::Canceled,
        }
    }
}

/// Every task, in the order in which they came; of those that are over the last.
pub fn summaries(history: &History) -> Vec<TaskSummary> {
    if !history.is_standing() {
        return vec![own(history)];
    }
    let ended = history.ended_tasks().iter().map(|ended| over(history, ended));
    let alive = history.state_of_run().tasks().iter().map(|(&task, known)| alive(history, task, known));
    let mut all: Vec<TaskSummary> = ended.chain(alive).collect();
    all.sort_by_key(|task| task.task);
    all
}

/// A task that was submitted.
fn alive(history: &History, task: NodeId, known: &Task) -> TaskSummary {
    let (counts, run) = (history.counts(task), history.state_of_run());
    let state = match history.end().map(MissionOutcome::from) {
        Some(MissionOutcome::Done) => TaskState::Done,
        Some(MissionOutcome::Failed | MissionOutcome::Stalled | MissionOutcome::Canceled) => TaskState::Canceled,
        None if known.canceled.is_some() || run.ending().is_some() => TaskState::Ending,
        None if run.is_paused(task) => TaskState::Paused,
        None if known.is_stalled => TaskState::Stalled,
        None if counts.active > 0 => TaskState::Running,
        None => TaskState::Waiting,
    };
    let said = match state {
        TaskState::Waiting | TaskState::Stalled => waits_for(history, history.leaves_below(task).into_iter()),
        TaskState::Running | TaskState::Paused | TaskState::Ending => None,
        TaskState::Done | TaskState::Failed | TaskState::Canceled => None,
    };
    submitted(history, (task, known), state, said, counts)
}

/// A task that is over.
fn over(history: &History, ended: &EndedTask) -> TaskSummary {
    let EndedTask { task, known, end, counts, .. } = ended;
    let state = match end {
        MissionEnd::Done => TaskState::Done,
        MissionEnd::Canceled => TaskState::Canceled,
        MissionEnd::Failed(_)
        | MissionEnd::Stalled
        | MissionEnd::ControllerLost(_)
        | MissionEnd::NotAttached
        | MissionEnd::NodeLost(_)
        | MissionEnd::TaskLost => TaskState::Failed,
    };
    submitted(history, (*task, known), state, ended.said.clone(), *counts)
}

/// What is told of a task that was submitted, once it is known how far it is.
fn submitted(
    history: &History,
    (task, known): (NodeId, &Task),
    state: TaskState,
    said: Option<String>,
    counts: Counts,
) -> TaskSummary {
    let mut name = known.name.clone();
    make_legible(&mut name);
    let since_s = history.moment(known.since).seconds();
    let (priority, done, of) = (known.priority, counts.done, counts.of);
    TaskSummary { task: task.0, name, state, priority, since_s, said, done, of }
}

/// The mission as a task.
fn own(history: &History) -> TaskSummary {
    let counts = history.counts(TOP);
    let state = state(history);
    TaskSummary {
        task: OWN,
        name: history.header().mission.clone(),
        state,
        priority: 0,
        since_s: 0.0,
        said: said(history, state),
        done: counts.done,
        of: counts.of,
    }
}

fn state(history: &History) -> TaskState {
    match history.end().map(MissionOutcome::from) {
        Some(MissionOutcome::Done) => TaskState::Done,
        Some(MissionOutcome::Failed) => TaskState::Failed,
        Some(MissionOutcome::Stalled) => TaskState::Stalled,
        Some(MissionOutcome::Canceled) => TaskState::Canceled,
        None if history.state_of_run().ending().is_some() => TaskState::Ending,
        None if history.running().is_empty() => TaskState::Waiting,
        None => TaskState::Running,
    }
}

/// Why it does not go on: at what it ended, else what the first behavior waits for that was asked.
fn said(history: &History, state: TaskState) -> Option<String> {
    match state {
        TaskState::Running | TaskState::Done => None,
        TaskState::Failed | TaskState::Stalled | TaskState::Canceled => ending(history).2,
        TaskState::Ending | TaskState::Paused => None,
        TaskState::Waiting => waits_for(history, history.leaves()),
    }
}

/// What the first of some behaviors waits for that was asked.
fn waits_for(history: &History, mut leaves: impl Iterator<Item = NodeId>) -> Option<String> {
    leaves.find_map(|leaf| {
        let reason = history.leaf(leaf)?.reason().filter(|reason| reason.is_telling())?;
        if history.state(leaf) != LeafState::Waiting {
            return None;
        }
        Some(format!("{}: {}", history.names().node(leaf), reason.sentence(history.names())))
    })
}
