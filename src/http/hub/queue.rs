//! What waits for one reader.

use std::collections::VecDeque;

use super::event::{Event, EventKind};
use crate::limits::QUEUE_MAX;

/// Events of one reader that it has not read.
#[derive(Debug)]
pub(super) struct Queue {
    events: VecDeque<Event>,
    bytes: usize,
    /// Nothing is kept until a snapshot was read.
    is_behind: bool,
    /// Records that it will never be told.
    dropped: u64,
    /// What comes before all that waits.
    snapshot: Option<Event>,
}

/// What a reader is told next.
#[derive(Debug)]
pub(super) enum Next {
    Event(Event),
    /// What the run is at when it is read, behind the word that so many records were dropped.
    Snapshot {
        dropped: u64,
    },
    Nothing,
    Over,
}

impl Default for Queue {
    /// That of one who knows nothing yet.
    fn default() -> Self {
        Self { events: VecDeque::new(), bytes: 0, is_behind: true, dropped: 0, snapshot: None }
    }
}

impl Queue {
    /// Whether what happens now is of no use, since a snapshot comes first.
    pub(super) fn is_behind(&self) -> bool {
        self.is_behind
    }

    /// How much waits.
    #[cfg(test)]
    pub(super) fn bytes(&self) -> usize {
        self.bytes
    }

    /// The run begins: all that was told is of another one.
    pub(super) fn restart(&mut self) {
        *self = Self::default();
    }

    /// One more event; where there is no room for it, all that waits is dropped.
    pub(super) fn push(&mut self, event: Event) {
        let records = u64::from(event.kind == EventKind::Record);
        if self.is_behind || self.bytes + event.data.len() > QUEUE_MAX {
            return self.miss(records);
        }
        self.bytes += event.data.len();
        self.events.push_back(event);
    }

    /// So many records are not told, and nothing before the next snapshot.
    pub(super) fn miss(&mut self, records: u64) {
        let waiting = self.events.iter().filter(|event| event.kind == EventKind::Record).count();
        // Who has read nothing yet has missed nothing.
        let is_new = self.is_behind && self.dropped == 0;
        if !is_new {
            self.dropped += records + waiting as u64;
        }
        self.is_behind = true;
        self.events.clear();
        self.bytes = 0;
        self.snapshot = None;
    }

    /// What is told before all else.
    pub(super) fn put_first(&mut self, snapshot: Event) {
        self.snapshot = Some(snapshot);
    }

    /// What is told next.
    pub(super) fn next(&mut self) -> Next {
        if std::mem::take(&mut self.is_behind) {
            return Next::Snapshot { dropped: std::mem::take(&mut self.dropped) };
        }
        if let Some(snapshot) = self.snapshot.take() {
            return Next::Event(snapshot);
        }
        match self.events.pop_front() {
            Some(event) => {
                self.bytes -= event.data.len();
                Next::Event(event)
            }
            None => Next::Nothing,
        }
    }
}
