//! What somebody outside says of the world.

use axum::extract::State;
use axum::response::Response;

use super::{Served, told};
use crate::bodies::{Body, FactBody, ObjectBody, ObstacleBody, Outcome, Path, PlaceBody, PointBody};
use crate::problem::{BodyProblems, ChangeProblems, NameProblems, Problems};
use ambidex_runtime::Control;
use ambidex_runtime::control::{Answer, Refusal, Work, WorldChange};

/// A fact holds, or does not.
///
/// The mission must say that others may tell it (`outside: true`).
#[utoipa::path(post, path = "/v1/world/facts/{fact}", tag = "world", params(("fact" = String, Path, description = "The fact")),
    request_body = FactBody, security(("token" = [])), responses(
    (status = OK, description = "It is so now, or was already", body = Outcome),
    Problems, NameProblems, ChangeProblems, BodyProblems,
))]
pub(super) async fn set_fact(
    State(served): State<Served>,
    Path(fact): Path<String>,
    Body(FactBody { holds }): Body<FactBody>,
) -> Response {
    told(served.change(WorldChange::Fact { fact, holds }).await)
}

/// An object that no gripper holds lies at another place.
#[utoipa::path(post, path = "/v1/world/objects/{object}/place", tag = "world",
    params(("object" = String, Path, description = "The object")), request_body = PlaceBody, security(("token" = [])), responses(
    (status = OK, description = "It is so now, or was already", body = Outcome),
    Problems, NameProblems, ChangeProblems, BodyProblems,
))]
pub(super) async fn place_object(
    State(served): State<Served>,
    Path(object): Path<String>,
    Body(PlaceBody { place }): Body<PlaceBody>,
) -> Response {
    told(served.change(WorldChange::Place { object, place }).await)
}

/// Something stands in the room that was not there before: the base does not drive into it.
#[utoipa::path(post, path = "/v1/world/obstacles", tag = "world", request_body = ObstacleBody, security(("token" = [])),
    responses(
    (status = OK, description = "It is so now, or was already", body = Outcome),
    Problems, ChangeProblems, BodyProblems,
))]
pub(super) async fn block(
    State(served): State<Served>,
    Body(ObstacleBody { at, size, heading }): Body<ObstacleBody>,
) -> Response {
    told(served.change(WorldChange::Block { at, size, heading }).await)
}

/// What came to stand around a point of the map is gone.
#[utoipa::path(post, path = "/v1/world/obstacles/gone", tag = "world", request_body = PointBody, security(("token" = [])),
    responses(
    (status = OK, description = "It is so now, or was already", body = Outcome),
    Problems, ChangeProblems, BodyProblems,
))]
pub(super) async fn unblock(State(served): State<Served>, Body(PointBody { at }): Body<PointBody>) -> Response {
    told(served.change(WorldChange::Unblock { at }).await)
}

/// The world has one more object.
#[utoipa::path(post, path = "/v1/world/objects", tag = "world", request_body = ObjectBody, security(("token" = [])),
    responses(
    (status = OK, description = "It is there now", body = Outcome),
    Problems, NameProblems, ChangeProblems, BodyProblems,
))]
pub(super) async fn add_object(
    State(served): State<Served>,
    Body(ObjectBody { object, place }): Body<ObjectBody>,
) -> Response {
    told(served.work(Work::AddObject { object, place }).await)
}

/// The world has an object no more.
#[utoipa::path(delete, path = "/v1/world/objects/{object}", tag = "world",
    params(("object" = String, Path, description = "The object")), security(("token" = [])), responses(
    (status = OK, description = "It is gone now", body = Outcome),
    Problems, NameProblems, ChangeProblems,
))]
pub(super) async fn remove_object(State(served): State<Served>, Path(object): Path<String>) -> Response {
    told(served.work(Work::RemoveObject { object }).await)
}

impl Served {
    /// Says that the world is different.
    async fn change(&self, asked: WorldChange) -> Result<Answer, Refusal> {
        self.ask(|to| Control::Ask(asked, to)).await
    }

    /// Asks about the work of the run.
    pub(super) async fn work(&self, work: Work) -> Result<Answer, Refusal> {
        self.ask(|to| Control::Work(work, to)).await
    }
}
