//! What can go wrong with the file of a recording.

use std::io;
use std::path::PathBuf;

use ambidex::record::shown;
use mcap::McapError;

/// Why there is no recording, or no more of it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RecordingError {
    /// The file cannot be made.
    #[error("cannot create the recording {}", shown(path))]
    Create {
        /// Where it should be.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// Something else has its name.
    #[error("{} is there already and is no recording", shown(path))]
    #[diagnostic(help("give another name, or remove it: only a recording is written over"))]
    Other {
        /// What is there.
        path: PathBuf,
    },
    /// Another process writes it.
    #[error("another run writes {} at this moment", shown(path))]
    Busy {
        /// The recording's file.
        path: PathBuf,
    },
    /// A message cannot be written.
    #[error("cannot write to the recording {}", shown(path))]
    Write {
        /// The recording's file.
        path: PathBuf,
        /// What the operating system said, or what is wrong with the format.
        source: io::Error,
    },
    /// Its last messages are not written.
    #[error("the recording {} has no end: its disk takes nothing", shown(path))]
    Stuck {
        /// The recording's file.
        path: PathBuf,
    },
}

impl RecordingError {
    /// What the format's writer said of a file.
    pub fn of_writer(path: PathBuf, error: McapError) -> Self {
        let source = if let McapError::Io(source) = error { source } else { io::Error::other(error) };
        Self::Write { path, source }
    }

    /// As what went wrong with the bytes, for whoever wants to know whether somebody still reads them.
    pub fn into_io(self) -> io::Error {
        match self {
            Self::Create { source, .. } | Self::Write { source, .. } => source,
            other @ (Self::Other { .. } | Self::Busy { .. } | Self::Stuck { .. }) => io::Error::other(other),
        }
    }
}
