//! Who may be daemon or controller: locks that the kernel frees when their process ends, however it ends.

use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use super::instance::{Instance, check_controller_name};
use super::paths::{base, segments};
use super::private;
use crate::error::IpcError;

const GLOBAL_WAIT: Duration = Duration::from_secs(5);
const GLOBAL_POLL: Duration = Duration::from_millis(1);
const GLOBAL_FILE: &str = ".gate";
const NAME_FILE: &str = "name";
/// The lock of a daemon.
pub(crate) const DAEMON_FILE: &str = "daemon.lock";

/// A daemon that lives, as its lock tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Present {
    /// Process id of the daemon, 0 if unknown.
    pub pid: u32,
    /// When it took its place, by the clock of the files.
    pub since: SystemTime,
}

/// The place of a daemon or controller, held until dropped. The last one out removes what the instance left.
#[derive(Debug)]
pub struct Lock {
    file: File,
    path: PathBuf,
    instance: Instance,
}

impl Lock {
    fn for_daemon(instance: &Instance) -> Result<Self, IpcError> {
        Self::take(instance, DAEMON_FILE, |pid| IpcError::DaemonRuns { instance: instance.name().to_owned(), pid })
    }

    fn for_controller(instance: &Instance, name: &str) -> Result<Self, IpcError> {
        let file = format!("controller-{name}.lock");
        Self::take(instance, &file, |pid| IpcError::ControllerRuns {
            instance: instance.name().to_owned(),
            name: name.to_owned(),
            pid,
        })
    }

    /// The daemon that has the place; asking makes no file and keeps nobody from the place.
    fn present(instance: &Instance) -> Result<Option<Present>, IpcError> {
        let path = instance.dir().join(DAEMON_FILE);
        if !path.exists() {
            return Ok(None);
        }
        // Under the global lock nobody tries to take the place, who would be turned away by our trying.
        let _global = GlobalLock::join()?;
        let mut file = match File::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(IpcError::File { path, source }),
        };
        match file.try_lock_shared() {
            Ok(()) => Ok(None),
            Err(TryLockError::WouldBlock) => {
                let since = file.metadata().and_then(|about| about.modified()).map_err(IpcError::file(&path))?;
                Ok(Some(Present { pid: read_pid(&mut file), since }))
            }
            Err(TryLockError::Error(source)) => Err(IpcError::File { path, source }),
        }
    }

    /// The instance that it belongs to.
    pub fn instance(&self) -> &Instance {
        &self.instance
    }

    fn take(instance: &Instance, file_name: &str, taken: impl FnOnce(u32) -> IpcError) -> Result<Self, IpcError> {
        let _global = GlobalLock::enter()?;
        let dir = instance.dir();
        private::folder(&dir)?;
        let name = dir.join(NAME_FILE);
        let file = private::open(File::options().create(true).truncate(true).write(true), &name);
        file.and_then(|mut file| file.write_all(instance.name().as_bytes())).map_err(IpcError::file(&name))?;
        let path = dir.join(file_name);
        let mut file = open(&path)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(taken(read_pid(&mut file))),
            Err(TryLockError::Error(source)) => return Err(IpcError::File { path, source }),
        }
        write_pid(&mut file).map_err(IpcError::file(&path))?;
        Ok(Self { file, path, instance: instance.clone() })
    }
}

impl Instance {
    /// Takes the place of the instance's only daemon, until the lock is dropped or the process ends in any way.
    ///
    /// # Errors
    /// [`IpcError::DaemonRuns`] if it is taken.
    pub fn lock_daemon(&self) -> Result<Lock, IpcError> {
        Lock::for_daemon(self)
    }

    /// Takes the place of the only controller of that name, until the lock is dropped or the process ends in any way.
    ///
    /// # Errors
    /// [`IpcError::ControllerRuns`] if it is taken, [`IpcError::ControllerName`] if it is no name.
    pub fn lock_controller(&self, name: &str) -> Result<Lock, IpcError> {
        check_controller_name(name)?;
        Lock::for_controller(self, name)
    }

    /// The daemon that lives in the instance, if any. Asking makes nothing and keeps nobody from anything.
    ///
    /// # Errors
    /// [`IpcError::GlobalLockHeld`] or [`IpcError::File`] if the lock cannot be looked at.
    pub fn daemon(&self) -> Result<Option<Present>, IpcError> {
        Lock::present(self)
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Without the global lock the file stays, and so does the folder: the next sweep takes them.
        let Ok(_global) = GlobalLock::enter() else {
            return;
        };
        let _ = fs::remove_file(&self.path);
        let _ = self.file.unlock();
        let dir = self.instance.dir();
        if is_abandoned(&dir) {
            remove_instance(&dir, &self.instance.prefix());
        }
    }
}

/// The lock over all instances of a user: while it is held no instance begins, ends or is swept.
#[derive(Debug)]
pub(crate) struct GlobalLock {
    _file: File,
    path: PathBuf,
}

impl GlobalLock {
    pub(crate) fn enter() -> Result<Self, IpcError> {
        let base = base();
        let path = base.join(GLOBAL_FILE);
        let begun = Instant::now();
        loop {
            private::folder(&base)?;
            // Whoever was here before may have removed folder and file since, so a lock counts only on the file that is there.
            if let Some(file) = lock_global(&path, true)? {
                return Ok(Self { _file: file, path });
            }
            wait_for_global(begun, &path)?;
        }
    }

    /// Enters by the global lock that is there; none where there is no gate, since then there is no instance.
    pub(crate) fn join() -> Result<Option<Self>, IpcError> {
        let path = base().join(GLOBAL_FILE);
        let begun = Instant::now();
        while path.exists() {
            if let Some(file) = lock_global(&path, false)? {
                return Ok(Some(Self { _file: file, path }));
            }
            wait_for_global(begun, &path)?;
        }
        Ok(None)
    }
}

fn wait_for_global(begun: Instant, path: &Path) -> Result<(), IpcError> {
    if begun.elapsed() > GLOBAL_WAIT {
        return Err(IpcError::GlobalLockHeld(path.to_owned()));
    }
    thread::sleep(GLOBAL_POLL);
    Ok(())
}

impl Drop for GlobalLock {
    fn drop(&mut self) {
        let Some(base) = self.path.parent() else {
            return;
        };
        let is_last =
            fs::read_dir(base).is_ok_and(|entries| entries.flatten().all(|entry| entry.file_name() == GLOBAL_FILE));
        if is_last {
            let _ = fs::remove_file(&self.path);
            let _ = fs::remove_dir(base);
        }
    }
}

/// Whether no living process holds a lock in the folder. Ask under the global lock.
fn is_abandoned(dir: &Path) -> bool {
    let Ok(entries) = fs::read_dir(dir) else {
        return false;
    };
    entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension() == Some(OsStr::new("lock")))
        .all(|path| holder(&path).is_none())
}

/// Who holds a lock, 0 if that is not known; whose file cannot be opened is held. Ask under the global lock.
pub(crate) fn holder(lock: &Path) -> Option<u32> {
    let Ok(mut file) = File::open(lock) else { return Some(0) };
    match file.try_lock_shared() {
        Ok(()) => None,
        Err(TryLockError::WouldBlock | TryLockError::Error(_)) => Some(read_pid(&mut file)),
    }
}

/// Removes the folder and every segment of shared memory of an instance; returns how many segments. Call under the global lock.
pub(crate) fn remove_instance(dir: &Path, prefix: &str) -> usize {
    let _ = fs::remove_dir_all(dir);
    segments(prefix).into_iter().filter(|path| fs::remove_file(path).is_ok()).count()
}

/// The name of the instance whose folder that is.
pub(crate) fn name_in(dir: &Path) -> String {
    fs::read_to_string(dir.join(NAME_FILE))
        .unwrap_or_else(|_| dir.file_name().unwrap_or_default().to_string_lossy().into_owned())
}

fn lock_global(path: &Path, creates: bool) -> Result<Option<File>, IpcError> {
    let file = match private::open(File::options().create(creates).append(true), path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(IpcError::file(path)(source)),
    };
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Ok(None),
        Err(TryLockError::Error(source)) => return Err(IpcError::file(path)(source)),
    }
    let held = file.metadata().map_err(IpcError::file(path))?;
    let is_there = fs::metadata(path).is_ok_and(|there| (there.dev(), there.ino()) == (held.dev(), held.ino()));
    Ok(is_there.then_some(file))
}

fn open(path: &Path) -> Result<File, IpcError> {
    let options = &mut File::options();
    private::open(options.create(true).truncate(false).read(true).write(true), path).map_err(IpcError::file(path))
}

fn read_pid(file: &mut File) -> u32 {
    let mut text = String::new();
    let _ = file.read_to_string(&mut text);
    text.trim().parse().unwrap_or(0)
}

fn write_pid(file: &mut File) -> std::io::Result<()> {
    file.set_len(0)?;
    file.seek(SeekFrom::Start(0))?;
    writeln!(file, "{}", std::process::id())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_taken_once_and_the_last_one_out_leaves_nothing() {
        let instance = Instance::fresh();
        let daemon = instance.lock_daemon().unwrap();
        let refused = instance.lock_daemon().unwrap_err().to_string();
        let pid = std::process::id();
        assert_eq!(refused, format!("a daemon of instance `{}` runs already (pid {pid})", instance.name()));
        let arm = instance.lock_controller("left_arm").unwrap();
        assert!(instance.lock_controller("left_arm").is_err());
        drop(instance.lock_controller("right_arm").unwrap());
        drop(daemon);
        assert!(instance.dir().exists());
        drop(instance.lock_daemon().unwrap());
        drop(arm);
        assert!(!instance.dir().exists());
    }

    #[test]
    fn whoever_asks_is_in_nobodys_way() {
        let instance = Instance::fresh();
        let arm = instance.lock_controller("left_arm").unwrap();
        let is_over = std::sync::atomic::AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| {
                while !is_over.load(std::sync::atomic::Ordering::Relaxed) {
                    instance.daemon().unwrap();
                }
            });
            for _ in 0..200 {
                drop(instance.lock_daemon().unwrap());
            }
            is_over.store(true, std::sync::atomic::Ordering::Relaxed);
        });
        drop(arm);
        assert!(!instance.has_left_anything());
    }

    #[test]
    fn asking_for_the_daemon_takes_and_leaves_nothing() {
        let instance = Instance::fresh();
        assert_eq!(instance.daemon().unwrap(), None);
        assert!(!instance.dir().exists());
        let arm = instance.lock_controller("left_arm").unwrap();
        assert_eq!(instance.daemon().unwrap(), None);
        let daemon = instance.lock_daemon().unwrap();
        assert_eq!(instance.daemon().unwrap().map(|present| present.pid), Some(std::process::id()));
        assert!(instance.lock_daemon().is_err(), "it has its place still");
        drop(daemon);
        assert_eq!(instance.daemon().unwrap(), None);
        // As a process leaves it that was killed: the file is there and nobody has it.
        File::create(instance.dir().join(DAEMON_FILE)).unwrap();
        assert_eq!(instance.daemon().unwrap(), None);
        drop(instance.lock_daemon().unwrap());
        drop(arm);
        assert!(!instance.has_left_anything());
    }
}
