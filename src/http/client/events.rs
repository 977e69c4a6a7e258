//! The stream of events of a daemon.

use std::pin::Pin;

use futures_util::StreamExt;
use http_body_util::BodyExt;
use hyper::body::Incoming;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use sse_stream::SseStream;

use super::call::{AskError, ended, send};
use super::request::Call;
use crate::bodies::Tasks;
use crate::hub::EventKind;
use crate::problem::Problem;
use ambidex_link::Instance;
use ambidex_runtime::control::Refusal;
use ambidex_show::tasks::TaskSummary;

/// What a daemon tells as it happens; to be read within a runtime of tokio.
pub struct Events {
    instance: Instance,
    stream: Pin<Box<SseStream<Incoming>>>,
}

/// What was heard of tasks.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// What all of them are at, first of all and behind what was not heard.
    All(Vec<TaskSummary>),
    /// A task that is not as before.
    Task(Box<TaskSummary>),
    /// So many records were not heard.
    Dropped(u64),
}

/// What stands in `dropped`.
#[derive(Debug, Deserialize)]
struct Dropped {
    records: u64,
}

impl Events {
    /// Begins to read what the daemon of an instance tells.
    ///
    /// # Errors
    /// [`AskError`] when there is no daemon; within it the refusal of one that tells too many others already.
    pub async fn open(instance: &Instance) -> Result<Result<Self, Refusal>, AskError> {
        let answer = send(instance, Call::read("/v1/events".into())).await?;
        if answer.status().is_success() {
            let stream = Box::pin(SseStream::new(answer.into_body()));
            return Ok(Ok(Self { instance: instance.clone(), stream }));
        }
        let body = answer.into_body().collect().await.map_err(|_| ended(instance))?;
        let problem: Problem = parsed(instance, &body.to_bytes())?;
        Ok(Err(problem.into_refusal()))
    }

    /// What is heard next; none once the daemon tells no more.
    ///
    /// # Errors
    /// When it cannot be read.
    pub async fn next(&mut self) -> Result<Option<Heard>, AskError> {
        // A stream that breaks is one of a daemon that is gone.
        while let Some(Ok(event)) = self.stream.next().await {
            let (Some(kind), Some(data)) = (event.event, event.data) else { continue };
            let heard = match EventKind::of(&kind) {
                Some(EventKind::Snapshot) => Heard::All(parsed::<Tasks>(&self.instance, data.as_bytes())?.tasks),
                Some(EventKind::Task) => Heard::Task(parsed(&self.instance, data.as_bytes())?),
                Some(EventKind::Dropped) => Heard::Dropped(parsed::<Dropped>(&self.instance, data.as_bytes())?.records),
                Some(EventKind::Record) | None => continue,
            };
            return Ok(Some(heard));
        }
        Ok(None)
    }
}

fn parsed<T: DeserializeOwned>(instance: &Instance, text: &[u8]) -> Result<T, AskError> {
    let instance = || instance.name().to_owned();
    serde_json::from_slice(text).map_err(|source| AskError::Answer { instance: instance(), source })
}
