//! Records out of a journal that is still being written: whoever follows looks again when nothing new was there.

use std::fs::{self, File};
use std::io::{self, BufReader, Seek, SeekFrom};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use ambidex_model::{Header, Record};

use ambidex_record::{JournalError, parse, parse_header, read_line};

/// What a look at a live journal brings.
#[derive(Debug, Clone, PartialEq)]
pub enum News {
    /// The next record; the header is the first.
    Record(Box<Record>),
    /// All that is there was read: look again later.
    Quiet,
    /// The file was emptied, or another took its place: a new run, to be opened anew.
    Replaced,
}

/// A live journal. It never waits: each look says what is there now.
#[derive(Debug)]
pub struct Follower {
    input: BufReader<File>,
    path: PathBuf,
    line: Vec<u8>,
    number: u64,
    position: u64,
    /// What was read last was the half of a line.
    was_within_a_line: bool,
    header: Option<Box<Header>>,
}

/// What has become of the file.
enum Fate {
    Same,
    Cut,
    Replaced,
}

impl Follower {
    /// Opens a journal, which may be empty yet.
    ///
    /// # Errors
    /// When there is no such file, or it cannot be read.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self, JournalError> {
        let path = path.into();
        let file = File::open(&path).map_err(|source| JournalError::Open { path: path.clone(), source })?;
        let input = BufReader::new(file);
        Ok(Self { input, path, line: Vec::new(), number: 1, position: 0, was_within_a_line: false, header: None })
    }

    /// What the ids of the journal stand for, once it was read.
    pub fn header(&self) -> Option<&Header> {
        self.header.as_deref()
    }

    /// Where the journal lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the last line is half-written as yet.
    pub fn is_within_a_line(&self) -> bool {
        !self.line.is_empty()
    }

    /// The next record if a whole line is there.
    ///
    /// # Errors
    /// When the file cannot be read on, is no journal, or has another version. What follows is undefined then.
    pub fn look(&mut self) -> Result<News, JournalError> {
        let length = read_line(&mut self.input, &mut self.line, &self.path, self.number)?;
        self.position += length as u64;
        if !self.line.ends_with(b"\n") {
            self.was_within_a_line = !self.line.is_empty();
            return match self.fate().map_err(|source| self.unreadable(source))? {
                Fate::Same => Ok(News::Quiet),
                Fate::Cut => self.back_to_the_line().map(|()| News::Quiet),
                Fate::Replaced => Ok(News::Replaced),
            };
        }
        let record = match &self.header {
            Some(_) => match parse(&self.line, &self.path, self.number) {
                // Whoever went on in the log has removed the half of a line that was read before.
                Err(JournalError::Line { .. }) if std::mem::take(&mut self.was_within_a_line) => {
                    self.back_to_the_line()?;
                    return self.look();
                }
                parsed => parsed?,
            },
            None => {
                let header = parse_header(&self.line, &self.path)?;
                Record::Header(self.header.insert(header).clone())
            }
        };
        self.line.clear();
        self.was_within_a_line = false;
        self.number += 1;
        Ok(News::Record(Box::new(record)))
    }

    /// Reads once more from the beginning of the line that is half-read.
    fn back_to_the_line(&mut self) -> Result<(), JournalError> {
        self.position -= self.line.len() as u64;
        self.line.clear();
        let sought = self.input.seek(SeekFrom::Start(self.position));
        sought.map(drop).map_err(|source| self.unreadable(source))
    }

    /// Whether only the half of a line is gone from the file; whether more is, or its path leads to another file.
    fn fate(&self) -> io::Result<Fate> {
        let ours = self.input.get_ref().metadata()?;
        let there = match fs::metadata(&self.path) {
            Ok(there) => there,
            // Between two runs there may be none.
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Fate::Same),
            Err(error) => return Err(error),
        };
        let is_other = (ours.dev(), ours.ino()) != (there.dev(), there.ino());
        let whole = self.position - self.line.len() as u64;
        Ok(match ours.len() {
            _ if is_other => Fate::Replaced,
            length if length < whole => Fate::Replaced,
            length if length < self.position => Fate::Cut,
            _ => Fate::Same,
        })
    }

    fn unreadable(&self, source: io::Error) -> JournalError {
        JournalError::Read { path: self.path.clone(), line: self.number, source }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use crate::log::JournalFile;
    use ambidex_record::{Journal, samples};

    fn bytes(records: &[Record]) -> Vec<u8> {
        let mut journal = Journal::new(Vec::new());
        for record in records {
            journal.write(record).unwrap();
        }
        journal.into_inner()
    }

    /// Everything that is there, and what came after the last record.
    fn read(follower: &mut Follower) -> (Vec<Record>, News) {
        let mut records = Vec::new();
        loop {
            match follower.look().unwrap() {
                News::Record(record) => records.push(*record),
                other => return (records, other),
            }
        }
    }

    #[test]
    fn a_journal_is_read_however_it_is_cut_while_it_grows() {
        let records = samples::records();
        let whole = bytes(&records);
        for piece in [1, 7, 100, 4096, whole.len()] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("run.jsonl");
            let mut file = File::create(&path).unwrap();
            let mut follower = Follower::open(&path).unwrap();
            assert_eq!(read(&mut follower), (Vec::new(), News::Quiet));
            let mut found = Vec::new();
            for piece in whole.chunks(piece) {
                file.write_all(piece).unwrap();
                let (new, then) = read(&mut follower);
                assert_eq!(then, News::Quiet);
                assert_eq!(follower.is_within_a_line(), !piece.ends_with(b"\n"));
                found.extend(new);
            }
            assert_eq!(found, records, "in pieces of {piece}");
            assert_eq!(follower.header().unwrap().mission, "tidy up");
        }
    }

    #[test]
    fn a_new_run_in_its_place_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.jsonl");
        let records = samples::records();
        let write = |records: &[Record]| {
            let mut journal = JournalFile::create(&path).unwrap();
            records.iter().for_each(|record| journal.write(record).unwrap());
            journal.flush().unwrap();
        };
        write(&records[..3]);
        let mut follower = Follower::open(&path).unwrap();
        assert_eq!(read(&mut follower), (records[..3].to_vec(), News::Quiet));
        // Longer than what was read of the other: only that it is another file tells.
        write(&records[..5]);
        assert_eq!(read(&mut follower), (Vec::new(), News::Replaced));
        let mut again = Follower::open(&path).unwrap();
        assert_eq!(read(&mut again), (records[..5].to_vec(), News::Quiet));
    }

    #[test]
    fn the_half_of_a_line_may_be_cut_off() {
        let records = samples::records();
        let (first, then) = (bytes(&records[..3]), bytes(&records[3..5]));
        for has_grown in [false, true] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("run.jsonl");
            fs::write(&path, [&first, &then[..9]].concat()).unwrap();
            let mut follower = Follower::open(&path).unwrap();
            assert_eq!(read(&mut follower), (records[..3].to_vec(), News::Quiet));
            let file = File::options().append(true).open(&path).unwrap();
            file.set_len(first.len() as u64).unwrap();
            if !has_grown {
                assert_eq!(read(&mut follower), (Vec::new(), News::Quiet));
            }
            (&file).write_all(&bytes(&records[4..6])).unwrap();
            assert_eq!(read(&mut follower), (records[4..6].to_vec(), News::Quiet), "{has_grown}");
        }
    }

    #[test]
    fn an_emptied_file_is_a_new_run_and_a_missing_one_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.jsonl");
        let records = samples::records();
        fs::write(&path, bytes(&records[..3])).unwrap();
        let mut follower = Follower::open(&path).unwrap();
        read(&mut follower);
        fs::write(&path, bytes(&records[..1])).unwrap();
        assert_eq!(follower.look().unwrap(), News::Replaced);
        let mut follower = Follower::open(&path).unwrap();
        fs::remove_file(&path).unwrap();
        assert_eq!(read(&mut follower), (records[..1].to_vec(), News::Quiet));
        assert!(Follower::open(&path).is_err());
    }

    #[test]
    fn what_is_no_journal_is_refused_as_soon_as_its_first_line_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.jsonl");
        let check = |text: &str, said: &str| {
            fs::write(&path, text).unwrap();
            let error = Follower::open(&path).unwrap().look().unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        };
        check("mission: x\n", "is no journal");
        check("{\"record\":\"header\",\"version\":999}\n", "has version 999");
        fs::write(&path, "{\"record\":\"head").unwrap();
        assert_eq!(Follower::open(&path).unwrap().look().unwrap(), News::Quiet);
    }
}
