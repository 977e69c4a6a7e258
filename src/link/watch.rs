//! Seeing that another process ended, at once and without asking it.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};

use crate::error::IpcError;

/// A process that is watched: readable once it has ended.
#[derive(Debug)]
pub struct Pidfd {
    fd: OwnedFd,
    pid: u32,
}

impl Pidfd {
    /// Watches a process.
    ///
    /// # Errors
    /// [`IpcError::Watch`]; also if it has ended already, see [`has_ended`](Self::has_ended).
    pub fn open(pid: u32) -> Result<Self, IpcError> {
        let raw = i32::try_from(pid).ok().and_then(Pid::from_raw);
        let opened = match raw {
            Some(raw) => pidfd_open(raw, PidfdFlags::NONBLOCK).map_err(io::Error::from),
            None => Err(io::Error::from(io::ErrorKind::InvalidInput)),
        };
        let fd = opened.map_err(|source| IpcError::Watch { pid, source })?;
        Ok(Self { fd, pid })
    }

    /// Whose end it shows.
    pub fn pid(&self) -> u32 {
        self.pid
    }

    /// Whether the process has ended.
    pub fn has_ended(&self) -> bool {
        let mut fds = [PollFd::new(&self.fd, PollFlags::IN)];
        poll(&mut fds, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
    }
}

impl AsFd for Pidfd {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}

impl From<Pidfd> for OwnedFd {
    fn from(watched: Pidfd) -> Self {
        watched.fd
    }
}
