//! Whether a log has a writer.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

/// Whether a process writes this log at this moment.
///
/// # Errors
/// When the file cannot be looked at.
pub fn is_being_written(path: &Path) -> io::Result<bool> {
    match File::open(path)?.try_lock_shared() {
        Ok(()) => Ok(false),
        Err(TryLockError::WouldBlock) => Ok(true),
        Err(TryLockError::Error(error)) => Err(error),
    }
}
