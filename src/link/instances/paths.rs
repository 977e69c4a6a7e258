//! Where instances lie: the folder of this user, and what their segments of shared memory begin with.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// What the names of all segments begin with.
pub(crate) const PREFIX: &str = "ambidex_";

/// The folder of all instances of this user.
pub(crate) fn base() -> PathBuf {
    let uid = rustix::process::getuid().as_raw();
    let shared = shared_memory();
    let root = if shared.is_dir() { shared.to_owned() } else { std::env::temp_dir() };
    root.join(format!("ambidex-{uid}"))
}

/// Where the system shows its segments of shared memory as files.
pub fn shared_memory() -> &'static Path {
    Path::new("/dev/shm")
}

pub(crate) fn prefix_of(tag: &str) -> String {
    format!("{PREFIX}{tag}_")
}

/// Segments of shared memory of this user whose names begin with the prefix.
pub(crate) fn segments(prefix: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(shared_memory()) else {
        return Vec::new();
    };
    let own = rustix::process::getuid().as_raw();
    entries
        .flatten()
        .filter(|entry| entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()))
        // Root could remove those of others, too.
        .filter(|entry| entry.metadata().is_ok_and(|about| about.uid() == own))
        .map(|entry| entry.path())
        .collect()
}
