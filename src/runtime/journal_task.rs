//! One task writes all records, in the order in which they were made. None is dropped.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::sync::{Notify, mpsc};

use ambidex_model::Record;

/// Where records end up; called by one task alone.
pub trait Sink: Send {
    /// Takes the next record.
    fn take(&mut self, record: &Record);

    /// Nothing waits: a good moment to flush.
    fn rest(&mut self) {}
}

impl<F: FnMut(&Record) + Send> Sink for F {
    fn take(&mut self, record: &Record) {
        self(record);
    }
}

/// Records that may wait before root opens no further round.
const BACKLOG: usize = 16_384;

/// The way to the journal.
#[derive(Debug, Clone)]
pub(super) struct Journal {
    to: mpsc::UnboundedSender<Record>,
    waiting: Arc<AtomicUsize>,
    drained: Arc<Notify>,
}

impl Journal {
    /// A journal and the task that writes it; the task ends when the last handle is gone.
    pub(super) fn new(mut sink: Box<dyn Sink>) -> (Self, impl Future<Output = ()>) {
        let (to, mut from) = mpsc::unbounded_channel::<Record>();
        let journal = Self { to, waiting: Arc::default(), drained: Arc::default() };
        let (waiting, drained) = (Arc::clone(&journal.waiting), Arc::clone(&journal.drained));
        let task = async move {
            while let Some(record) = from.recv().await {
                sink.take(&record);
                if waiting.fetch_sub(1, Ordering::Relaxed) == BACKLOG {
                    drained.notify_one();
                }
                if from.is_empty() {
                    sink.rest();
                }
            }
        };
        (journal, task)
    }

    pub(super) fn write(&self, record: Record) {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        // The task outlives every handle; it can only be gone when the whole run is.
        drop(self.to.send(record));
    }

    /// Waits until the backlog is short: back-pressure delays the next round, never a message.
    pub(super) async fn ready(&self) {
        while self.waiting.load(Ordering::Relaxed) > BACKLOG {
            self.drained.notified().await;
        }
    }
}
