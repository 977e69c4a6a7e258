//! Logs of earlier runs, for the verbs that read them.

use std::path::{Path, PathBuf};

use ambidex::ipc::Instance;
use ambidex::journal::{self, JournalError, Reader};
use ambidex::model::Record;

use crate::out;

/// The file that a word means: a file, else the log of the instance of that name.
pub fn path(arg: &str) -> PathBuf {
    let file = Path::new(arg);
    if file.exists() {
        return file.to_owned();
    }
    let of_instance =
        Instance::new(arg).ok().map(|instance| journal::default_folder(instance.name()).join("journal.jsonl"));
    of_instance.filter(|log| log.exists()).unwrap_or_else(|| file.to_owned())
}

/// Reads a log to its end or to where it was cut off, which is said.
///
/// # Errors
/// When it cannot be read or is no log of this version.
pub fn read(path: &Path, take: impl FnMut(&Record)) -> Result<(), JournalError> {
    finish(path, Reader::open(path)?, take)
}

/// The rest of an opened log.
///
/// # Errors
/// When it cannot be read on.
pub fn finish(
    path: &Path,
    mut reader: Reader<impl std::io::BufRead>,
    mut take: impl FnMut(&Record),
) -> Result<(), JournalError> {
    for record in reader.by_ref() {
        take(&record?);
    }
    if reader.is_truncated() {
        out::say(&format!("{}: the log was cut off in its last line", path.display()));
    }
    Ok(())
}
