//! `ambidex cancel`, `pause`, `resume`, `step` and `stop`: how fast a running robot works, if at all.

use ambidex::http::Request;
use ambidex::runtime::control::{NameOrId, Work};
use clap::Args;
use miette::Result;

use crate::asking::{self, AskArgs};
use crate::exit::Exit;

/// A verb about one task.
#[derive(Debug, Args)]
pub struct TaskArgs {
    /// The task: its number or its name.
    task: NameOrId,
    #[command(flatten)]
    ask: AskArgs,
}

/// A verb about one task or all.
#[derive(Debug, Args)]
pub struct TasksArgs {
    /// The task: its number or its name [default: every task].
    task: Option<NameOrId>,
    #[command(flatten)]
    ask: AskArgs,
}

/// A verb about everything.
#[derive(Debug, Args)]
pub struct StopArgs {
    #[command(flatten)]
    ask: AskArgs,
}

/// Tells a task to end.
pub fn cancel(args: &TaskArgs) -> Result<Exit> {
    asking::tell(&args.ask, &Request::Work(Work::Cancel(args.task.clone())))
}

/// Pauses, or goes on, as `work` has it.
pub fn pace(args: &TasksArgs, work: fn(Option<NameOrId>) -> Work) -> Result<Exit> {
    asking::tell(&args.ask, &Request::Work(work(args.task.clone())))
}

/// Tells everything to end.
pub fn stop(args: &StopArgs) -> Result<Exit> {
    asking::tell(&args.ask, &Request::Work(Work::Stop))
}
