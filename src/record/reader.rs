//! Records in: line by line, in memory bounded by the longest line. A journal of another version is refused.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::Error;

use ambidex_model::{Header, JOURNAL_VERSION, NodeEntry, NodeId, Record, Runs, Time, make_legible};

use super::error::{JournalError, MAX_LINE_BYTES};

/// 285 years: a later time is none that this program has written.
const LATEST: Time = Time(1 << 53);

/// The records of a journal in order, the header first.
#[derive(Debug)]
pub struct Reader<R> {
    input: R,
    path: PathBuf,
    line: Vec<u8>,
    number: u64,
    header: Box<Header>,
    header_is_due: bool,
    is_truncated: bool,
    is_over: bool,
    whole_bytes: u64,
}

impl Reader<BufReader<File>> {
    /// Opens a journal and reads its header.
    ///
    /// # Errors
    /// When the file cannot be read, is no journal, or has another version.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, JournalError> {
        let path = path.as_ref();
        let file = File::open(path).map_err(|source| JournalError::Open { path: path.to_owned(), source })?;
        Self::new(BufReader::new(file), path)
    }
}

impl<R: BufRead> Reader<R> {
    /// Reads the header from any input; `path` is what errors call it.
    ///
    /// # Errors
    /// When the input cannot be read, is no journal, or has another version.
    pub fn new(mut input: R, path: impl Into<PathBuf>) -> Result<Self, JournalError> {
        let path = path.into();
        let mut line = Vec::new();
        let whole_bytes = read_line(&mut input, &mut line, &path, 1)? as u64;
        Ok(Self {
            header: parse_header(&line, &path)?,
            input,
            path,
            line,
            number: 1,
            header_is_due: true,
            is_truncated: false,
            is_over: false,
            whole_bytes,
        })
    }

    /// What the ids of the journal stand for.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Whether the last line was cut off, as when the writer was killed; known once the iteration is over.
    pub fn is_truncated(&self) -> bool {
        self.is_truncated
    }

    /// How many bytes the records take that were read; one that lacks only the end of its line is one of them.
    pub fn whole_bytes(&self) -> u64 {
        self.whole_bytes
    }

    fn read(&mut self) -> Result<Option<Record>, JournalError> {
        self.number += 1;
        self.line.clear();
        read_line(&mut self.input, &mut self.line, &self.path, self.number)?;
        if self.line.is_empty() {
            return Ok(None);
        }
        match parse(&self.line, &self.path, self.number) {
            Err(JournalError::Line { .. }) if !self.line.ends_with(b"\n") => {
                self.is_truncated = true;
                Ok(None)
            }
            parsed => {
                self.whole_bytes += self.line.len() as u64;
                parsed.map(Some)
            }
        }
    }
}

impl<R: BufRead> Iterator for Reader<R> {
    type Item = Result<Record, JournalError>;

    fn next(&mut self) -> Option<Self::Item> {
        if std::mem::take(&mut self.header_is_due) {
            return Some(Ok(Record::Header(self.header.clone())));
        }
        if self.is_over {
            return None;
        }
        let next = self.read().transpose();
        self.is_over = !matches!(next, Some(Ok(_)));
        next
    }
}

/// Adds to `line` what is there of the line up to its end; the bytes that were added.
pub fn read_line(
    input: &mut impl BufRead,
    line: &mut Vec<u8>,
    path: &Path,
    number: u64,
) -> Result<usize, JournalError> {
    let room = MAX_LINE_BYTES.saturating_sub(line.len() as u64);
    let length = input.take(room).read_until(b'\n', line).map_err(|source| JournalError::Read {
        path: path.to_owned(),
        line: number,
        source,
    })?;
    if line.len() as u64 >= MAX_LINE_BYTES && !line.ends_with(b"\n") {
        return Err(JournalError::TooLong { path: path.to_owned(), line: number });
    }
    Ok(length)
}

/// A line behind the header as a record.
///
/// # Errors
/// When it is none, or a second header.
pub fn parse(line: &[u8], path: &Path, number: u64) -> Result<Record, JournalError> {
    match serde_json::from_slice(line) {
        Ok(Record::Header(_)) => Err(JournalError::SecondHeader { path: path.to_owned(), line: number }),
        Ok(record) if record.at() > LATEST => {
            let source = Error::custom("its time is later than any run lasts");
            Err(JournalError::Line { path: path.to_owned(), line: number, source })
        }
        Ok(record) => Ok(record),
        Err(source) => Err(JournalError::Line { path: path.to_owned(), line: number, source: legible(source) }),
    }
}

/// An error that quotes the journal, without what a terminal would obey.
fn legible(error: serde_json::Error) -> serde_json::Error {
    let mut said = error.to_string();
    make_legible(&mut said);
    serde_json::Error::custom(said)
}

/// The first line of a journal as a header of this version whose nodes are a tree.
///
/// # Errors
/// When it is none.
pub fn parse_header(line: &[u8], path: &Path) -> Result<Box<Header>, JournalError> {
    /// What every version of a header has.
    #[derive(Deserialize)]
    struct Opening {
        record: String,
        version: u64,
    }
    let path = || path.to_owned();
    let opening: Option<Opening> = serde_json::from_slice(line).ok();
    let Some(Opening { version, .. }) = opening.filter(|opening| opening.record == "header") else {
        return Err(JournalError::NoHeader { path: path() });
    };
    if version != u64::from(JOURNAL_VERSION) {
        return Err(JournalError::Version { path: path(), found: version, known: JOURNAL_VERSION });
    }
    let header: Result<Header, _> = serde_json::from_slice(line);
    let header = header.map_err(|source| JournalError::Line { path: path(), line: 1, source: legible(source) })?;
    if !is_tree(&header.nodes) {
        let source = Error::custom("the nodes are no tree in preorder");
        return Err(JournalError::Line { path: path(), line: 1, source });
    }
    Ok(Box::new(header.legible()))
}

/// Whether the nodes are those of a tree in preorder under one root, which is its own parent.
fn is_tree(nodes: &Runs<NodeEntry>) -> bool {
    let mut line: Vec<NodeId> = Vec::new();
    for (node, entry) in nodes.iter().enumerate() {
        while line.last().is_some_and(|last| *last != entry.parent) {
            line.pop();
        }
        if line.is_empty() && (node > 0 || entry.parent.0 > 0) {
            return false;
        }
        line.push(NodeId::from(node));
    }
    !nodes.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Journal, samples};

    fn written(records: &[Record]) -> Vec<u8> {
        let mut journal = Journal::new(Vec::new());
        for record in records {
            journal.write(record).unwrap();
        }
        journal.into_inner()
    }

    fn reader(bytes: &[u8]) -> Result<Reader<&[u8]>, String> {
        Reader::new(bytes, "run.jsonl").map_err(|error| error.to_string())
    }

    /// Records read and how the iteration ended.
    fn read(bytes: &[u8]) -> (usize, Result<bool, String>) {
        let mut reader = reader(bytes).unwrap();
        let mut count = 0;
        let mut fault = None;
        for record in reader.by_ref() {
            match record {
                Ok(_) => count += 1,
                Err(error) => fault = Some(error.to_string()),
            }
        }
        (count, fault.map_or(Ok(reader.is_truncated()), Err))
    }

    #[test]
    fn every_variant_comes_back_as_written() {
        let records = samples::records();
        let bytes = written(&records);
        let back: Vec<_> = reader(&bytes).unwrap().map(Result::unwrap).collect();
        assert_eq!(back, records);
        assert_eq!(reader(&bytes).unwrap().header().mission, "tidy up");
    }

    #[test]
    fn a_file_reads_like_its_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.jsonl");
        std::fs::write(&path, written(&samples::records())).unwrap();
        let count = Reader::open(&path).unwrap().count();
        assert_eq!(count, samples::records().len());
        let error = Reader::open(folder.path().join("none")).unwrap_err();
        assert!(error.to_string().contains("none"), "{error}");
    }

    #[test]
    fn a_cut_off_last_line_ends_the_iteration() {
        let records = samples::records();
        let bytes = written(&records);
        assert_eq!(read(&bytes), (records.len(), Ok(false)));
        let without_end = &bytes[..bytes.len() - 1];
        assert_eq!(read(without_end), (records.len(), Ok(false)));
        for cut in [2, 5, 20] {
            let cut = &bytes[..bytes.len() - cut];
            assert_eq!(read(cut), (records.len() - 1, Ok(true)));
        }
    }

    #[test]
    fn a_bad_line_is_named() {
        let records = samples::records();
        let mut bytes = written(&records[..2]);
        bytes.extend_from_slice(b"{\"record\":\"sent\"}\n");
        bytes.extend(written(&records[2..3]));
        let said = "line 3 of the journal run.jsonl is not a record";
        assert_eq!(read(&bytes), (2, Err(said.into())));
        let twice = [written(&records[..1]), written(&records[..1])].concat();
        let said = "line 2 of the journal run.jsonl is a second header";
        assert_eq!(read(&twice), (1, Err(said.into())));
    }

    #[test]
    fn nothing_that_is_read_speaks_to_the_terminal() {
        let text = String::from_utf8(written(&samples::records()[..1])).unwrap();
        let text = text.replacen("tidy up", "\\u001b[2Jtidy\\u202e", 1);
        let reader = reader(text.as_bytes()).unwrap();
        assert_eq!(reader.header().mission, "\u{fffd}[2Jtidy\u{fffd}");
        let bad = text + "{\"record\":\"\\u001b[2J\"}\n";
        let error = Reader::new(bad.as_bytes(), "run.jsonl").unwrap().find_map(Result::err).unwrap();
        let source = std::error::Error::source(&error).unwrap().to_string();
        assert!(source.contains("`\u{fffd}[2J`") && !source.contains('\u{1b}'), "{source:?}");
    }

    #[test]
    fn what_does_not_begin_as_a_journal_is_refused() {
        let no_journal = "run.jsonl is no journal: its first line is not a header";
        let check = |bytes: &[u8], expected: &str| {
            assert_eq!(reader(bytes).err().as_deref(), Some(expected));
        };
        check(b"", no_journal);
        check(b"mission: x\n", no_journal);
        check(&written(&[samples::activation()]), no_journal);
        check(&written(&samples::records())[..30], no_journal);
        check(
            b"{\"record\":\"header\",\"version\":999,\"shape\":[]}\n",
            &format!("the journal run.jsonl has version 999; this program reads version {JOURNAL_VERSION}"),
        );
        let no_header = "line 1 of the journal run.jsonl is not a record";
        check(format!("{{\"record\":\"header\",\"version\":{JOURNAL_VERSION}}}\n").as_bytes(), no_header);
        let whole = reader(&written(&samples::records())).unwrap().header().clone();
        let parents = |parents: &[u32]| {
            let kind = || ambidex_model::EntryKind::And;
            let nodes = parents.iter().map(|parent| NodeEntry { parent: NodeId(*parent), kind: kind() }).collect();
            written(&[Record::Header(Box::new(Header { nodes, ..whole.clone() }))])
        };
        for odd in [&[][..], &[1, 0], &[0, 1], &[0, 0, 9], &[0, 0, 1, 0, 1]] {
            check(&parents(odd), no_header);
        }
        for sound in [&[0][..], &[0, 0, 1, 2, 1, 0]] {
            assert_eq!(reader(&parents(sound)).err(), None);
        }
    }
}
