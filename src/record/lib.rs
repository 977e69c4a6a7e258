//! Records of a run as bytes, line by line, and back; and what they come to. No decisions.

pub mod audit;
mod error;
pub mod format;
mod history;
mod known;
mod reader;
#[cfg(any(test, feature = "samples"))]
pub mod samples;
mod writer;

pub use error::{JournalError, MAX_LINE_BYTES, shown};
pub use history::{
    ActiveCommand, ControllerView, Controllers, Counts, EndedTask, Failures, Held, History, Interruption, Lane,
    LastError, LeafHistory, LeafState, MissionOutcome, MissionReport, OutsideChange, Phase, Presence, Step,
};
pub use known::Beginning;
pub use reader::{Reader, parse, parse_header, read_line};
pub use writer::Journal;
