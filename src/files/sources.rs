//! Where files come from: a disk, or memory where there is none, as in tests, an editor or a browser.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

use crate::document::MAX_BYTES;
use crate::settings::Setting;
use ambidex_model::{Source, SourceFile, SourceKind};

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

/// What was read of other sources, to be kept with what was made of it; and the other paths by which it was named.
pub(crate) struct Recorder<'s> {
    sources: &'s dyn Sources,
    read: RefCell<Vec<(PathBuf, Vec<u8>)>>,
    named: RefCell<BTreeSet<PathBuf>>,
}

/// The files of a mission as they were when it was made.
#[derive(Debug, Clone, Default)]
pub(crate) struct Kept(BTreeMap<PathBuf, (PathBuf, Vec<u8>)>);

impl<'s> Recorder<'s> {
    pub(crate) fn new(sources: &'s dyn Sources) -> Self {
        Self { sources, read: RefCell::default(), named: RefCell::default() }
    }

    /// What was read to make something of a file.
    pub(crate) fn source(&self, kind: SourceKind, path: &Path, robot: Option<&Path>, settings: &[Setting]) -> Source {
        let folder = path.parent().unwrap_or(Path::new(""));
        Source {
            kind,
            mission: below(folder, path),
            robot: robot.map(|robot| below(folder, robot)),
            settings: Setting::pairs(settings),
            files: self.files(folder),
        }
    }

    /// All that was read, then all that it was called beside that, with paths as seen from a folder.
    fn files(&self, folder: &Path) -> Vec<SourceFile> {
        let read = self.read.borrow();
        let mut first: BTreeMap<PathBuf, String> = BTreeMap::new();
        let mut file = |path: &Path, content: Option<&[u8]>| {
            let shown = below(folder, path);
            let identity = self.sources.identity(path);
            let same_as = identity.as_ref().and_then(|identity| first.get(identity).cloned());
            if let Some(identity) = identity {
                first.entry(identity).or_insert_with(|| shown.clone());
            }
            let text = content.filter(|_| same_as.is_none()).unwrap_or_default();
            SourceFile { path: shown, same_as, text: String::from_utf8_lossy(text).into_owned() }
        };
        let mut files: Vec<SourceFile> = read.iter().map(|(path, content)| file(path, Some(content))).collect();
        let named = self.named.borrow();
        let others = named.iter().filter(|named| read.iter().all(|(path, _)| path != *named));
        // What is the same as nothing that was read is not part of the mission.
        files.extend(others.map(|path| file(path, None)).filter(|file| file.same_as.is_some()));
        files
    }
}

/// A path as seen from a folder where it lies below it, else as it is.
fn below(folder: &Path, path: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).to_string_lossy().into_owned()
}

impl Sources for Recorder<'_> {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let content = self.sources.read(path)?;
        let mut read = self.read.borrow_mut();
        if read.iter().all(|(known, _)| known != path) {
            read.push((path.to_owned(), content.clone()));
        }
        Ok(content)
    }

    fn identity(&self, path: &Path) -> Option<PathBuf> {
        self.named.borrow_mut().insert(path.to_owned());
        self.sources.identity(path)
    }
}

impl Kept {
    pub(crate) fn new(source: &Source) -> Self {
        let mut originals: BTreeMap<&str, &SourceFile> = BTreeMap::new();
        for file in &source.files {
            originals.entry(&file.path).or_insert(file);
        }
        let file = |file: &SourceFile| {
            let identity = file.same_as.as_ref().unwrap_or(&file.path);
            let original = originals.get(identity.as_str()).copied().unwrap_or(file);
            (without_dots(file.path.as_ref()), (without_dots(identity.as_ref()), original.text.clone().into_bytes()))
        };
        Self(source.files.iter().map(file).collect())
    }
}

/// A path without `.`, wherever it stands.
fn without_dots(path: &Path) -> PathBuf {
    path.components().filter(|component| *component != Component::CurDir).collect()
}

impl Sources for Kept {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.0.get(&without_dots(path)).map(|(_, content)| content.clone()).ok_or_else(|| ErrorKind::NotFound.into())
    }

    fn identity(&self, path: &Path) -> Option<PathBuf> {
        self.0.get(&without_dots(path)).map(|(identity, _)| identity.clone())
    }
}

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
