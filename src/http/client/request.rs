//! What can be asked, as requests of HTTP; and answers of HTTP as what was meant by them.

use axum::http::{Method, StatusCode};
use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use serde::Serialize;

use crate::bodies::{FactBody, ObjectBody, ObstacleBody, Outcome, OutcomeKind, PlaceBody, PointBody, Submitted};
use crate::problem::Problem;
use ambidex_runtime::control::{Answer, NameOrId, Work, WorldChange};

/// What is asked of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// The world is different.
    World(WorldChange),
    /// There is something to do, or to be done otherwise.
    Work(Work),
}

/// A request as it is sent.
#[derive(Debug)]
pub(super) struct Call {
    pub(super) method: Method,
    pub(super) path: String,
    pub(super) body: Option<Vec<u8>>,
}

impl Call {
    /// A request of what is only read.
    pub(super) fn read(path: String) -> Self {
        Self { method: Method::GET, path, body: None }
    }

    pub(super) fn of(request: &Request) -> Self {
        match request {
            Request::World(WorldChange::Fact { fact, holds }) => {
                post(format!("world/facts/{}", encoded(fact)), &FactBody { holds: *holds })
            }
            Request::World(WorldChange::Place { object, place }) => {
                post(format!("world/objects/{}/place", encoded(object)), &PlaceBody { place: place.clone() })
            }
            Request::World(WorldChange::Block { at, size, heading }) => {
                post("world/obstacles".into(), &ObstacleBody { at: *at, size: *size, heading: *heading })
            }
            Request::World(WorldChange::Unblock { at }) => post("world/obstacles/gone".into(), &PointBody { at: *at }),
            Request::Work(work) => Self::of_work(work),
        }
    }

    fn of_work(work: &Work) -> Self {
        match work {
            Work::Submit(submission) => post("tasks".into(), submission),
            Work::Cancel(task) => bare(Method::DELETE, task_path(task)),
            Work::Pause(task) => paced(task.as_ref(), "pause"),
            Work::Resume(task) => paced(task.as_ref(), "resume"),
            Work::Step(task) => paced(task.as_ref(), "step"),
            Work::Edit(task, edit) => post(format!("{}/edit", task_path(task)), edit),
            Work::AddObject { object, place } => {
                post("world/objects".into(), &ObjectBody { object: object.clone(), place: place.clone() })
            }
            Work::RemoveObject { object } => bare(Method::DELETE, format!("world/objects/{}", encoded(object))),
            Work::Stop => bare(Method::POST, "stop".into()),
        }
    }
}

fn paced(task: Option<&NameOrId>, word: &str) -> Call {
    let path = task.map_or_else(|| word.to_owned(), |task| format!("{}/{word}", task_path(task)));
    bare(Method::POST, path)
}

fn task_path(task: &NameOrId) -> String {
    format!("tasks/{}", encoded(&task.to_string()))
}

fn bare(method: Method, path: String) -> Call {
    Call { method, path: format!("/v1/{path}"), body: None }
}

fn post(path: String, body: &impl Serialize) -> Call {
    let body = serde_json::to_vec(body).expect("it is plain");
    Call { body: Some(body), ..bare(Method::POST, path) }
}

/// A name as a part of a path.
pub(super) fn encoded(name: &str) -> String {
    utf8_percent_encode(name, NON_ALPHANUMERIC).to_string()
}

/// What an answer of HTTP means.
///
/// # Errors
/// When it is none of this interface.
pub fn answer_of(status: StatusCode, body: &[u8]) -> serde_json::Result<Answer> {
    if status == StatusCode::CREATED {
        return serde_json::from_slice(body).map(|Submitted { task, name }| Answer::Submitted { task, name });
    }
    if status.is_success() {
        return serde_json::from_slice(body).map(|Outcome { result, said }| match result {
            OutcomeKind::Changed => Answer::Changed { said },
            OutcomeKind::Same => Answer::Same { said },
        });
    }
    serde_json::from_slice(body).map(|problem: Problem| Answer::Refused(problem.into_refusal()))
}

/// An answer as one line of JSON, as HTTP has it.
pub fn json(answer: &Answer) -> String {
    let outcome = |result, said: &String| serde_json::to_string(&Outcome { result, said: said.clone() });
    let text = match answer {
        Answer::Changed { said } => outcome(OutcomeKind::Changed, said),
        Answer::Same { said } => outcome(OutcomeKind::Same, said),
        Answer::Submitted { task, name } => serde_json::to_string(&Submitted { task: *task, name: name.clone() }),
        Answer::Refused(refusal) => serde_json::to_string(&Problem::of(refusal.clone())),
    };
    text.expect("it is plain")
}
