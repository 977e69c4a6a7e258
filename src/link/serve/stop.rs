//! Telling a controller to stop: by signal or by hand, as a descriptor that becomes readable.

use std::io::{self, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::low_level::pipe;

/// Readable once the controller is to stop.
#[derive(Debug)]
pub struct Stop {
    reader: UnixStream,
}

/// The other end of a [`Stop`].
#[derive(Debug)]
pub struct Stopper {
    writer: UnixStream,
}

impl Stop {
    /// Stops on SIGTERM, SIGINT and SIGHUP.
    ///
    /// # Errors
    /// When the handlers cannot be set.
    pub fn on_signals() -> io::Result<Self> {
        let (reader, writer) = UnixStream::pair()?;
        pipe::register(SIGINT, writer.try_clone()?)?;
        pipe::register(SIGHUP, writer.try_clone()?)?;
        pipe::register(SIGTERM, writer)?;
        Ok(Self { reader })
    }

    /// Stops when the other end says so or is dropped.
    ///
    /// # Errors
    /// When the pair cannot be made.
    pub fn by_hand() -> io::Result<(Self, Stopper)> {
        let (reader, writer) = UnixStream::pair()?;
        Ok((Self { reader }, Stopper { writer }))
    }
}

impl Stopper {
    /// Tells the controller to stop.
    pub fn stop(mut self) {
        // It fails only if the controller is gone, which is what was wanted.
        let _ = self.writer.write_all(b"x");
    }
}

impl AsFd for Stop {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.reader.as_fd()
    }
}
