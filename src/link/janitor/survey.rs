//! What lies in shared memory and in the folders of instances, and whose it is. Looking changes nothing.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::error::IpcError;
use crate::instances::{DAEMON_FILE, DAEMONS_FILES, GlobalLock, PREFIX, base, holder, name_in, prefix_of, segments};

/// All instances of this user, and what belongs to none.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Survey {
    /// The folder of all instances, whether it is there or not.
    pub folder: PathBuf,
    /// In the order of their folders.
    pub instances: Vec<Surveyed>,
    /// Segments of shared memory that belong to no instance.
    pub orphans: Vec<PathBuf>,
}

/// What there is of one instance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Surveyed {
    /// As its own file tells it, else its tag.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Who lives in it.
    pub residents: Vec<Resident>,
    /// Files of processes that are gone: locks that nobody holds, and what only a daemon has.
    pub stale: Vec<PathBuf>,
    /// Its segments of shared memory.
    pub segments: Vec<PathBuf>,
    /// How much memory these take.
    pub bytes: u64,
}

/// A process that has a place in an instance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Resident {
    /// The file of its lock: `daemon.lock`, `controller-NAME.lock`.
    pub lock: String,
    /// Process id, 0 if unknown.
    pub pid: u32,
}

impl Surveyed {
    /// Whether no process lives in it: all that there is of it is left.
    pub fn is_abandoned(&self) -> bool {
        self.residents.is_empty()
    }

    /// The process id of its daemon, if one lives.
    pub fn daemon(&self) -> Option<u32> {
        self.residents.iter().find(|resident| resident.lock == DAEMON_FILE).map(|resident| resident.pid)
    }
}

/// Looks at every instance of this user. It makes nothing and keeps nobody from anything but for a moment.
///
/// # Errors
/// [`IpcError`] when the lock over all instances cannot be had.
pub fn survey() -> Result<Survey, IpcError> {
    // Where there is no gate there is no instance, and nobody to be kept out.
    let global = GlobalLock::join()?;
    let survey = look();
    drop(global);
    Ok(survey)
}

/// The same while the lock over all instances is held.
pub(super) fn look() -> Survey {
    let folder = base();
    let instances: Vec<Surveyed> = instance_dirs(&folder).into_iter().map(surveyed).collect();
    let prefixes: Vec<String> = instances.iter().map(|instance| prefix(&instance.folder)).collect();
    let is_orphan = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        !prefixes.iter().any(|prefix| name.starts_with(prefix))
    };
    let orphans = segments(PREFIX).into_iter().filter(is_orphan).collect();
    Survey { folder, instances, orphans }
}

/// What the segments of the instance begin with that has this folder.
pub(super) fn prefix(folder: &Path) -> String {
    prefix_of(&folder.file_name().unwrap_or_default().to_string_lossy())
}

fn instance_dirs(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut dirs: Vec<_> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    dirs.sort();
    dirs
}

fn surveyed(folder: PathBuf) -> Surveyed {
    let mut files: Vec<_> = fs::read_dir(&folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    files.sort();
    let (locks, others): (Vec<_>, Vec<_>) =
        files.into_iter().partition(|path| path.extension() == Some(OsStr::new("lock")));
    let (mut residents, mut stale) = (Vec::new(), Vec::new());
    for path in locks {
        match holder(&path) {
            Some(pid) => residents.push(Resident { lock: file_name(&path), pid }),
            None => stale.push(path),
        }
    }
    if !residents.iter().any(|resident| resident.lock == DAEMON_FILE) {
        stale.extend(others.into_iter().filter(|path| DAEMONS_FILES.contains(&file_name(path).as_str())));
    }
    let segments = segments(&prefix(&folder));
    let bytes = segments.iter().filter_map(|path| fs::metadata(path).ok()).map(|about| about.blocks() * 512).sum();
    Surveyed { name: name_in(&folder), folder, residents, stale, segments, bytes }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
