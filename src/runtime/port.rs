//! Links that can be waited for.

use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use rustix::time::{
    Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, Timespec, timerfd_create, timerfd_settime,
};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::time::{Sleep, sleep};

use ambidex_link::watch::Pidfd;
use ambidex_link::{Heard, Link, LinkError, monotonic_ns};
use ambidex_model::session::{BEAT_EVERY, Pace};
use ambidex_model::{Labels, ToController};

/// More calls than any honest controller has reason for: one that calls for ever leaves time for the others.
const WAKES_MAX: u32 = 64;
const WAKES_WINDOW: Duration = Duration::from_millis(5);

/// What wakes the task of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wake {
    /// Something may have come: [`Link::drain`] it.
    Heard,
    /// It is time to beat, and to see who does not pulse.
    Beat,
    /// The process that was [watched](Port::watch) has ended.
    Ended,
}

/// A link that can be waited for.
pub trait Port: Link + Send {
    /// Ready when there is a reason to look; in a task of tokio.
    fn poll_wake(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<Wake>>;

    /// Watches the controller's process from now on, and no other.
    fn watch(&mut self, pid: u32);

    /// Watches no process any more.
    fn unwatch(&mut self);
}

/// A link that is readable when something came, as one over shared memory is.
#[derive(Debug)]
pub struct Readable<L> {
    link: L,
    wakeups: Option<AsyncFd<OwnedFd>>,
    life: Option<AsyncFd<OwnedFd>>,
    beats: Option<AsyncFd<OwnedFd>>,
    /// How often its peer is looked at, however often it calls.
    pace: Pace,
    rest: Option<Pin<Box<Sleep>>>,
}

impl<L: Link + AsFd> Readable<L> {
    /// The link with nothing watched yet.
    pub fn new(link: L) -> Self {
        let pace = Pace::new(WAKES_MAX, WAKES_WINDOW);
        Self { link, wakeups: None, life: None, beats: None, pace, rest: None }
    }
}

impl<L: Link + AsFd + Send> Port for Readable<L> {
    fn poll_wake(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<Wake>> {
        if let Some(life) = &self.life
            && life.poll_read_ready(cx).is_ready()
        {
            self.life = None;
            return Poll::Ready(Ok(Wake::Ended));
        }
        let beats = match &mut self.beats {
            Some(beats) => beats,
            none => none.insert(watched(beats()?)?),
        };
        if let Poll::Ready(ready) = beats.poll_read_ready(cx) {
            let mut ready = ready?;
            // How often it came meanwhile does not matter.
            let is_due = rustix::io::read(ready.get_inner(), &mut [0; 8]).is_ok();
            ready.clear_ready();
            if is_due {
                return Poll::Ready(Ok(Wake::Beat));
            }
        }
        if let Some(rest) = &mut self.rest {
            ready!(rest.as_mut().poll(cx));
            self.rest = None;
        }
        let wakeups = match &mut self.wakeups {
            Some(wakeups) => wakeups,
            none => none.insert(watched(self.link.as_fd().try_clone_to_owned()?)?),
        };
        ready!(wakeups.poll_read_ready(cx))?.clear_ready();
        let now_ns = monotonic_ns();
        self.pace.takes(now_ns);
        let spent_until = self.pace.spent_until(now_ns);
        self.rest = spent_until.map(|until_ns| Box::pin(sleep(Duration::from_nanos(until_ns - now_ns))));
        Poll::Ready(Ok(Wake::Heard))
    }

    fn watch(&mut self, pid: u32) {
        // One that has ended already is told by its silence.
        self.life = Pidfd::open(pid).ok().and_then(|life| watched(life.into()).ok());
    }

    fn unwatch(&mut self) {
        self.life = None;
    }
}

impl<L: Link> Link for Readable<L> {
    fn send(&mut self, message: &ToController) -> Result<(), LinkError> {
        self.link.send(message)
    }

    fn drain(&mut self) -> Vec<Heard> {
        self.link.drain()
    }

    fn epoch(&self) -> u64 {
        self.link.epoch()
    }

    fn beat(&mut self) {
        self.link.beat();
    }

    fn forget(&mut self) {
        self.link.forget();
    }

    fn know(&mut self, labels: &Arc<Labels>) {
        self.link.know(labels);
    }
}

/// Readable whenever a beat is due. Those of all links are due at the same moments, so that one wake-up serves all of them;
/// tokio's own timers would wake twice for each.
fn beats() -> io::Result<OwnedFd> {
    let timer = timerfd_create(TimerfdClockId::Monotonic, TimerfdFlags::NONBLOCK | TimerfdFlags::CLOEXEC)?;
    let period_ns = u64::try_from(BEAT_EVERY.as_nanos()).unwrap_or(u64::MAX);
    let first_ns = (monotonic_ns() / period_ns + 1) * period_ns;
    let span = |ns| Timespec::try_from(Duration::from_nanos(ns)).map_err(io::Error::other);
    let timing = Itimerspec { it_interval: span(period_ns)?, it_value: span(first_ns)? };
    timerfd_settime(&timer, TimerfdTimerFlags::ABSTIME, &timing)?;
    Ok(timer)
}

/// Comes back when the process has ended, also if it had before.
///
/// # Errors
/// When its end cannot be waited for.
pub async fn process_end(pid: u32) -> io::Result<()> {
    let Ok(life) = Pidfd::open(pid) else { return Ok(()) };
    drop(watched(life.into())?.readable().await?);
    Ok(())
}

fn watched(fd: OwnedFd) -> io::Result<AsyncFd<OwnedFd>> {
    // SAFETY: an `OwnedFd` is the only owner of its descriptor, which stays open until the `AsyncFd` drops it.
    let registered = unsafe { AsyncFd::register_with_interest(fd, Interest::READABLE) };
    registered.map_err(io::Error::from)
}
