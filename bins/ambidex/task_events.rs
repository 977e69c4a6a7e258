//! What is heard of the tasks of a daemon, as it happens.

use std::collections::BTreeMap;

use ambidex::http::{AskError, Events, Heard};
use ambidex::link::Instance;
use ambidex::runtime::control::{NameOrId, Refusal};
use ambidex::show::tasks::{TaskState, TaskSummary};
use tokio::signal::unix::{Signal, SignalKind, signal};

/// The tasks of a daemon as they were heard last.
pub struct TaskEvents {
    instance: Instance,
    events: Events,
    known: BTreeMap<u32, TaskSummary>,
    /// Whether this stream told anything.
    has_told: bool,
}

impl TaskEvents {
    /// Begins to listen.
    ///
    /// # Errors
    /// When there is no daemon; within it that it is heard by too many already.
    pub async fn open(instance: &Instance) -> Result<Result<Self, Refusal>, AskError> {
        let listen = |events| Self { instance: instance.clone(), events, known: BTreeMap::new(), has_told: false };
        Ok(Events::open(instance).await?.map(listen))
    }

    /// The tasks that are not as they were heard last; none once the daemon is over.
    ///
    /// # Errors
    /// When what it tells cannot be read.
    pub async fn next(&mut self) -> Result<Option<Vec<TaskSummary>>, AskError> {
        loop {
            let tasks = match self.events.next().await? {
                Some(Heard::All(tasks)) => tasks,
                Some(Heard::Task(task)) => vec![*task],
                // What is missing is in the tasks that come next.
                Some(Heard::Dropped(_)) => continue,
                None if self.is_there_again().await? => continue,
                None => return Ok(None),
            };
            self.has_told = true;
            let news: Vec<_> = tasks.into_iter().filter(|task| self.known.get(&task.task) != Some(task)).collect();
            self.known.extend(news.iter().map(|task| (task.task, task.clone())));
            if !news.is_empty() {
                return Ok(Some(news));
            }
        }
    }

    /// A task as it was heard last.
    pub fn task(&self, task: u32) -> Option<&TaskSummary> {
        self.known.get(&task)
    }

    /// Whether nothing is open of the tasks that are meant; what had stalled is not, where the daemon ended.
    pub fn is_all_over(&self, meant: Option<&NameOrId>) -> bool {
        let meant = |task: &&TaskSummary| meant.is_none_or(|meant| meant.is(task.task, &task.name));
        self.known.values().filter(meant).all(|task| task.state.is_end() || task.state == TaskState::Stalled)
    }

    /// Whether the daemon only hung up, as on one who was stopped for a while.
    async fn is_there_again(&mut self) -> Result<bool, AskError> {
        if !std::mem::take(&mut self.has_told) {
            return Ok(false);
        }
        match Events::open(&self.instance).await {
            Ok(Ok(events)) => self.events = events,
            Ok(Err(_)) | Err(AskError::NoDaemon(_) | AskError::Ended(_) | AskError::Late { .. }) => return Ok(false),
            Err(error @ (AskError::Socket { .. } | AskError::Answer { .. })) => return Err(error),
        }
        Ok(true)
    }
}

/// Ctrl-C and its relatives.
pub struct Interrupts {
    interrupt: Signal,
    terminate: Signal,
}

impl Interrupts {
    /// From now on they end nothing by themselves; within a runtime of tokio.
    ///
    /// # Errors
    /// When the handlers cannot be set.
    pub fn new() -> std::io::Result<Self> {
        Ok(Self { interrupt: signal(SignalKind::interrupt())?, terminate: signal(SignalKind::terminate())? })
    }

    /// Comes back with the next one.
    pub async fn next(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}
