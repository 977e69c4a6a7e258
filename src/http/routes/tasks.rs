//! What the robot is to do.

use axum::Json;
use axum::extract::State;
use axum::response::Response;

use super::{Served, told};
use crate::bodies::{Body, Outcome, Path, Submitted, Tasks};
use crate::problem::{BodyProblems, ChangeProblems, NameProblems, Problems, Refused};
use ambidex_runtime::control::{Edit, NameOrId, Refusal, Submission, Why, Work, beginning};
use ambidex_show::tasks::TaskDetail;

/// Every task, in the order in which they came.
#[utoipa::path(get, path = "/v1/tasks", tag = "tasks", responses(
    (status = OK, description = "The tasks", body = Tasks),
    Problems,
))]
pub(super) async fn list(State(served): State<Served>) -> Json<Tasks> {
    Json(Tasks { tasks: served.hub.tasks() })
}

/// A task with its tree.
#[utoipa::path(get, path = "/v1/tasks/{task}", tag = "tasks",
    params(("task" = String, Path, description = "Its number or its name")), responses(
    (status = OK, description = "The task", body = TaskDetail),
    Problems, NameProblems,
))]
pub(super) async fn show(State(served): State<Served>, Path(task): Path<String>) -> Result<Json<TaskDetail>, Refused> {
    let tasks = served.hub.tasks();
    let wanted = NameOrId::from(task);
    let found = tasks.iter().find(|task| wanted.is(task.task, &task.name));
    let detail = found.and_then(|task| served.hub.task(task.task));
    detail.map(Json).ok_or_else(|| wanted.is_no_task(tasks.iter().map(|task| task.name.as_str())).into())
}

/// One more task.
#[utoipa::path(post, path = "/v1/tasks", tag = "tasks", request_body = Submission, security(("token" = [])), responses(
    (status = CREATED, description = "The robot has the task now", body = Submitted),
    Problems, NameProblems, ChangeProblems, BodyProblems,
))]
pub(super) async fn submit(
    State(served): State<Served>,
    Body(submission): Body<Submission>,
) -> Result<Response, Refused> {
    if let Some(name) = submission.name.as_ref().filter(|name| !is_name(name)) {
        let said = format!("`{}` is no name for a task", beginning(name));
        let help = "a name has up to 64 letters, and others than digits among them";
        let refusal = Refusal::new(Why::Malformed, said).with_help(help);
        return Err(Refused::from(refusal).with_status(axum::http::StatusCode::UNPROCESSABLE_ENTITY));
    }
    Ok(told(served.work(Work::Submit(submission)).await))
}

/// A task is to end.
#[utoipa::path(delete, path = "/v1/tasks/{task}", tag = "tasks",
    params(("task" = String, Path, description = "Its number or its name")), security(("token" = [])), responses(
    (status = OK, description = "It is told to end", body = Outcome),
    Problems, NameProblems, ChangeProblems,
))]
pub(super) async fn cancel(State(served): State<Served>, Path(task): Path<String>) -> Response {
    told(served.work(Work::Cancel(task.into())).await)
}

/// The tree of a task is to be different.
#[utoipa::path(post, path = "/v1/tasks/{task}/edit", tag = "tasks",
    params(("task" = String, Path, description = "Its number or its name")), request_body = Edit, security(("token" = [])), responses(
    (status = OK, description = "It is different", body = Outcome),
    Problems, NameProblems, ChangeProblems, BodyProblems,
))]
pub(super) async fn edit(State(served): State<Served>, Path(task): Path<String>, Body(edit): Body<Edit>) -> Response {
    told(served.work(Work::Edit(task.into(), edit)).await)
}

/// Requests without a body that are about one task, and those about all.
macro_rules! pacing {
    ($($name:ident $all:ident $word:literal $work:ident $said:literal;)+) => {$(
        #[utoipa::path(post, path = concat!("/v1/tasks/{task}/", $word), tag = "tasks",
            summary = concat!("A task ", $said, "."),
            params(("task" = String, Path, description = "Its number or its name")), security(("token" = [])), responses(
            (status = OK, description = "It is so now, or was already", body = Outcome),
            Problems, NameProblems, ChangeProblems,
        ))]
        pub(super) async fn $name(State(served): State<Served>, Path(task): Path<String>) -> Response {
            told(served.work(Work::$work(Some(task.into()))).await)
        }

        #[utoipa::path(post, path = concat!("/v1/", $word), tag = "tasks",
            summary = concat!("Every task ", $said, "."), security(("token" = [])), responses(
            (status = OK, description = "It is so now, or was already", body = Outcome),
            Problems, ChangeProblems,
        ))]
        pub(super) async fn $all(State(served): State<Served>) -> Response {
            told(served.work(Work::$work(None)).await)
        }
    )+};
}

pacing! {
    pause pause_all "pause" Pause "is granted nothing more for now";
    resume resume_all "resume" Resume "goes on";
    step step_all "step" Step "is granted one step and pauses again";
}

/// Everything is to end: what was begun is cleaned up, controllers come to rest, and the daemon ends.
#[utoipa::path(post, path = "/v1/stop", tag = "tasks", security(("token" = [])), responses(
    (status = OK, description = "It is told to end", body = Outcome),
    Problems, ChangeProblems,
))]
pub(super) async fn stop(State(served): State<Served>) -> Response {
    told(served.work(Work::Stop).await)
}

fn is_name(name: &str) -> bool {
    const LONGEST: usize = 64;
    (1..=LONGEST).contains(&name.chars().count()) && !name.chars().all(|letter| letter.is_ascii_digit())
}
