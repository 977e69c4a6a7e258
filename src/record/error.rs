//! What can go wrong with a journal.

use std::io;
use std::path::{Path, PathBuf};

use ambidex_model::make_legible;

/// Longest line that is read, bytes: a round of a hundred thousand leaves, each with its reason, is shorter.
pub const MAX_LINE_BYTES: u64 = 64 << 20;

/// A path as people may see it: nothing in it speaks to the terminal.
pub fn shown(path: &Path) -> String {
    let mut path = path.display().to_string();
    make_legible(&mut path);
    path
}

/// What can go wrong with a journal's file.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The folder of a new journal cannot be made.
    #[error("cannot create the folder {}", shown(path))]
    Folder {
        /// Where it should be.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A new journal cannot be made.
    #[error("cannot create the journal {}", shown(path))]
    Create {
        /// The journal's file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// What lies where the journal should is no file.
    #[error("{} is no file: a journal needs one of its own", path.display())]
    NoFile {
        /// What lies there: a folder, a pipe, a device.
        path: PathBuf,
    },
    /// Another process writes the journal.
    #[error("another run writes {} at this moment", path.display())]
    Busy {
        /// The journal's file.
        path: PathBuf,
    },
    /// A record cannot be written.
    #[error("cannot write to the journal {}", shown(path))]
    Write {
        /// The journal's file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A journal cannot be opened.
    #[error("cannot open the journal {}", shown(path))]
    Open {
        /// The journal's file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A journal cannot be read on.
    #[error("cannot read the journal {} at line {line}", shown(path))]
    Read {
        /// The journal's file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What the operating system said.
        source: io::Error,
    },
    /// The first line is no header.
    #[error("{} is no journal: its first line is not a header", shown(path))]
    NoHeader {
        /// What was to be read.
        path: PathBuf,
    },
    /// The journal has another form.
    #[error("the journal {} has version {found}; this program reads version {known}", shown(path))]
    Version {
        /// The journal's file.
        path: PathBuf,
        /// The journal's version.
        found: u64,
        /// The version that can be read.
        known: u32,
    },
    /// A line is no record.
    #[error("line {line} of the journal {} is not a record", shown(path))]
    Line {
        /// The journal's file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong with it, without what a terminal would obey.
        source: serde_json::Error,
    },
    /// A header stands where none may.
    #[error("line {line} of the journal {} is a second header", shown(path))]
    SecondHeader {
        /// The journal's file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
    },
    /// A line is longer than any record.
    #[error("line {line} of the journal {} is longer than {MAX_LINE_BYTES} bytes", shown(path))]
    TooLong {
        /// The journal's file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
    },
}
