//! The way of records from the thread that writes the log to the hub. It never waits: what there is no room for is left
//! out, and made good with a whole history once there is.

use tokio::sync::mpsc;

use ambidex_model::Record;
use ambidex_record::History;

/// Records that are told together: to wake the hub costs more than a record.
const TOGETHER: usize = 64;
/// So many times that may wait for the hub.
const WAITING_MAX: usize = 64;

/// What the hub is told.
#[derive(Debug)]
pub enum News {
    /// These were written.
    Records(Vec<Record>),
    /// So many were written that it was not told; the run comes to this now.
    Missed {
        /// How many.
        records: u64,
        /// What the run comes to.
        history: Box<History>,
    },
}

/// The end of the way at which records come in.
#[derive(Debug)]
pub struct Feed {
    to: mpsc::Sender<News>,
    gathered: Vec<Record>,
    missed: u64,
}

impl Feed {
    /// A way and its other end.
    pub fn new() -> (Self, mpsc::Receiver<News>) {
        let (to, from) = mpsc::channel(WAITING_MAX);
        (Self { to, gathered: Vec::new(), missed: 0 }, from)
    }

    /// Takes a record after which the run comes to this; it is told with others, at the latest by [`Feed::flush`].
    pub fn take(&mut self, record: &Record, history: &History) {
        if self.missed > 0 {
            self.missed += 1;
        } else {
            self.gathered.push(record.clone());
        }
        if self.missed > 0 || self.gathered.len() == TOGETHER {
            self.flush(history);
        }
    }

    /// Tells what was taken, and makes good what was left out, where there is room; false where there is none.
    pub fn flush(&mut self, history: &History) -> bool {
        if !self.gathered.is_empty() {
            let records = std::mem::take(&mut self.gathered);
            let count = records.len() as u64;
            if self.to.try_send(News::Records(records)).is_err() {
                self.missed += count;
            }
        }
        // A whole history is more work than a record: the hub is given time to catch up first.
        if self.missed > 0 && self.to.capacity() > WAITING_MAX / 2 {
            let news = News::Missed { records: self.missed, history: Box::new(history.present()) };
            if self.to.try_send(news).is_ok() {
                self.missed = 0;
            }
        }
        self.missed == 0 || self.to.is_closed()
    }
}
