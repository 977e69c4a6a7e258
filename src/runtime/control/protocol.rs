//! The lines of the socket as they are written and read.

use serde::{Deserialize, Serialize};

/// Version of all that is said over the socket; a side that has another is told so.
pub const PROTOCOL_VERSION: u32 = 1;

/// Longest line of either side, bytes, its end included.
pub(super) const LINE_MAX: usize = 4096;

/// What is asked of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Request {
    /// The world is to be different.
    World(WorldChange),
}

/// How the world is to be different, by names of the mission.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WorldChange {
    /// The fact holds.
    Set(String),
    /// The fact does not hold.
    Clear(String),
    /// The object lies at the place.
    Move {
        /// The object.
        object: String,
        /// The place.
        to: String,
    },
}

/// What came of a request.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// It was done.
    Changed {
        /// What is so now, as a sentence without its end.
        said: String,
    },
    /// It was so already.
    Same {
        /// What was so already, as a sentence without its end.
        said: String,
    },
    /// Nothing changed.
    Refused {
        /// Why not, for programs.
        why: Why,
        /// Why not, as a sentence without its end.
        said: String,
        /// What can be done about it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        help: Option<String>,
    },
}

/// Why a request was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// It is no request, or too long.
    Malformed,
    /// It is of another version.
    Version,
    /// Too many ask at once.
    Busy,
    /// The mission has no such fact, object or place.
    NoSuchName,
    /// The mission does not say that others may set and clear the fact.
    NotOutside,
    /// The object is in a gripper.
    Held,
    /// Only a controller says such a thing.
    NotTheirs,
    /// The mission has not begun.
    NotBegun,
    /// The mission is over.
    Over,
}

/// A request with the version of whoever asks.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    version: u32,
    request: Request,
}

/// An answer with the version of whoever answers.
#[derive(Debug, Serialize, Deserialize)]
struct Answered {
    version: u32,
    answer: Answer,
}

/// What every version has.
#[derive(Debug, Deserialize)]
struct Versioned {
    version: u32,
}

/// The line of a request.
pub(super) fn request_line(request: &Request) -> String {
    line(&Asked { version: PROTOCOL_VERSION, request: request.clone() })
}

/// The line of an answer.
pub(super) fn answer_line(answer: &Answer) -> String {
    line(&Answered { version: PROTOCOL_VERSION, answer: answer.clone() })
}

/// The request of a line, or the answer to what is none.
pub(super) fn read_request(line: &[u8]) -> Result<Request, Answer> {
    let refused = |why, said| Answer::Refused { why, said, help: None };
    let malformed = |error: serde_json::Error| refused(Why::Malformed, format!("that is no request: {error}"));
    let Versioned { version } = serde_json::from_slice(line).map_err(malformed)?;
    if version != PROTOCOL_VERSION {
        let said = format!("this daemon speaks version {PROTOCOL_VERSION} of the control socket, not {version}");
        return Err(refused(Why::Version, said));
    }
    serde_json::from_slice::<Asked>(line).map(|asked| asked.request).map_err(malformed)
}

/// The answer of a line.
///
/// # Errors
/// When it is none.
pub fn read_answer(line: &[u8]) -> serde_json::Result<Answer> {
    serde_json::from_slice::<Answered>(line).map(|answered| answered.answer)
}

fn line(said: &impl Serialize) -> String {
    let mut line = serde_json::to_string(said).expect("it is plain");
    line.push('\n');
    line
}
