//! What a run comes to, beside the run: whoever asks is answered from here, and nobody who asks can hold up the run.
//!
//! Records come by a [`Feed`], which never waits. The hub keeps a history of its own, and a queue for every reader of the
//! stream of events. A reader that falls behind loses its queue, is told so, and goes on from a snapshot of the moment at
//! which it reads again.

mod event;
mod feed;
mod queue;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{Notify, mpsc, oneshot};

use ambidex_model::Record;
use ambidex_record::History;
use ambidex_runtime::Clock;
use ambidex_show::conversation;
use ambidex_show::status::{Daemon, Snapshot};
use ambidex_show::tasks::{TaskDetail, TaskSummary, detail, summaries};

pub use event::{Event, EventKind};
pub use feed::{Feed, News};
use queue::{Next, Queue};

/// News that are taken before whoever else waits has a turn.
const AT_ONCE: usize = 4;

/// The hub, shared by all who are answered from it.
#[derive(Debug, Clone)]
pub struct Hub(Arc<Mutex<Inner>>);

#[derive(Debug)]
struct Inner {
    history: History,
    clock: Clock,
    /// Records so far.
    seq: u64,
    /// As they were told last.
    tasks: Vec<TaskSummary>,
    readers: BTreeMap<u64, Reader>,
    next_reader: u64,
    is_over: bool,
}

#[derive(Debug, Default)]
struct Reader {
    queue: Queue,
    has_more: Arc<Notify>,
}

/// One who reads the stream of events, until it is dropped.
#[derive(Debug)]
pub struct Subscription {
    hub: Hub,
    reader: u64,
    has_more: Arc<Notify>,
}

impl Hub {
    /// A hub of a run that comes to this so far.
    pub fn new(history: History, clock: Clock) -> Self {
        let tasks = summaries(&history);
        Self(Arc::new(Mutex::new(Inner {
            history,
            clock,
            seq: 0,
            tasks,
            readers: BTreeMap::new(),
            next_reader: 0,
            is_over: false,
        })))
    }

    /// Takes all news until there can be no more; once the other end of `over` is dropped, those that were sent.
    pub async fn follow(self, mut news: mpsc::Receiver<News>, mut over: oneshot::Receiver<()>) {
        let mut batch = Vec::with_capacity(AT_ONCE);
        loop {
            tokio::select! {
                count = news.recv_many(&mut batch, AT_ONCE) => {
                    if count == 0 {
                        break;
                    }
                    self.take(batch.drain(..));
                    tokio::task::yield_now().await;
                }
                _ = &mut over, if !news.is_closed() => news.close(),
            }
        }
        self.close();
    }

    /// Takes news, and tells readers of them.
    pub fn take(&self, news: impl IntoIterator<Item = News>) {
        let mut inner = self.inner();
        for news in news {
            match news {
                News::Records(records) => records.iter().for_each(|record| inner.record(record)),
                News::Missed { records, history } => inner.catch_up(records, *history),
            }
        }
        inner.tell_tasks();
        inner.wake();
    }

    /// Nothing more happens: streams end behind what waits in them.
    fn close(&self) {
        let mut inner = self.inner();
        inner.is_over = true;
        inner.wake();
    }

    /// What the run is at.
    pub fn snapshot(&self) -> Snapshot {
        let inner = self.inner();
        snapshot(&inner.history, inner.clock)
    }

    /// Every task.
    pub fn tasks(&self) -> Vec<TaskSummary> {
        summaries(&self.inner().history)
    }

    /// A task with its tree.
    pub fn task(&self, task: u32) -> Option<TaskDetail> {
        detail(&self.inner().history, task)
    }

    /// A stream of all events from a snapshot on.
    pub fn subscribe(&self) -> Subscription {
        let mut inner = self.inner();
        if inner.readers.is_empty() {
            inner.tasks = summaries(&inner.history);
        }
        let reader = inner.next_reader;
        inner.next_reader += 1;
        let has_more = Arc::clone(&inner.readers.entry(reader).or_default().has_more);
        Subscription { hub: self.clone(), reader, has_more }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn record(&mut self, record: &Record) {
        self.seq += 1;
        if let Record::Header(header) = record {
            self.history = History::new(header);
            self.readers.values_mut().for_each(|reader| reader.queue.restart());
            return;
        }
        self.history.apply(record);
        if self.readers.values().all(|reader| reader.queue.is_behind()) {
            self.readers.values_mut().for_each(|reader| reader.queue.miss(1));
            return;
        }
        if let Ok(text) = conversation::json(record, self.history.names()) {
            self.tell(EventKind::Record, &text);
        }
    }

    /// The run comes to this, after records that nobody was told.
    fn catch_up(&mut self, records: u64, history: History) {
        self.seq += records;
        self.history = history;
        self.readers.values_mut().for_each(|reader| reader.queue.miss(records));
    }

    /// Tells of each task that is not as it was told last.
    fn tell_tasks(&mut self) {
        if self.readers.is_empty() {
            return;
        }
        let tasks = summaries(&self.history);
        let known: BTreeMap<u32, &TaskSummary> = self.tasks.iter().map(|task| (task.task, task)).collect();
        let news: Vec<String> = tasks
            .iter()
            .filter(|task| known.get(&task.task) != Some(task))
            .filter_map(|task| serde_json::to_string(task).ok())
            .collect();
        news.iter().for_each(|text| self.tell(EventKind::Task, text));
        self.tasks = tasks;
    }

    fn tell(&mut self, kind: EventKind, text: &str) {
        let event = Event { kind, seq: self.seq, data: Arc::from(text) };
        self.readers.values_mut().for_each(|reader| reader.queue.push(event.clone()));
    }

    fn wake(&self) {
        self.readers.values().for_each(|reader| reader.has_more.notify_one());
    }

    /// What a reader is told next.
    fn next(&mut self, reader: u64) -> Next {
        let Some(reader) = self.readers.get_mut(&reader) else { return Next::Over };
        match reader.queue.next() {
            Next::Snapshot { dropped } => {
                let event = |kind, data: String| Event { kind, seq: self.seq, data: data.into() };
                let snapshot = snapshot(&self.history, self.clock);
                let snapshot = event(EventKind::Snapshot, serde_json::to_string(&snapshot).unwrap_or_default());
                if dropped == 0 {
                    return Next::Event(snapshot);
                }
                reader.queue.put_first(snapshot);
                Next::Event(event(EventKind::Dropped, format!("{{\"records\":{dropped}}}")))
            }
            Next::Nothing if self.is_over => Next::Over,
            next @ (Next::Event(_) | Next::Nothing | Next::Over) => next,
        }
    }
}

fn snapshot(history: &History, clock: Clock) -> Snapshot {
    let daemon = Daemon::Running { pid: Some(std::process::id()) };
    Snapshot::new(history, daemon, clock.now())
}

impl Subscription {
    /// The next event; none once the run is over and everything was told.
    pub async fn next(&mut self) -> Option<Event> {
        loop {
            let next = self.hub.inner().next(self.reader);
            match next {
                Next::Event(event) => return Some(event),
                Next::Over => return None,
                Next::Nothing | Next::Snapshot { .. } => self.has_more.notified().await,
            }
        }
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        self.hub.inner().readers.remove(&self.reader);
    }
}
