//! How well each controller is, said once a second. What happens is counted where it happens; nothing decides by it.
//!
//! Whoever wants every second [subscribes](Feed). The log has only what differs from the second before, but for the
//! numbers: a robot that is well adds a line per controller to it, and one that is not at most a line per second.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{Notify, watch};
use tokio::time::timeout;

use super::clock::Clock;
use super::journal_task::Journal;
use super::log;
use ambidex_model::session::{DIAGNOSE_EVERY, Monitor};
use ambidex_model::{ControllerId, ControllerMessage, Diagnostics, MissionSpec, Record};

/// The diagnostics of the last second, by controller; empty before the first. Whoever is slow misses seconds and holds up
/// nobody.
pub type Feed = watch::Receiver<Arc<[Diagnostics]>>;

/// A second as the clock counts it.
const SECOND_NS: u64 = DIAGNOSE_EVERY.as_nanos() as u64;

/// How long nobody need beat until it is time all the same.
const BEATLESS: Duration = DIAGNOSE_EVERY.saturating_mul(2);

/// What is counted of each controller, by controller.
#[derive(Debug, Clone)]
pub(super) struct Monitors(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    monitors: Box<[Mutex<Monitor>]>,
    /// When the second is over, nanoseconds.
    over_ns: AtomicU64,
    is_over: Notify,
}

impl Monitors {
    /// Of so many controllers that were not seen yet.
    pub(super) fn new(controllers: usize, now_ns: u64) -> Self {
        let monitor = |index| Mutex::new(Monitor::new(ControllerId::from(index), now_ns));
        let monitors = (0..controllers).map(monitor).collect();
        let over_ns = AtomicU64::new(now_ns.saturating_add(SECOND_NS));
        Self(Arc::new(Shared { monitors, over_ns, is_over: Notify::new() }))
    }

    /// A link beats: the daemon is awake anyway, and a timer of its own would wake it once more each second.
    pub(super) fn beat(&self, now_ns: u64) {
        let over_ns = self.0.over_ns.load(Ordering::Relaxed);
        if now_ns >= over_ns {
            // Seconds that passed without a beat are over, too.
            let next_ns = over_ns + ((now_ns - over_ns) / SECOND_NS + 1) * SECOND_NS;
            self.0.over_ns.store(next_ns, Ordering::Relaxed);
            self.0.is_over.notify_one();
        }
    }

    /// What is counted of one. All tasks share a thread and none waits while it holds this, so nobody waits for it.
    pub(super) fn of(&self, id: ControllerId) -> MutexGuard<'_, Monitor> {
        self.0.monitors[id.index()].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts what a record says of a controller.
    pub(super) fn note(&self, record: &Record) {
        if let Record::Controller { controller, message, .. } = record {
            self.of(*controller).note(message);
        }
    }
}

/// Says once a second how well controllers are.
pub(super) struct DiagnosticsTask {
    pub(super) mission: Arc<MissionSpec>,
    pub(super) monitors: Monitors,
    pub(super) clock: Clock,
    pub(super) journal: Option<Journal>,
    pub(super) feed: watch::Sender<Arc<[Diagnostics]>>,
}

impl DiagnosticsTask {
    /// Lives until it is aborted.
    pub(super) async fn run(self) {
        let mut last: Arc<[Diagnostics]> = Arc::default();
        loop {
            // Without any beat it is told all the same, if later.
            let _ = timeout(BEATLESS, self.monitors.0.is_over.notified()).await;
            let now_ns = self.clock.now_ns();
            let ids = (0..self.monitors.0.monitors.len()).map(ControllerId::from);
            let now: Arc<[Diagnostics]> = ids.map(|id| self.monitors.of(id).diagnose(now_ns)).collect();
            for diagnostics in now.iter() {
                self.say(diagnostics, last.get(diagnostics.controller.index()));
            }
            last = Arc::clone(&now);
            self.feed.send_replace(now);
        }
    }

    fn say(&self, now: &Diagnostics, last: Option<&Diagnostics>) {
        let at = self.clock.now();
        let is_change = last.is_none_or(|last| last.level != now.level);
        log::diagnosed(at, now, is_change, &self.mission.names);
        let is_news = last.is_none_or(|last| !last.agrees_with(now));
        if let Some(journal) = self.journal.as_ref().filter(|journal| is_news && !journal.is_over()) {
            let Diagnostics { controller, level, message, values } = *now;
            let message = ControllerMessage::Diagnosed { level, message, values: Box::new(values) };
            journal.write(Record::Controller { at, controller, message });
        }
    }
}
