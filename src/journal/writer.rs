//! Records out: one JSON line each, in the order in which they are given. Nothing is added to them.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::model::Record;

use super::JournalError;

/// A journal on anything that takes bytes.
#[derive(Debug)]
pub struct Journal<W: Write> {
    out: W,
    line: Vec<u8>,
    lines: u64,
}

impl<W: Write> Journal<W> {
    /// An empty journal.
    pub fn new(out: W) -> Self {
        Self { out, line: Vec::new(), lines: 0 }
    }

    /// Writes one record as one line.
    ///
    /// # Errors
    /// When the bytes are not taken; the journal then ends within a line.
    pub fn write(&mut self, record: &Record) -> io::Result<()> {
        self.line.clear();
        serde_json::to_writer(&mut self.line, record)?;
        self.line.push(b'\n');
        self.out.write_all(&self.line)?;
        self.lines += 1;
        Ok(())
    }

    /// Hands on all that is buffered.
    ///
    /// # Errors
    /// When the bytes are not taken.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    /// Lines written so far.
    pub fn lines(&self) -> u64 {
        self.lines
    }

    /// What was written to.
    pub fn into_inner(self) -> W {
        self.out
    }
}

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
        let file = File::create(&path).map_err(|source| JournalError::Create { path: path.clone(), source })?;
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
    use crate::journal::samples;

    #[test]
    fn every_record_is_one_line() {
        let mut journal = Journal::new(Vec::new());
        let records = samples::records();
        for record in &records {
            journal.write(record).unwrap();
        }
        assert_eq!(journal.lines(), records.len() as u64);
        let text = String::from_utf8(journal.into_inner()).unwrap();
        assert_eq!(text.lines().count(), records.len());
        assert!(text.ends_with('\n'));
    }

    #[test]
    fn a_line_reads_as_said() {
        let mut journal = Journal::new(Vec::new());
        journal.write(&samples::activation()).unwrap();
        assert_eq!(
            String::from_utf8(journal.into_inner()).unwrap(),
            "{\"record\":\"sent\",\"at\":1500000,\"round\":3,\"from\":0,\"to\":1,\
             \"message\":{\"kind\":\"activation\"}}\n"
        );
    }

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
