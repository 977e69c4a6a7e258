//! `ambidex list` and `ambidex show`: the tasks of a daemon.

use ambidex::http::{self, AskError, Tasks};
use ambidex::runtime::control::{Answer, NameOrId, Refusal};
use ambidex::show::Palette;
use ambidex::show::tasks::{self, TaskDetail};
use clap::Args;
use serde::Serialize;

use crate::asking::{self, AskArgs};
use crate::exit::Exit;
use crate::page::Page;

/// `ambidex list`.
#[derive(Debug, Args)]
pub struct ListArgs {
    #[command(flatten)]
    ask: AskArgs,
}

/// `ambidex show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// The task: its number or its name.
    task: NameOrId,
    #[command(flatten)]
    ask: AskArgs,
}

/// Prints all tasks.
pub fn list(args: &ListArgs) -> miette::Result<Exit> {
    let text = |all: &Tasks, width, palette: &_| tasks::table(&all.tasks, width, palette);
    tell(&args.ask, http::read(&args.ask.instance, "tasks", None), text)
}

/// Prints one with its tree.
pub fn show(args: &ShowArgs) -> miette::Result<Exit> {
    let task = http::read(&args.ask.instance, "tasks", Some(&args.task.to_string()));
    tell(&args.ask, task, |task: &TaskDetail, width, palette| tasks::tree(task, width, palette))
}

fn tell<T: Serialize>(
    args: &AskArgs,
    answer: Result<Result<T, Refusal>, AskError>,
    text: impl FnOnce(&T, usize, &Palette) -> String,
) -> miette::Result<Exit> {
    match answer {
        Ok(Ok(answer)) => Page::new().tell(args.json, &answer, text).map(|()| Exit::Done),
        Ok(Err(refusal)) => asking::told(&Answer::Refused(refusal), args.json),
        Err(error) => asking::unanswered(error),
    }
}
