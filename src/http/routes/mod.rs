//! What is at which path, and the document that says so.

mod changes;
mod reading;
mod tasks;

use std::sync::{Arc, LazyLock};

use axum::extract::{DefaultBodyLimit, Extension, Request, State};
use axum::http::StatusCode;
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::{Router, http};
use tokio::sync::{Semaphore, mpsc, oneshot};
use tokio::time::timeout;
use utoipa::openapi::schema::AdditionalProperties;
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityScheme};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{Modify, OpenApi};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::gate::{self, Way};
use crate::hub::Hub;
use crate::limits::{ANSWER_WITHIN, BODY_MAX, FILES_MAX, Rate, STREAMS_MAX};
use crate::problem::{Problem, Refused};
use crate::token::Token;
use ambidex_model::MissionSpec;
use ambidex_runtime::control::{Answer, Refusal, Why, beginning};
use ambidex_runtime::{Control, Feed as Diagnoses};

/// What all routes are answered from.
#[derive(Debug, Clone)]
pub struct Served {
    mission: Arc<MissionSpec>,
    run: mpsc::UnboundedSender<Control>,
    hub: Hub,
    /// How well controllers are, each second.
    diagnostics: Diagnoses,
    token: Token,
    rate: Arc<Rate>,
    streams: Arc<Semaphore>,
}

#[derive(OpenApi)]
#[openapi(
    info(
        title = "Ambidex",
        description = "What a running robot is at, and what it is to do. It is served over a Unix socket, and over \
                       loopback where the daemon was told so.",
        license(name = "Apache-2.0", identifier = "Apache-2.0")
    ),
    servers((url = "/")),
    components(schemas(Problem)),
    modifiers(&WithToken),
    tags(
        (name = "reading", description = "What a run is at. Nothing is changed, and no token is needed."),
        (name = "world", description = "What somebody outside says of the world."),
        (name = "tasks", description = "What the robot is to do."),
    )
)]
struct Document;

/// How requests that change something are let in.
struct WithToken;

impl Modify for WithToken {
    fn modify(&self, document: &mut utoipa::openapi::OpenApi) {
        let said = "The content of the file `token` beside the socket of the daemon, which only its user can read.";
        let scheme = HttpBuilder::new().scheme(HttpAuthScheme::Bearer).description(Some(said)).build();
        let components = document.components.get_or_insert_default();
        components.add_security_scheme("token", SecurityScheme::Http(scheme));
    }
}

/// What is read by one key of several has no other keys.
fn close(schema: &mut RefOr<Schema>) {
    if let RefOr::T(Schema::Object(object)) = schema {
        object.additional_properties = Some(Box::new(AdditionalProperties::FreeForm(false)));
        object.properties.values_mut().for_each(close);
    }
}

impl Served {
    /// What a run of the mission is asked through, and the hub that tells of it.
    pub fn new(
        mission: Arc<MissionSpec>,
        run: mpsc::UnboundedSender<Control>,
        hub: Hub,
        diagnostics: Diagnoses,
        token: Token,
    ) -> Self {
        let streams = Arc::new(Semaphore::new(STREAMS_MAX));
        Self { mission, run, hub, diagnostics, token, rate: Arc::new(Rate::new()), streams }
    }

    /// The same with another rate of requests that change something.
    #[cfg(test)]
    pub fn with_rate(self, rate: Rate) -> Self {
        Self { rate: Arc::new(rate), ..self }
    }

    /// The routes for requests that come by a way.
    pub fn router(self, way: Way) -> Router {
        let (router, _) = all().split_for_parts();
        let router = router.fallback(no_such_path).method_not_allowed_fallback(no_such_method);
        let router = router.with_state(self.clone());
        router.layer(from_fn_with_state(self, let_in)).layer(Extension(way))
    }

    /// Hands something to the run, and waits for what it makes of it.
    async fn ask<T>(&self, control: impl FnOnce(oneshot::Sender<T>) -> Control) -> Result<T, Refusal> {
        let (answer, answered) = oneshot::channel();
        self.run.send(control(answer)).map_err(|_| Refusal::over())?;
        match timeout(ANSWER_WITHIN, answered).await {
            Ok(answer) => answer.map_err(|_| Refusal::over()),
            Err(_) => {
                let within = ANSWER_WITHIN.as_secs();
                let said = format!("the run has not decided within {within} s, and may still do what was asked");
                Err(Refusal::new(Why::Late, said))
            }
        }
    }
}

/// What is at which path, as JSON of OpenAPI.
pub fn document() -> &'static str {
    static DOCUMENT: LazyLock<String> = LazyLock::new(|| {
        let mut document = all().to_openapi();
        let edit = document.components.as_mut().and_then(|components| components.schemas.get_mut("Edit"));
        if let Some(RefOr::T(Schema::OneOf(edit))) = edit {
            edit.items.iter_mut().for_each(close);
        }
        document.to_json().expect("a document of plain words")
    });
    &DOCUMENT
}

fn all() -> OpenApiRouter<Served> {
    let small = OpenApiRouter::with_openapi(Document::openapi())
        .routes(routes!(reading::openapi))
        .routes(routes!(reading::about))
        .routes(routes!(reading::status))
        .routes(routes!(reading::events))
        .routes(routes!(changes::set_fact))
        .routes(routes!(changes::place_object))
        .routes(routes!(changes::block))
        .routes(routes!(changes::unblock))
        .routes(routes!(changes::add_object))
        .routes(routes!(changes::remove_object))
        .routes(routes!(tasks::show, tasks::cancel))
        .routes(routes!(tasks::pause))
        .routes(routes!(tasks::resume))
        .routes(routes!(tasks::step))
        .routes(routes!(tasks::pause_all))
        .routes(routes!(tasks::resume_all))
        .routes(routes!(tasks::step_all))
        .routes(routes!(tasks::stop))
        .layer(DefaultBodyLimit::max(BODY_MAX));
    let large = OpenApiRouter::default()
        .routes(routes!(tasks::list, tasks::submit))
        .routes(routes!(tasks::edit))
        .layer(DefaultBodyLimit::max(FILES_MAX));
    small.merge(large)
}

/// Lets in whoever may come in, and as often as it may.
async fn let_in(
    State(served): State<Served>,
    Extension(way): Extension<Way>,
    request: Request,
    next: Next,
) -> Response {
    let (method, uri, headers) = (request.method(), request.uri(), request.headers());
    if let Err(refusal) = gate::check(way, method, uri, headers, &served.token) {
        return Refused::from(refusal).into_response();
    }
    if gate::changes(method)
        && let Err(wait) = served.rate.take()
    {
        let said = "more is asked of this daemon than it takes; try again later";
        return Refused::from(Refusal::new(Why::TooOften, said)).again_in(wait.as_secs() + 1).into_response();
    }
    next.run(request).await
}

async fn no_such_path(request: Request) -> Refused {
    let said = format!("there is nothing at {}", beginning(request.uri().path()));
    Refused::from(Refusal::new(Why::NoSuchPath, said).with_help("`GET /v1/openapi.json` says what is where"))
}

async fn no_such_method(method: http::Method) -> Refused {
    let said = format!("{} is nothing that can be done there", beginning(method.as_str()));
    Refused::from(Refusal::new(Why::NoSuchPath, said)).with_status(StatusCode::METHOD_NOT_ALLOWED)
}

/// A refusal, or what the run made of it.
fn told(answer: Result<Answer, Refusal>) -> Response {
    crate::bodies::respond(answer.unwrap_or_else(Answer::Refused))
}
