//! One task per controller link: wake-ups from its descriptor, the daemon's heartbeat, and the watch over its life.

use std::collections::VecDeque;
use std::os::fd::{AsFd, OwnedFd};

use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval};

use ambidex_core::dispatch::Input;
use ambidex_link::watch::Pidfd;
use ambidex_link::{BEAT_EVERY, Heard, Link, LinkError};
use ambidex_model::{ControllerId, FromController, Rejection, ToController};

/// A link that can be waited for.
pub trait Port: Link + AsFd + Send {}

impl<T: Link + AsFd + Send> Port for T {}

/// A link with its neighbors.
pub(super) struct LinkTask {
    pub(super) id: ControllerId,
    pub(super) link: Box<dyn Port>,
    pub(super) orders: mpsc::UnboundedReceiver<ToController>,
    pub(super) dispatch: mpsc::UnboundedSender<Input>,
}

/// What a link's task knows of its controller.
struct Watch {
    waiting: VecDeque<ToController>,
    life: Option<AsyncFd<OwnedFd>>,
    is_attached: bool,
    /// It has shown that it is configured by this daemon.
    serves: bool,
}

impl LinkTask {
    /// Lives until the run is over.
    ///
    /// # Errors
    /// When a descriptor cannot be watched.
    pub(super) async fn run(mut self) -> std::io::Result<()> {
        let wakeups = watched(self.link.as_fd().try_clone_to_owned()?)?;
        let mut beat = interval(BEAT_EVERY);
        beat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut watch = Watch { waiting: VecDeque::new(), life: None, is_attached: false, serves: false };
        loop {
            let mut has_died = false;
            tokio::select! {
                ready = wakeups.readable() => ready?.clear_ready(),
                order = self.orders.recv() => match order {
                    Some(order) => watch.waiting.push_back(order),
                    None => return Ok(()),
                },
                () = died(watch.life.as_ref()) => has_died = true,
                _ = beat.tick() => self.link.beat(),
            }
            let has_left = self.hear(&mut watch);
            self.attend(&mut watch, has_died || has_left);
            self.send(&mut watch.waiting);
        }
    }

    /// Takes all that came; a wake-up is only a hint. True when the controller gave this daemon up, as one that was
    /// silent for too long.
    fn hear(&mut self, watch: &mut Watch) -> bool {
        let mut has_left = false;
        for heard in self.link.drain() {
            let input = match heard {
                Heard::Message(message) => Input::Heard(self.id, message),
                Heard::Refused(why) => Input::Refused(self.id, why),
                Heard::Closed(command) => Input::Closed(self.id, command),
                Heard::State { generation, .. } => {
                    has_left |= watch.serves && generation == 0;
                    watch.serves = generation != 0;
                    continue;
                }
            };
            drop(self.dispatch.send(input));
        }
        has_left
    }

    fn attend(&mut self, watch: &mut Watch, is_gone: bool) {
        match (watch.is_attached, self.link.is_attached()) {
            (false, Some(pid)) if !is_gone => {
                watch.is_attached = true;
                watch.life = Pidfd::open(pid).ok().and_then(|life| watched(life.into()).ok());
                drop(self.dispatch.send(Input::Attached(self.id)));
            }
            (true, Some(_)) if !is_gone => {}
            (true, _) => {
                watch.is_attached = false;
                watch.serves = false;
                watch.life = None;
                watch.waiting.clear();
                self.link.forget();
                drop(self.dispatch.send(Input::Lost(self.id)));
            }
            (false, _) => {}
        }
    }

    /// Sends in order; what the controller cannot take yet is tried again at the next wake-up.
    fn send(&mut self, waiting: &mut VecDeque<ToController>) {
        while let Some(message) = waiting.front() {
            match self.link.send(message) {
                Ok(()) => {}
                Err(LinkError::Absent | LinkError::Full) => return,
                Err(LinkError::PathLength(_) | LinkError::Generation(_) | LinkError::Transport(_)) => {
                    if let ToController::Goal { id, .. } = message {
                        let rejected = FromController::Rejected { id: *id, why: Rejection::Malformed };
                        drop(self.dispatch.send(Input::Heard(self.id, rejected)));
                    }
                }
            }
            waiting.pop_front();
        }
    }
}

fn watched(fd: OwnedFd) -> std::io::Result<AsyncFd<OwnedFd>> {
    // SAFETY: an `OwnedFd` is the only owner of its descriptor, which stays open until the `AsyncFd` drops it.
    let registered = unsafe { AsyncFd::register_with_interest(fd, Interest::READABLE) };
    registered.map_err(std::io::Error::from)
}

/// Comes back when the process has ended; never without one.
async fn died(life: Option<&AsyncFd<OwnedFd>>) {
    match life {
        Some(life) => drop(life.readable().await),
        None => std::future::pending().await,
    }
}
