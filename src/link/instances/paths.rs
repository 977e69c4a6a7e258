//! Where instances lie: the folder of this user, and what their segments of shared memory begin with.

use std::fs;
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
pub(crate) fn shared_memory() -> &'static Path {
    Path::new("/dev/shm")
}

pub(crate) fn prefix_of(tag: &str) -> String {
    format!("{PREFIX}{tag}_")
}

/// Segments of shared memory whose names begin with the prefix.
pub(crate) fn segments(prefix: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(shared_memory()) else {
        return Vec::new();
    };
    entries
        .flatten()
        .filter(|entry| entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()))
        .map(|entry| entry.path())
        .collect()
}
