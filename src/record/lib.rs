//! Records of a run as bytes, line by line, and back. No decisions.

mod error;
mod reader;
#[cfg(any(test, feature = "samples"))]
pub mod samples;
pub mod words;
mod writer;

pub use error::JournalError;
pub use reader::{MAX_LINE_BYTES, Reader, parse, parse_header, read_line};
pub use writer::Journal;
