//! What is told on the stream of events.

use std::sync::Arc;

/// One event.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// What it is.
    pub kind: EventKind,
    /// How many records the run had come to since its daemon began.
    pub seq: u64,
    /// One line of JSON.
    pub data: Arc<str>,
}

/// What an event is, as the stream calls it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// What the run is at: the object of `ambidex status --json`.
    Snapshot,
    /// What was decided, told or heard: the object of `ambidex trace --json`.
    Record,
    /// A task that is not as before.
    Task,
    /// So many records were not told, since they were not read in time; a snapshot follows.
    Dropped,
}

impl EventKind {
    /// The kind behind a word.
    pub fn of(word: &str) -> Option<Self> {
        let all = [Self::Snapshot, Self::Record, Self::Task, Self::Dropped];
        all.into_iter().find(|kind| kind.word() == word)
    }

    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Snapshot => "snapshot",
            Self::Record => "record",
            Self::Task => "task",
            Self::Dropped => "dropped",
        }
    }
}
