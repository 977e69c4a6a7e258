//! Where files come from: a disk, or memory where there is none, as in tests, an editor or a browser.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

use crate::document::MAX_BYTES;

/// Paths to bytes. Text is made of them by the reader, which says where they are none.
pub trait Sources {
    /// The whole content of a file.
    ///
    /// # Errors
    /// When there is no such file, or it cannot be read.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// The one path that stands for all paths of the same file; none where there is no such file.
    fn identity(&self, path: &Path) -> Option<PathBuf>;
}

/// The files of this machine.
#[derive(Debug, Clone, Copy)]
pub struct Disk;

/// Files that are only held in memory.
#[derive(Debug, Clone, Default)]
pub struct InMemory(BTreeMap<PathBuf, Vec<u8>>);

impl Sources for Disk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        // To open a pipe is to wait for somebody who writes to it.
        let metadata = path.metadata()?;
        if !metadata.is_file() && !metadata.is_dir() {
            return Err(io::Error::new(ErrorKind::InvalidInput, "it is no regular file"));
        }
        let mut bytes = Vec::new();
        // One byte too many is enough to be refused.
        File::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    fn identity(&self, path: &Path) -> Option<PathBuf> {
        path.canonicalize().ok()
    }
}

impl InMemory {
    /// Adds a file, or replaces the one of the same path.
    pub fn insert(&mut self, path: impl AsRef<Path>, content: impl Into<Vec<u8>>) {
        self.0.insert(plain(path.as_ref()), content.into());
    }
}

impl Sources for InMemory {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.0.get(&plain(path)).cloned().ok_or_else(|| ErrorKind::NotFound.into())
    }

    fn identity(&self, path: &Path) -> Option<PathBuf> {
        Some(plain(path)).filter(|path| self.0.contains_key(path))
    }
}

/// A path without `.`, and without `..` behind a name.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if plain.file_name().is_some() => drop(plain.pop()),
            Component::ParentDir | Component::Normal(_) | Component::RootDir | Component::Prefix(_) => {
                plain.push(component);
            }
        }
    }
    plain
}
