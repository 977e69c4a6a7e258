//! One request and its answer.

use std::io::{self, ErrorKind};
use std::time::Duration;

use axum::http::header::{AUTHORIZATION, CONTENT_TYPE, HOST};
use axum::http::{self, StatusCode};
use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::client::conn::http1;
use hyper_util::rt::TokioIo;
use serde::de::DeserializeOwned;
use tokio::net::UnixStream;
use tokio::time::timeout;

use super::request::{Call, Request, answer_of};
use crate::limits::ANSWER_WITHIN;
use crate::token::Token;
use ambidex_link::Instance;
use ambidex_runtime::control::{About, Answer, Refusal};

/// How long an answer is awaited: longer than the daemon waits for its run.
const WITHIN: Duration = Duration::from_secs(ANSWER_WITHIN.as_secs() + 5);
/// Longest answer that is read, bytes: the status of a tree of a hundred thousand nodes.
const ANSWER_MAX: usize = 64 * 1024 * 1024;

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
    block_on(instance, ask_later(instance, request))
}

/// The same within a runtime of tokio.
///
/// # Errors
/// As [`ask`].
pub async fn ask_later(instance: &Instance, request: &Request) -> Result<Answer, AskError> {
    let (status, body) = whole(instance, Call::of(request)).await?;
    let name = || instance.name().to_owned();
    answer_of(status, &body).map_err(|source| AskError::Answer { instance: name(), source })
}

/// What the daemon of an instance is, and how well its controllers are; within that time, since who asks has something else
/// to tell too.
///
/// # Errors
/// [`AskError`] when there is no daemon, or no answer.
pub fn about(instance: &Instance, within: Duration) -> Result<About, AskError> {
    let asking = async {
        let late = || AskError::Late { instance: instance.name().to_owned(), within };
        timeout(within, whole(instance, Call::read("/v1/about".into()))).await.unwrap_or_else(|_| Err(late()))
    };
    let (_, body) = block_on(instance, asking)?;
    serde_json::from_slice(&body).map_err(|source| AskError::Answer { instance: instance.name().to_owned(), source })
}

/// Reads what the daemon of an instance has at a path below `/v1/`, of which the last part may be any name.
///
/// # Errors
/// [`AskError`] when there is no daemon, or no answer.
pub fn read<T: DeserializeOwned>(
    instance: &Instance,
    path: &str,
    name: Option<&str>,
) -> Result<Result<T, Refusal>, AskError> {
    let name = name.map_or(String::new(), |name| format!("/{}", super::request::encoded(name)));
    let call = Call::read(format!("/v1/{path}{name}"));
    let (status, body) = block_on(instance, whole(instance, call))?;
    let read = match status.is_success() {
        true => serde_json::from_slice(&body).map(Ok),
        false => serde_json::from_slice(&body).map(|problem: crate::Problem| Err(problem.into_refusal())),
    };
    read.map_err(|source| AskError::Answer { instance: instance.name().to_owned(), source })
}

fn block_on<T>(instance: &Instance, asking: impl Future<Output = Result<T, AskError>>) -> Result<T, AskError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(|source| AskError::Socket { instance: instance.name().to_owned(), source })?;
    runtime.block_on(asking)
}

/// The answer to a call with all of its body.
async fn whole(instance: &Instance, call: Call) -> Result<(StatusCode, Bytes), AskError> {
    let asking = async {
        let answer = send(instance, call).await?;
        let (status, body) = (answer.status(), answer.into_body());
        let body = Limited::new(body, ANSWER_MAX).collect().await.map_err(|_| ended(instance))?;
        Ok((status, body.to_bytes()))
    };
    let late = || AskError::Late { instance: instance.name().to_owned(), within: WITHIN };
    timeout(WITHIN, asking).await.unwrap_or_else(|_| Err(late()))
}

/// The answer to a call as far as its head.
pub(super) async fn send(instance: &Instance, call: Call) -> Result<http::Response<Incoming>, AskError> {
    let failed = |source: io::Error| match source.kind() {
        // One that ends while it is connected to resets.
        ErrorKind::NotFound | ErrorKind::ConnectionRefused | ErrorKind::ConnectionReset => {
            AskError::NoDaemon(instance.name().to_owned())
        }
        _ => AskError::Socket { instance: instance.name().to_owned(), source },
    };
    let stream = UnixStream::connect(instance.control_socket()).await.map_err(failed)?;
    let token = Token::read(&instance.token_file()).map_err(failed)?;
    let handshake = http1::handshake(TokioIo::new(stream)).await;
    let (mut sender, connection) = handshake.map_err(|_| ended(instance))?;
    // It ends with the answer.
    tokio::spawn(connection);
    let mut request = http::Request::builder().method(call.method).uri(call.path).header(HOST, "localhost");
    request = request.header(AUTHORIZATION, token.header());
    if call.body.is_some() {
        request = request.header(CONTENT_TYPE, "application/json");
    }
    let body = Full::new(Bytes::from(call.body.unwrap_or_default()));
    let request = request.body(body).expect("paths are encoded, and headers plain");
    sender.send_request(request).await.map_err(|_| ended(instance))
}

pub(super) fn ended(instance: &Instance) -> AskError {
    AskError::Ended(instance.name().to_owned())
}
