//! A daemon's port that is given up once what it lies in is damaged.

use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::sync::Arc;

use super::daemon::DaemonPort;
use crate::damage;
use crate::link::{Heard, Link, LinkError};
use ambidex_model::{Labels, ToController};

/// A [`DaemonPort`] for a process that [survives truncation](crate::survive_truncation). What was heard or sent while
/// something was missing does not count, and nothing is heard or sent any more.
#[derive(Debug)]
pub struct GuardedPort {
    port: Option<DaemonPort>,
    epoch: u64,
    listener: RawFd,
    is_told: bool,
}

impl GuardedPort {
    /// Guards a port.
    pub fn new(port: DaemonPort) -> Self {
        Self { epoch: port.epoch(), listener: port.as_raw_fd(), port: Some(port), is_told: false }
    }

    /// What the work gives, unless it comes upon damage: what was truncated, or what the transport panics over since others
    /// overwrote it.
    fn guarded<T>(&mut self, work: impl FnOnce(&mut DaemonPort) -> T) -> Option<T> {
        let port = self.port.as_mut()?;
        let before = damage::count();
        let done = damage::contained(|| work(port));
        let controller = port.controller();
        match done {
            _ if damage::count() != before => tracing::error!(controller, "a file of the link was truncated"),
            Ok(done) => return Some(done),
            Err(why) => tracing::error!(controller, why, "the link is damaged, and given up"),
        }
        if let Some(port) = self.port.take() {
            port.abandon();
        }
        None
    }
}

impl Link for GuardedPort {
    fn send(&mut self, message: &ToController) -> Result<(), LinkError> {
        self.guarded(|port| port.send(message)).unwrap_or(Err(LinkError::Absent))
    }

    fn drain(&mut self) -> Vec<Heard> {
        if let Some(heard) = self.guarded(DaemonPort::drain) {
            return heard;
        }
        let is_news = !std::mem::replace(&mut self.is_told, true);
        is_news.then_some(Heard::Broken).into_iter().collect()
    }

    fn epoch(&self) -> u64 {
        self.epoch
    }

    fn beat(&mut self) {
        self.guarded(DaemonPort::beat);
    }

    fn forget(&mut self) {
        self.guarded(DaemonPort::forget);
    }

    fn know(&mut self, labels: &Arc<Labels>) {
        self.guarded(|port| port.know(labels));
    }
}

impl Drop for GuardedPort {
    fn drop(&mut self) {
        // Its end touches what it lies in, too.
        if let Some(port) = self.port.take()
            && let Err(why) = damage::contained(|| drop(port))
        {
            tracing::error!(why, "a link was damaged when it ended");
        }
    }
}

impl AsFd for GuardedPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        // SAFETY: it is the port's, and one that was given up is never closed.
        unsafe { BorrowedFd::borrow_raw(self.listener) }
    }
}
