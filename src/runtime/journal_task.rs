//! One thread writes all records, in the order in which they were made. None is dropped, and nothing that blocks the
//! thread blocks the robot: only a backlog that became too long delays the next round.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use std::sync::mpsc::{self, RecvTimeoutError, TryRecvError};
use std::thread;
use std::time::Duration;

use tokio::sync::{Notify, oneshot};

use ambidex_model::state::Saved;
use ambidex_model::{Record, Time};

/// Where records end up; called by one thread alone, which may block.
pub trait Sink: Send {
    /// Takes the next record.
    fn take(&mut self, record: &Record);

    /// Whatever was taken is where it is to be, so that it outlives this process; false where that failed.
    fn settle(&mut self) -> bool {
        true
    }

    /// Whether what it writes has become so long that it is to begin anew with what the run is now.
    fn is_full(&self) -> bool {
        false
    }

    /// Begins anew with what the run is.
    fn save(&mut self, _at: Time, _saved: &Saved) {}

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

/// What the thread is told.
#[derive(Debug)]
enum Line {
    /// Take the next record.
    Record(Box<Record>),
    /// Begin anew with what the run is.
    Save(Time, Box<Saved>),
    /// Say when all before it is written, and whether it is.
    Settle(oneshot::Sender<bool>),
}

/// The way to the journal.
#[derive(Debug, Clone)]
pub(super) struct Journal {
    to: mpsc::Sender<Line>,
    waiting: Arc<AtomicUsize>,
    drained: Arc<Notify>,
    /// What is written has become too long.
    is_full: Arc<AtomicBool>,
    is_over: Arc<AtomicBool>,
}

impl Journal {
    /// A journal and the word that all is written, which comes when the last handle is gone; none if the thread panicked.
    pub(super) fn new(mut sink: Box<dyn Sink>) -> (Self, oneshot::Receiver<()>) {
        let (to, from) = mpsc::channel::<Line>();
        let journal = Self {
            to,
            waiting: Arc::default(),
            drained: Arc::default(),
            is_full: Arc::default(),
            is_over: Arc::default(),
        };
        let is_full = Arc::clone(&journal.is_full);
        let (waiting, drained) = (Arc::clone(&journal.waiting), Arc::clone(&journal.drained));
        let (written, is_written) = oneshot::channel();
        let write = move || {
            while let Some(line) = next(&from, &mut *sink) {
                match line {
                    Line::Record(record) => sink.take(&record),
                    Line::Save(at, saved) => {
                        sink.save(at, &saved);
                        is_full.store(sink.is_full(), Ordering::Relaxed);
                        continue;
                    }
                    Line::Settle(settled) => {
                        // Whoever asked may be gone.
                        let _ = settled.send(sink.settle());
                        continue;
                    }
                }
                is_full.store(sink.is_full(), Ordering::Relaxed);
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
        if let Record::Ended { .. } = record {
            self.is_over.store(true, Ordering::Relaxed);
        }
        self.waiting.fetch_add(1, Ordering::Relaxed);
        // The thread outlives every handle, unless its sink panicked: then the run is about to end.
        drop(self.to.send(Line::Record(Box::new(record))));
    }

    /// Whether the run is to be saved.
    pub(super) fn is_full(&self) -> bool {
        self.is_full.load(Ordering::Relaxed)
    }

    /// What the run is: all that is written from now on follows from that.
    pub(super) fn save(&self, at: Time, saved: Saved) {
        self.is_full.store(false, Ordering::Relaxed);
        drop(self.to.send(Line::Save(at, Box::new(saved))));
    }

    /// Comes when all that was written before is where it outlives this process; false where it is not.
    pub(super) fn settled(&self) -> oneshot::Receiver<bool> {
        let (settled, is_settled) = oneshot::channel();
        drop(self.to.send(Line::Settle(settled)));
        is_settled
    }

    /// Whether the mission has ended: only what makes controllers safe is still to be written.
    pub(super) fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }

    /// Waits until the backlog is short: back-pressure delays the next round, never a message.
    pub(super) async fn ready(&self) {
        while self.waiting.load(Ordering::Relaxed) > BACKLOG {
            self.drained.notified().await;
        }
    }
}

/// The next record; none once the last handle is gone. While none is there, the sink rests.
fn next(from: &mpsc::Receiver<Line>, sink: &mut dyn Sink) -> Option<Line> {
    for pause in [GATHER, Duration::ZERO] {
        match from.try_recv() {
            Ok(line) => return Some(line),
            Err(TryRecvError::Disconnected) => return None,
            Err(TryRecvError::Empty) => thread::sleep(pause),
        }
    }
    while let Some(pause) = sink.rest() {
        match from.recv_timeout(pause) {
            Ok(line) => return Some(line),
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
    from.recv().ok()
}
