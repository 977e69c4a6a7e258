//! What a run is at.

use std::convert::Infallible;

use axum::Json;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;
use axum::response::sse::{self, KeepAlive, Sse};

use super::{Served, document};
use crate::hub::Event;
use crate::limits::{HEARTBEAT, STREAMS_MAX};
use crate::problem::{Problems, Refused};
use ambidex_runtime::control::{About, Refusal, Why};
use ambidex_show::status::Snapshot;

/// This document.
#[utoipa::path(get, path = "/v1/openapi.json", tag = "reading", responses(
    (status = OK, description = "OpenAPI 3.1", body = Object, content_type = "application/json"),
    Problems,
))]
pub(super) async fn openapi() -> impl IntoResponse {
    ([(CONTENT_TYPE, "application/json")], document())
}

/// What this daemon is, and how well each controller was in the last second.
#[utoipa::path(get, path = "/v1/about", tag = "reading", responses(
    (status = OK, description = "Versions, and diagnostics of controllers", body = About),
    Problems,
))]
pub(super) async fn about(State(served): State<Served>) -> Json<About> {
    Json(About::this(&served.diagnostics.borrow(), &served.mission.names))
}

/// What the mission is at: tree, resources, controllers, world.
#[utoipa::path(get, path = "/v1/status", tag = "reading", responses(
    (status = OK, description = "The object of `ambidex status --json`", body = Snapshot),
    Problems,
))]
pub(super) async fn status(State(served): State<Served>) -> Json<Snapshot> {
    Json(served.hub.snapshot())
}

/// All that happens, as a stream.
///
/// First comes `snapshot`, the object of `/v1/status`; then `record` for every record, with names where the log has
/// ids, as `ambidex trace --json` prints it; and `task` for every task that is not as before. Whoever reads too slowly
/// is told `dropped` with how many records it missed, and goes on from another `snapshot`. `id` counts the records since
/// the daemon began. `Last-Event-ID` is not heeded: a snapshot says more.
#[utoipa::path(get, path = "/v1/events", tag = "reading", responses(
    (status = OK, description = "Server-sent events, until the run is over", body = String,
        content_type = "text/event-stream"),
    Problems,
))]
pub(super) async fn events(State(served): State<Served>) -> Result<impl IntoResponse, Refused> {
    let Ok(permit) = served.streams.clone().try_acquire_owned() else {
        let said = format!("{STREAMS_MAX} others follow the run already");
        return Err(Refused::from(Refusal::new(Why::Busy, said)).again_in(1));
    };
    let subscription = served.hub.subscribe();
    let events = futures_util::stream::unfold((subscription, permit), async |(mut subscription, permit)| {
        let event = subscription.next().await?;
        Some((Ok::<_, Infallible>(written(&event)), (subscription, permit)))
    });
    Ok(Sse::new(events).keep_alive(KeepAlive::new().interval(HEARTBEAT)))
}

fn written(event: &Event) -> sse::Event {
    sse::Event::default().event(event.kind.word()).id(event.seq.to_string()).data(&*event.data)
}
