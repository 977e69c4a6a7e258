//! Waiting for Ctrl-C beside something that goes on.

use std::time::Duration;

use ambidex::link::Stop;
use miette::{IntoDiagnostic, Result};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// Waits for Ctrl-C or SIGTERM, at most for a while; true if one came.
pub fn is_stopped(stop: &Stop, at_most: Duration) -> Result<bool> {
    let timeout = Timespec::try_from(at_most).into_diagnostic()?;
    match poll(&mut [PollFd::new(stop, PollFlags::IN)], Some(&timeout)) {
        Ok(ready) => Ok(ready > 0),
        Err(rustix::io::Errno::INTR) => Ok(false),
        Err(error) => Err(error).into_diagnostic(),
    }
}
