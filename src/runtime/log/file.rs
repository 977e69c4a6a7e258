//! The journal in a file.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use ambidex_model::{Disk, Record};
use ambidex_record::{Journal, JournalError};

use super::disk::DiskFile;
use super::keep::{make_room_for_old, put_behind};

/// How long somebody may hold a log that only looks whether it is being written.
const LOCK_WAIT: Duration = Duration::from_millis(200);
const LOCK_POLL: Duration = Duration::from_millis(5);

/// A journal in a file, buffered.
#[derive(Debug)]
pub struct JournalFile {
    path: PathBuf,
    journal: Journal<BufWriter<DiskFile>>,
    /// What stood in it when it was opened.
    before: u64,
}

impl JournalFile {
    /// Creates the file with every folder above it; one that is there already is replaced, unless somebody writes it.
    /// It stays locked as long as it is written.
    ///
    /// # Errors
    /// When folder or file cannot be made, when what is there is no file, when another process writes it.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, JournalError> {
        let path = path.into();
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|source| JournalError::Folder { path: folder.to_owned(), source })?;
        }
        match patiently(|| fresh(&path)) {
            Ok(Some(file)) => Ok(Self::on(file, path)),
            Ok(None) => Err(JournalError::Busy { path }),
            Err(Refused::NoFile) => Err(JournalError::NoFile { path }),
            Err(Refused::Io(source)) => Err(JournalError::Create { path, source }),
        }
    }

    /// Opens a log that is there, to go on in it behind its end.
    ///
    /// # Errors
    /// When there is none, or another process writes it.
    pub fn reopen(path: &Path) -> Result<Self, JournalError> {
        let path = path.to_owned();
        let opened = File::options().read(true).append(true).open(&path);
        let file = opened.map_err(|source| JournalError::Open { path: path.clone(), source })?;
        match patiently(|| locked(&file)) {
            Ok(Some(())) => {
                let before = file.metadata().map_or(0, |about| about.len());
                Ok(Self { before, ..Self::on(file, path) })
            }
            Ok(None) => Err(JournalError::Busy { path }),
            Err(source) => Err(JournalError::Open { path, source }),
        }
    }

    fn on(file: File, path: PathBuf) -> Self {
        Self { path, journal: Journal::new(BufWriter::new(file.into())), before: 0 }
    }

    /// Begins anew with these records in the place of this file, which gets the name of an old one; of these no more than
    /// `keep` stay. At no moment is there no whole log under the path.
    ///
    /// # Errors
    /// When the new file cannot be made or written; then this one goes on.
    pub fn begin_anew(&mut self, records: &[Record], keep: usize) -> Result<(), JournalError> {
        self.flush()?;
        let new = self.path.with_extension("new");
        let begin = || {
            let file = File::options().write(true).create(true).truncate(true).mode(0o600).open(&new)?;
            file.lock()?;
            let mut begun = Self::on(file, self.path.clone());
            begun.set_disk(self.journal.get_ref().get_ref().disk);
            for record in records {
                begun.journal.write(record)?;
            }
            begun.journal.flush()?;
            begun.journal.get_ref().get_ref().file.sync_data()?;
            put_behind(&self.path)?;
            fs::rename(&new, &self.path)?;
            Ok(begun)
        };
        match begin() {
            Ok(begun) => {
                *self = begun;
                make_room_for_old(&self.path, keep);
                Ok(())
            }
            Err(source) => {
                let _ = fs::remove_file(&new);
                Err(Self::failed(&self.path, source))
            }
        }
    }

    /// How long it is, bytes, with what is buffered.
    pub fn bytes(&self) -> u64 {
        self.before + self.journal.bytes()
    }

    /// On purpose: what its disk does from now on.
    pub fn set_disk(&mut self, disk: Disk) {
        self.journal.get_mut().get_mut().disk = disk;
    }

    /// Removes what stands behind the last whole record, which ends at `whole` bytes; how many bytes that were. If only
    /// the end of its line was lacking, it gets one.
    ///
    /// # Errors
    /// When the file cannot be changed.
    pub fn cut(&mut self, whole: u64) -> Result<u64, JournalError> {
        let cut = || {
            let file = &self.journal.get_ref().get_ref().file;
            let length = file.metadata()?.len();
            file.set_len(whole.min(length))?;
            let mut last = [b'\n'];
            file.read_exact_at(&mut last, whole.saturating_sub(1))?;
            if last != [b'\n'] {
                (&mut { file }).write_all(b"\n")?;
            }
            Ok(length.saturating_sub(whole))
        };
        cut().map_err(|source| Self::failed(&self.path, source))
    }

    /// Writes one record as one line.
    ///
    /// # Errors
    /// When the file does not take it, as on a full disk.
    pub fn write(&mut self, record: &Record) -> Result<(), JournalError> {
        self.journal.write(record).map_err(|source| Self::failed(&self.path, source))
    }

    /// Hands all that is buffered to the operating system.
    ///
    /// # Errors
    /// When the file does not take it, as on a full disk.
    pub fn flush(&mut self) -> Result<(), JournalError> {
        self.journal.flush().map_err(|source| Self::failed(&self.path, source))
    }

    /// Lines written so far.
    pub fn lines(&self) -> u64 {
        self.journal.lines()
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn failed(path: &Path, source: io::Error) -> JournalError {
        JournalError::Write { path: path.to_owned(), source }
    }
}

enum Refused {
    NoFile,
    Io(io::Error),
}

impl From<io::Error> for Refused {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Tries until it is there, as long as somebody may be expected to hold a log that only looks; none if it still is not.
fn patiently<T, E>(mut attempt: impl FnMut() -> Result<Option<T>, E>) -> Result<Option<T>, E> {
    let by = Instant::now() + LOCK_WAIT;
    loop {
        match attempt()? {
            None if Instant::now() < by => thread::sleep(LOCK_POLL),
            done => return Ok(done),
        }
    }
}

/// Locks a file; none while somebody has it.
fn locked(file: &File) -> io::Result<Option<()>> {
    match file.try_lock() {
        Ok(()) => Ok(Some(())),
        Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// A new, locked file at the path; none while somebody has the one that is there.
fn fresh(path: &Path) -> Result<Option<File>, Refused> {
    match fs::metadata(path) {
        Ok(there) if !there.is_file() => return Err(Refused::NoFile),
        Ok(_) => {
            let old = File::open(path)?;
            if locked(&old)?.is_none() {
                return Ok(None);
            }
            // Whoever still reads it reads it to its end, and notices the new one.
            fs::remove_file(path)?;
        }
        // A link that leads nowhere.
        Err(error) if error.kind() == ErrorKind::NotFound && fs::symlink_metadata(path).is_ok() => {
            return Err(Refused::NoFile);
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error.into()),
    }
    let file = match File::options().write(true).create_new(true).mode(0o600).open(path) {
        Ok(file) => file,
        // Somebody was faster.
        Err(error) if error.kind() == ErrorKind::AlreadyExists => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    Ok(locked(&file)?.map(|()| file))
}

#[cfg(test)]
mod tests {
    use super::super::held::is_being_written;
    use super::*;
    use ambidex_record::samples;

    #[test]
    fn folders_are_made_and_an_error_names_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/run.jsonl");
        let mut file = JournalFile::create(&path).unwrap();
        file.write(&samples::activation()).unwrap();
        file.flush().unwrap();
        assert_eq!((file.lines(), file.path()), (1, path.as_path()));
        let below_a_file = path.join("no.jsonl");
        let error = JournalFile::create(&below_a_file).unwrap_err().to_string();
        assert!(error.contains("a/b/run.jsonl"), "{error}");
        let error = JournalFile::create(folder.path()).unwrap_err().to_string();
        assert!(error.contains(folder.path().to_str().unwrap()), "{error}");
    }

    #[test]
    fn a_log_has_one_writer() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.jsonl");
        let first = JournalFile::create(&path).unwrap();
        assert!(is_being_written(&path).unwrap());
        let refused = JournalFile::create(&path).unwrap_err();
        assert!(matches!(refused, JournalError::Busy { .. }), "{refused}");
        drop(first);
        assert!(!is_being_written(&path).unwrap());
        let again = JournalFile::create(&path).unwrap();
        assert!(is_being_written(&path).unwrap());
        drop(again);
    }

    #[test]
    fn only_a_file_is_a_log() {
        let refused = JournalFile::create("/dev/null").unwrap_err();
        assert!(matches!(refused, JournalError::NoFile { .. }), "{refused}");
    }
}
