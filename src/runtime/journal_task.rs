//! One thread writes all records, in the order in which they were made. None is dropped, and nothing that blocks the
//! thread blocks the robot: only a backlog that became too long delays the next round.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use std::sync::mpsc::{self, RecvTimeoutError, TryRecvError};
use std::thread;
use std::time::Duration;

use tokio::sync::{Notify, oneshot};

use ambidex_model::Record;

/// Where records end up; called by one thread alone, which may block.
pub trait Sink: Send {
    /// Takes the next record.
    fn take(&mut self, record: &Record);

    /// Nothing waits: a good moment to flush. What it gives is when it wants to be asked again if nothing comes.
    fn rest(&mut self) -> Option<Duration> {
        None
    }
}

impl<F: FnMut(&Record) + Send> Sink for F {
    fn take(&mut self, record: &Record) {
        self(record);
    }
}

/// Records that may wait before root opens no further round.
const BACKLOG: usize = 16_384;

/// How long the thread lets records gather before it rests. While it waits for the next one, whoever sends that has to wake
/// it, which costs more than the record: a robot's next goal would wait for a dozen such wake-ups.
const GATHER: Duration = Duration::from_millis(1);

/// The way to the journal.
#[derive(Debug, Clone)]
pub(super) struct Journal {
    to: mpsc::Sender<Record>,
    waiting: Arc<AtomicUsize>,
    drained: Arc<Notify>,
}

impl Journal {
    /// A journal and the word that all is written, which comes when the last handle is gone; none if the thread panicked.
    pub(super) fn new(mut sink: Box<dyn Sink>) -> (Self, oneshot::Receiver<()>) {
        let (to, from) = mpsc::channel::<Record>();
        let journal = Self { to, waiting: Arc::default(), drained: Arc::default() };
        let (waiting, drained) = (Arc::clone(&journal.waiting), Arc::clone(&journal.drained));
        let (written, is_written) = oneshot::channel();
        let write = move || {
            while let Some(record) = next(&from, &mut *sink) {
                sink.take(&record);
                if waiting.fetch_sub(1, Ordering::Relaxed) == BACKLOG + 1 {
                    drained.notify_one();
                }
            }
            drop(sink);
            // Whoever waited for it may be gone already.
            let _ = written.send(());
        };
        thread::Builder::new().name("log".into()).spawn(write).expect("the system gives a thread");
        (journal, is_written)
    }

    pub(super) fn write(&self, record: Record) {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        // The thread outlives every handle, unless its sink panicked: then the run is about to end.
        drop(self.to.send(record));
    }

    /// Waits until the backlog is short: back-pressure delays the next round, never a message.
    pub(super) async fn ready(&self) {
        while self.waiting.load(Ordering::Relaxed) > BACKLOG {
            self.drained.notified().await;
        }
    }
}

/// The next record; none once the last handle is gone. While none is there, the sink rests.
fn next(from: &mpsc::Receiver<Record>, sink: &mut dyn Sink) -> Option<Record> {
    for pause in [GATHER, Duration::ZERO] {
        match from.try_recv() {
            Ok(record) => return Some(record),
            Err(TryRecvError::Disconnected) => return None,
            Err(TryRecvError::Empty) => thread::sleep(pause),
        }
    }
    while let Some(pause) = sink.rest() {
        match from.recv_timeout(pause) {
            Ok(record) => return Some(record),
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
    from.recv().ok()
}
