//! The journal in a file.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use ambidex_model::Record;
use ambidex_record::{Journal, JournalError};

/// A journal in a file, buffered.
#[derive(Debug)]
pub struct JournalFile {
    path: PathBuf,
    journal: Journal<BufWriter<File>>,
}

impl JournalFile {
    /// Creates the file with every folder above it; a file that is there already is replaced.
    ///
    /// # Errors
    /// When folder or file cannot be made.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, JournalError> {
        let path = path.into();
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|source| JournalError::Folder { path: folder.to_owned(), source })?;
        }
        // Whoever still reads the journal of an earlier run reads that one to its end, and notices the new one.
        if fs::symlink_metadata(&path).is_ok_and(|there| there.is_file()) {
            drop(fs::remove_file(&path));
        }
        let file = File::options()
            .write(true)
            .create(true)
            .truncate(true)
            .mode(0o600)
            .open(&path)
            .map_err(|source| JournalError::Create { path: path.clone(), source })?;
        Ok(Self { path, journal: Journal::new(BufWriter::new(file)) })
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

#[cfg(test)]
mod tests {
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
}
