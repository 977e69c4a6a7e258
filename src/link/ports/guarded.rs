//! A daemon's port that is given up once what it lies in is damaged.

use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::daemon::DaemonPort;
use crate::damage;
use crate::link::{Heard, Link, LinkError};
use ambidex_model::ToController;

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
        let done = catch_unwind(AssertUnwindSafe(|| work(port)));
        let is_truncated = damage::count() != before;
        match done {
            Ok(done) if !is_truncated => return Some(done),
            _ if is_truncated => tracing::error!(controller = port.controller(), "a file of the link was truncated"),
            Ok(_) | Err(_) => tracing::error!(controller = port.controller(), "the link panicked, and is given up"),
        }
        if let Some(port) = self.port.take() {
            port.abandon();
        }
        damage::settle();
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
}

impl Drop for GuardedPort {
    fn drop(&mut self) {
        // Its end touches what it lies in, too.
        if let Some(port) = self.port.take() {
            if catch_unwind(AssertUnwindSafe(|| drop(port))).is_err() {
                tracing::error!("the end of a link panicked");
            }
            damage::settle();
        }
    }
}

impl AsFd for GuardedPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        // SAFETY: it is the port's, and one that was given up is never closed.
        unsafe { BorrowedFd::borrow_raw(self.listener) }
    }
}
