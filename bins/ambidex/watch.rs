//! `ambidex watch`: what happens to the tasks of a daemon, a line each.

use ambidex::runtime::control::{Answer, NameOrId};
use ambidex::show::tasks::{TaskSummary, line};
use clap::Args;
use miette::{IntoDiagnostic, Result};

use crate::asking::{self, AskArgs};
use crate::exit::Exit;
use crate::log::say;
use crate::page::Page;
use crate::task_events::{Interrupts, TaskEvents};

/// `ambidex watch`.
#[derive(Debug, Args)]
pub struct WatchArgs {
    /// The task that is watched until it ends: its number or its name [default: every task, until the daemon ends].
    task: Option<NameOrId>,
    #[command(flatten)]
    ask: AskArgs,
}

/// Tells every change.
pub fn watch(args: &WatchArgs) -> Result<Exit> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().into_diagnostic()?;
    runtime.block_on(watched(args))
}

async fn watched(args: &WatchArgs) -> Result<Exit> {
    let mut interrupts = Interrupts::new().into_diagnostic()?;
    let mut events = match TaskEvents::open(&args.ask.instance).await {
        Ok(Ok(events)) => events,
        Ok(Err(refusal)) => return asking::told(&Answer::Refused(refusal), args.ask.json),
        Err(error) => return asking::unanswered(error),
    };
    let mut page = Page::new();
    let mut is_first = true;
    loop {
        let news = tokio::select! {
            () = interrupts.next() => return Ok(Exit::Canceled),
            news = events.next() => news,
        };
        let news = match news {
            Ok(Some(news)) => news,
            Ok(None) if events.is_all_over(args.task.as_ref()) => return Ok(Exit::Done),
            Ok(None) => {
                say("error: the daemon is gone (crashed or killed), and not every task had ended");
                return Ok(Exit::Controller);
            }
            Err(error) => return asking::unanswered(error),
        };
        let is_meant = |task: &&TaskSummary| args.task.as_ref().is_none_or(|wanted| wanted.is(task.task, &task.name));
        let meant: Vec<_> = news.iter().filter(is_meant).collect();
        for task in &meant {
            let text = match args.ask.json {
                true => serde_json::to_string(task).into_diagnostic()?,
                false => line(task, page.width(), &page.palette()),
            };
            page.line(&text)?;
        }
        // The first news are of all tasks.
        if let Some(wanted) = args.task.as_ref().filter(|_| meant.is_empty() && is_first) {
            let refusal = wanted.is_no_task(news.iter().map(|task| task.name.as_str()));
            return asking::told(&Answer::Refused(refusal), args.ask.json);
        }
        is_first = false;
        let is_over = args.task.is_some() && meant.iter().any(|task| task.state.is_end());
        if !page.flush()? || is_over {
            return Ok(Exit::Done);
        }
    }
}
