//! Whoever asks: one request, one answer. It blocks, for a bounded time.

use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use super::protocol::{Answer, LINE_MAX, Request, read_answer, request_line};
use ambidex_link::Instance;

/// How long an answer is awaited.
const ANSWER_WITHIN: Duration = Duration::from_secs(10);

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// Nobody serves the socket.
    #[error("no daemon of instance `{0}` runs")]
    NoDaemon(String),
    /// The socket cannot be spoken to.
    #[error("cannot ask the daemon of instance `{instance}`")]
    Socket {
        /// The instance that was to be asked.
        instance: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// It ended.
    #[error("the daemon of instance `{0}` ended before it answered")]
    Ended(String),
    /// It has not answered in time; what was asked for may still be done.
    #[error("the daemon of instance `{instance}` has not answered within {} s, and may still do what was asked", within.as_secs())]
    Late {
        /// The instance that was asked.
        instance: String,
        /// How long it was awaited.
        within: Duration,
    },
    /// The answer cannot be read; most often the daemon has another version.
    #[error("the answer of the daemon of instance `{instance}` cannot be read")]
    Answer {
        /// The instance that answered.
        instance: String,
        /// What is wrong with it.
        source: serde_json::Error,
    },
}

/// Asks the daemon of an instance, and waits for its answer.
///
/// # Errors
/// [`AskError`] when there is no daemon, or no answer.
pub fn ask(instance: &Instance, request: &Request) -> Result<Answer, AskError> {
    let name = || instance.name().to_owned();
    let mut line = Vec::new();
    let told = speak(instance, request, &mut line).map_err(|source| match source.kind() {
        ErrorKind::NotFound | ErrorKind::ConnectionRefused => AskError::NoDaemon(name()),
        ErrorKind::WouldBlock | ErrorKind::TimedOut => AskError::Late { instance: name(), within: ANSWER_WITHIN },
        ErrorKind::BrokenPipe | ErrorKind::ConnectionReset => AskError::Ended(name()),
        _ => AskError::Socket { instance: name(), source },
    });
    told?;
    if line.is_empty() {
        return Err(AskError::Ended(name()));
    }
    read_answer(&line).map_err(|source| AskError::Answer { instance: name(), source })
}

fn speak(instance: &Instance, request: &Request, answer: &mut Vec<u8>) -> io::Result<()> {
    let mut stream = UnixStream::connect(instance.control_socket())?;
    stream.set_read_timeout(Some(ANSWER_WITHIN))?;
    stream.set_write_timeout(Some(ANSWER_WITHIN))?;
    stream.write_all(request_line(request).as_bytes())?;
    BufReader::new(stream.take(LINE_MAX as u64)).read_until(b'\n', answer)?;
    Ok(())
}
