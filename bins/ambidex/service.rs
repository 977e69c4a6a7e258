//! What a service manager is told: that the robot's runtime takes controllers, what it is at, that it lives, that it
//! ends. Nothing where no manager started the process.

use std::env;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

use sd_notify::{NotifyState, notify, watchdog_enabled};
use tokio::time::{MissedTickBehavior, interval};

use crate::diagnostics::legible;

/// Words that may wait while the manager takes none; what comes then is dropped.
const WAITING: usize = 16;
/// The longest time between two signs of life, however patient the manager is.
const PULSE_AT_MOST: Duration = Duration::from_secs(60);
/// How long the last words may take.
const LAST_WORDS: Duration = Duration::from_millis(200);

/// The way to the service manager. Whoever tells it something does not wait for it.
#[derive(Debug, Clone)]
pub struct Service(Option<SyncSender<Word>>);

/// What it is told.
#[derive(Debug)]
enum Word {
    Ready,
    Pulse,
    Status(String),
    Stopping,
    /// All that came before is told.
    Last(SyncSender<()>),
}

impl Service {
    /// The manager that started this process, by its environment, which stays as it is: what children make of it is
    /// their affair, and managers listen to the main process alone unless told otherwise.
    pub fn start() -> Self {
        let to = env::var_os("NOTIFY_SOCKET").and_then(|_| {
            let (to, from) = sync_channel(WAITING);
            // A manager that takes nothing blocks this thread alone.
            thread::Builder::new().name("service".into()).spawn(move || tell(&from)).ok().map(|_| to)
        });
        Self(to)
    }

    /// Whether there is anybody to be told.
    pub fn is_supervised(&self) -> bool {
        self.0.is_some()
    }

    /// Controllers may come, and others may ask.
    pub fn ready(&self) {
        self.say(Word::Ready);
    }

    /// What the run is at.
    pub fn status(&self, status: &str) {
        self.say(Word::Status(legible(status)));
    }

    /// The run is about to end.
    pub fn stopping(&self) {
        self.say(Word::Stopping);
    }

    /// Shows that the thread lives on which this is polled, twice as often as the manager wants, for ever: to be a task
    /// among those that must not hang.
    pub async fn pulse(self) {
        let within = watchdog_enabled().filter(|within| self.is_supervised() && !within.is_zero());
        if let Some(within) = within {
            self.pulse_within(within).await;
        }
    }

    async fn pulse_within(self, within: Duration) {
        let mut pulses = interval((within / 2).min(PULSE_AT_MOST));
        pulses.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            pulses.tick().await;
            self.say(Word::Pulse);
        }
    }

    /// Waits a moment for what was said to be told.
    pub fn finish(&self) {
        let (told, is_told) = sync_channel(1);
        if self.say(Word::Last(told)) {
            // A manager that takes nothing is not waited for.
            let _ = is_told.recv_timeout(LAST_WORDS);
        }
    }

    fn say(&self, word: Word) -> bool {
        match self.0.as_ref().map(|to| to.try_send(word)) {
            Some(Ok(())) => true,
            None | Some(Err(TrySendError::Full(_) | TrySendError::Disconnected(_))) => false,
        }
    }
}

fn tell(from: &Receiver<Word>) {
    for word in from {
        let told = match &word {
            Word::Ready => notify(&[NotifyState::Ready]),
            Word::Pulse => notify(&[NotifyState::Watchdog]),
            Word::Status(status) => notify(&[NotifyState::Status(status)]),
            Word::Stopping => notify(&[NotifyState::Stopping]),
            Word::Last(told) => {
                // Who waited may have gone on.
                let _ = told.try_send(());
                Ok(())
            }
        };
        if let Err(error) = told {
            tracing::warn!(%error, ?word, "the service manager cannot be told");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn it_pulses_twice_as_often_as_is_wanted() {
        let (to, from) = sync_channel(WAITING);
        let within = Duration::from_secs(2);
        tokio::spawn(Service(Some(to)).pulse_within(within));
        tokio::time::sleep(2 * within + within / 4).await;
        assert_eq!(from.try_iter().filter(|word| matches!(word, Word::Pulse)).count(), 5, "at once, too");
    }

    #[tokio::test]
    async fn a_thread_that_does_not_take_up_its_tasks_does_not_show_that_it_lives() {
        let (to, from) = sync_channel(WAITING);
        let within = Duration::from_millis(10);
        tokio::spawn(Service(Some(to)).pulse_within(within));
        tokio::time::sleep(2 * within).await;
        assert!(from.try_iter().count() > 0);
        // Whatever hangs there does not wait as a task does.
        thread::sleep(10 * within);
        assert_eq!(from.try_iter().count(), 0);
        tokio::time::sleep(2 * within).await;
        assert!(from.try_iter().count() > 0, "it lives again");
    }

    #[test]
    fn who_is_told_and_takes_nothing_is_not_waited_for() {
        let (to, _from) = sync_channel(1);
        let service = Service(Some(to));
        for _ in 0..3 {
            service.status("waits");
        }
        service.finish();
        Service(None).finish();
    }
}
