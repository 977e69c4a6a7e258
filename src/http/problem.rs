//! Refusals as answers of HTTP: a status, and what is wrong as `application/problem+json` (RFC 9457).

use std::collections::BTreeMap;

use axum::Json;
use axum::http::header::{CONTENT_TYPE, RETRY_AFTER, WWW_AUTHENTICATE};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::openapi::{self, ContentBuilder, Ref, RefOr, ResponseBuilder};
use utoipa::{IntoResponses, ToSchema};

use ambidex_runtime::control::{Refusal, Why};

/// What a problem is called in `Content-Type`.
pub const PROBLEM: &str = "application/problem+json";

/// Why nothing came of a request.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Problem {
    /// The status of the answer.
    pub status: u16,
    /// What the status is called.
    pub title: String,
    /// What is wrong, as a sentence.
    pub detail: String,
    /// What is wrong, for programs.
    pub why: Why,
    /// What can be done about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl Problem {
    /// What a client is told of a refusal.
    pub fn of(refusal: Refusal) -> Self {
        let status = status(refusal.why);
        let title = status.canonical_reason().unwrap_or_default().to_owned();
        Self { status: status.as_u16(), title, detail: refusal.said, why: refusal.why, help: refusal.help }
    }

    /// The refusal that it tells of.
    pub fn into_refusal(self) -> Refusal {
        Refusal { why: self.why, said: self.detail, help: self.help }
    }
}

/// The status of a refusal.
pub fn status(why: Why) -> StatusCode {
    match why {
        Why::Malformed => StatusCode::BAD_REQUEST,
        Why::Token => StatusCode::UNAUTHORIZED,
        Why::Foreign => StatusCode::FORBIDDEN,
        Why::NoSuchPath | Why::NoSuchName => StatusCode::NOT_FOUND,
        Why::TooSlow => StatusCode::REQUEST_TIMEOUT,
        Why::NotOutside | Why::Held | Why::NotTheirs | Why::NotBegun => StatusCode::CONFLICT,
        Why::TakesNoWork | Why::NotNow => StatusCode::CONFLICT,
        Why::TooLarge => StatusCode::PAYLOAD_TOO_LARGE,
        Why::Faulty => StatusCode::UNPROCESSABLE_ENTITY,
        Why::TooOften => StatusCode::TOO_MANY_REQUESTS,
        Why::Busy | Why::Late | Why::Over => StatusCode::SERVICE_UNAVAILABLE,
    }
}

/// A refusal as an answer, with a status of its own where the reason has several.
#[derive(Debug)]
pub struct Refused {
    refusal: Refusal,
    status: Option<StatusCode>,
    /// Seconds after which to try again.
    again_s: Option<u64>,
}

impl Refused {
    /// The same with another status.
    #[must_use]
    pub fn with_status(self, status: StatusCode) -> Self {
        Self { status: Some(status), ..self }
    }

    /// The same with when to try again.
    #[must_use]
    pub fn again_in(self, seconds: u64) -> Self {
        Self { again_s: Some(seconds), ..self }
    }
}

impl From<Refusal> for Refused {
    fn from(refusal: Refusal) -> Self {
        Self { refusal, status: None, again_s: None }
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        let mut problem = Problem::of(self.refusal);
        let mut status = status(problem.why);
        if let Some(other) = self.status {
            (status, problem.status) = (other, other.as_u16());
            problem.title = other.canonical_reason().unwrap_or_default().to_owned();
        }
        let mut response = (status, Json(&problem)).into_response();
        let headers = response.headers_mut();
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(PROBLEM));
        if status == StatusCode::UNAUTHORIZED {
            headers.insert(WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
        if let Some(seconds) = self.again_s {
            headers.insert(RETRY_AFTER, seconds.into());
        }
        response
    }
}

/// What may be wrong with every request.
pub struct Problems;

/// What may be wrong with a request for something that has a name, beside that.
pub struct NameProblems;

/// What may be wrong with a request that changes something, beside that.
pub struct ChangeProblems;

/// What may be wrong with a body.
pub struct BodyProblems;

impl IntoResponses for Problems {
    fn responses() -> BTreeMap<String, RefOr<openapi::Response>> {
        described(&[
            (StatusCode::FORBIDDEN, "It is meant for another host, or comes from another origin"),
            (StatusCode::SERVICE_UNAVAILABLE, "It is not to be had now; the run may be over"),
        ])
    }
}

impl IntoResponses for NameProblems {
    fn responses() -> BTreeMap<String, RefOr<openapi::Response>> {
        described(&[(StatusCode::BAD_REQUEST, "It is no request"), (StatusCode::NOT_FOUND, "There is no such name")])
    }
}

impl IntoResponses for ChangeProblems {
    fn responses() -> BTreeMap<String, RefOr<openapi::Response>> {
        described(&[
            (StatusCode::UNAUTHORIZED, "The token is missing or wrong"),
            (StatusCode::CONFLICT, "The state of the run or of the world does not allow it"),
            (StatusCode::TOO_MANY_REQUESTS, "Too much is asked at once; `Retry-After` tells when to ask again"),
        ])
    }
}

impl IntoResponses for BodyProblems {
    fn responses() -> BTreeMap<String, RefOr<openapi::Response>> {
        described(&[
            (StatusCode::BAD_REQUEST, "It is no JSON"),
            (StatusCode::REQUEST_TIMEOUT, "It did not come to its end in time"),
            (StatusCode::PAYLOAD_TOO_LARGE, "It is too long"),
            (StatusCode::UNSUPPORTED_MEDIA_TYPE, "It is not called `application/json`"),
            (StatusCode::UNPROCESSABLE_ENTITY, "It is JSON and no such request, or the task file in it is faulty"),
        ])
    }
}

fn described(rows: &[(StatusCode, &str)]) -> BTreeMap<String, RefOr<openapi::Response>> {
    let response = |said: &str| {
        let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
        ResponseBuilder::new().description(said).content(PROBLEM, content).build()
    };
    rows.iter().map(|(status, said)| (status.as_str().to_owned(), RefOr::T(response(said)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_the_same_behind_the_way() {
        let refusal = Refusal::new(Why::Held, "cup is held by left_gripper").with_help("wait");
        let problem = Problem::of(refusal.clone());
        assert_eq!((problem.status, problem.title.as_str()), (409, "Conflict"));
        let text = serde_json::to_string(&problem).expect("it is plain");
        let read: Problem = serde_json::from_str(&text).expect("it is one");
        assert_eq!(read.into_refusal(), refusal);
    }
}
