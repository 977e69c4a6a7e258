//! What stands in the bodies of requests and answers, and how a body is read.

use axum::extract::rejection::{JsonRejection, PathRejection};
use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use tokio::time::timeout;
use utoipa::ToSchema;

use crate::limits::BODY_WITHIN;
use crate::problem::Refused;
use ambidex_runtime::control::{Answer, Refusal, Why};
use ambidex_show::tasks::TaskSummary;

/// Whether a fact holds.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FactBody {
    /// Whether it holds from now on.
    pub holds: bool,
}

/// Where an object is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceBody {
    /// The place where it lies from now on.
    pub place: String,
}

/// An object that the world did not have.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectBody {
    /// What it is called.
    pub object: String,
    /// The place where it lies.
    pub place: String,
}

/// Something that has come to stand in the room.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleBody {
    /// Its middle on the map, meters: x and y.
    pub at: [f64; 2],
    /// Along its own x and y, meters.
    pub size: [f64; 2],
    /// Where its x points, radians, counterclockwise from x of the map.
    #[serde(default)]
    pub heading: f64,
}

/// A point of the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PointBody {
    /// Meters: x and y.
    pub at: [f64; 2],
}

/// What came of a request that was not refused.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Outcome {
    /// Whether anything is different.
    pub result: OutcomeKind,
    /// What is so now, as a sentence.
    pub said: String,
}

/// Whether anything is different.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum OutcomeKind {
    /// It was done.
    Changed,
    /// It was so already.
    Same,
}

/// A task that was submitted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Submitted {
    /// Its number.
    pub task: u32,
    /// Its name.
    pub name: String,
}

/// All tasks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Tasks {
    /// Every task, in the order in which they came.
    pub tasks: Vec<TaskSummary>,
}

/// What is answered to what a run was asked.
pub fn respond(answer: Answer) -> Response {
    let outcome = |result, said| axum::Json(Outcome { result, said }).into_response();
    match answer {
        Answer::Changed { said } => outcome(OutcomeKind::Changed, said),
        Answer::Same { said } => outcome(OutcomeKind::Same, said),
        Answer::Submitted { task, name } => (StatusCode::CREATED, axum::Json(Submitted { task, name })).into_response(),
        Answer::Refused(refusal) => Refused::from(refusal).into_response(),
    }
}

/// A body of JSON, which comes to its end in time.
#[derive(Debug)]
pub struct Body<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for Body<T> {
    type Rejection = Refused;

    async fn from_request(request: Request, state: &S) -> Result<Self, Refused> {
        match timeout(BODY_WITHIN, axum::Json::<T>::from_request(request, state)).await {
            Ok(Ok(axum::Json(value))) => Ok(Self(value)),
            Ok(Err(rejection)) => Err(unread(&rejection)),
            Err(_) => {
                let said = format!("the body did not come to its end within {} s", BODY_WITHIN.as_secs());
                Err(Refusal::new(Why::TooSlow, said).into())
            }
        }
    }
}

fn unread(rejection: &JsonRejection) -> Refused {
    // What is wrong may be a word of any length.
    const MOST: usize = 500;
    let said = rejection.body_text();
    let said = &said[..said.floor_char_boundary(MOST)];
    match rejection.status() {
        StatusCode::PAYLOAD_TOO_LARGE => Refusal::new(Why::TooLarge, "the body is too long").into(),
        status => Refused::from(Refusal::new(Why::Malformed, said)).with_status(status),
    }
}

/// Names in a path.
#[derive(Debug, FromRequestParts)]
#[from_request(via(axum::extract::Path), rejection(Refused))]
pub struct Path<T>(pub T);

impl From<PathRejection> for Refused {
    fn from(rejection: PathRejection) -> Self {
        Refusal::new(Why::Malformed, rejection.body_text()).into()
    }
}
