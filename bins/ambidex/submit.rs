//! `ambidex submit`: one more task for a running robot.

use std::time::Duration;

use ambidex::http::{self, AskError, Request};
use ambidex::link::Instance;
use ambidex::model::PRIORITY_MAX;
use ambidex::runtime::control::{Answer, NameOrId, Submission, Work};
use ambidex::show::tasks::{TaskState, TaskSummary, line};
use clap::{Args, value_parser};
use miette::{IntoDiagnostic, Result};

use crate::asking::{self, AskArgs};
use crate::edit::FileArgs;
use crate::exit::Exit;
use crate::page::Page;
use crate::task_events::{Interrupts, TaskEvents};
use crate::terminal::{Patience, QUIET, Terminal};
use crate::values::LogFormat;

/// How long the last words may wait for a reader.
const TALK_GRACE: Duration = Duration::from_secs(1);

const HELP: &str = "\
Without --wait it ends with 0 once the robot has the task. With --wait it ends as the task does: 0 done, 1 failed,
3 stalled when the daemon ended, 4 the daemon ended before, 130 canceled. Ctrl-C cancels the task and waits for its end;
a second one leaves it to itself.";

/// `ambidex submit`.
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct SubmitArgs {
    #[command(flatten)]
    file: FileArgs,
    /// How urgent the task is: the greater, the more [default: as its file says].
    #[arg(long, value_name = "P", allow_negative_numbers = true, value_parser = value_parser!(i32).range(-i64::from(PRIORITY_MAX)..=i64::from(PRIORITY_MAX)))]
    priority: Option<i32>,
    /// What the task is called [default: as its file calls it].
    #[arg(long)]
    name: Option<String>,
    /// Begin paused.
    #[arg(long, conflicts_with = "wait")]
    pause: bool,
    /// Wait until the task has ended.
    #[arg(long)]
    wait: bool,
    #[command(flatten)]
    ask: AskArgs,
}

/// Submits a task, and waits for its end if that is wanted.
pub fn submit(args: &SubmitArgs) -> Result<Exit> {
    let SubmitArgs { file, priority, name, pause, wait, ask } = args;
    let source = file.gather()?;
    let submission = Submission { name: name.clone(), priority: *priority, pause: *pause, source };
    let answer = match http::ask(&ask.instance, &Request::Work(Work::Submit(submission))) {
        Ok(answer) => answer,
        Err(error) => return asking::unanswered(error),
    };
    match answer {
        Answer::Submitted { task, .. } if *wait => {
            if !ask.json {
                asking::told(&answer, false)?;
            }
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().into_diagnostic()?;
            runtime.block_on(waited(ask, task))
        }
        Answer::Submitted { .. } | Answer::Changed { .. } | Answer::Same { .. } | Answer::Refused(_) => {
            asking::told(&answer, ask.json)
        }
    }
}

/// Follows a task until it ends, its daemon does, or nobody wants to wait any more.
async fn waited(ask: &AskArgs, task: u32) -> Result<Exit> {
    let mut interrupts = Interrupts::new().into_diagnostic()?;
    let mut events = match TaskEvents::open(&ask.instance).await {
        Ok(Ok(events)) => events,
        Ok(Err(refusal)) => return asking::told(&Answer::Refused(refusal), ask.json),
        Err(error) => return asking::unanswered(error),
    };
    let terminal = Terminal::start(LogFormat::Text, QUIET, Patience::Drops);
    let mut is_canceled = false;
    let ended = loop {
        tokio::select! {
            () = interrupts.next() => {
                if std::mem::replace(&mut is_canceled, true) {
                    terminal.say(&format!("task {task} is left to itself"));
                    terminal.finish(TALK_GRACE);
                    return Ok(Exit::Canceled);
                }
                terminal.say(&format!("task {task} is told to end; Ctrl-C once more leaves it to itself"));
                tokio::spawn(cancel(ask.instance.clone(), task, terminal.clone()));
            }
            news = events.next() => match news {
                Ok(Some(news)) => {
                    let Some(news) = news.into_iter().find(|news| news.task == task) else { continue };
                    show(&news, &terminal);
                    if news.state.is_end() {
                        break Some(news);
                    }
                }
                Ok(None) => break events.task(task).cloned(),
                Err(error) => return asking::unanswered(error),
            },
        }
    };
    terminal.clear();
    if let Some(task) = ended.as_ref().filter(|_| ask.json) {
        let mut page = Page::new();
        page.line(&serde_json::to_string(task).into_diagnostic()?)?;
        page.flush()?;
    }
    let exit = of_end(ended.map(|task| task.state));
    if exit == Exit::Controller {
        terminal.say(&format!("× the daemon ended before task {task} did"));
    }
    terminal.finish(TALK_GRACE);
    Ok(exit)
}

/// How the verb ends when the task was this at last.
fn of_end(state: Option<TaskState>) -> Exit {
    match state {
        Some(TaskState::Done) => Exit::Done,
        Some(TaskState::Failed) => Exit::Failed,
        Some(TaskState::Canceled) => Exit::Canceled,
        Some(TaskState::Stalled) => Exit::Stalled,
        Some(TaskState::Running | TaskState::Waiting | TaskState::Paused | TaskState::Ending) | None => {
            Exit::Controller
        }
    }
}

/// A line that is drawn again where somebody looks, else one more.
fn show(task: &TaskSummary, terminal: &Terminal) {
    let line = line(task, terminal.width(), &terminal.palette());
    match terminal.is_tty() && !task.state.is_end() {
        true => terminal.show(vec![line]),
        false => terminal.say(&line),
    }
}

async fn cancel(instance: Instance, task: u32, terminal: Terminal) {
    let request = Request::Work(Work::Cancel(NameOrId::Id(task)));
    match http::ask_later(&instance, &request).await {
        Ok(Answer::Refused(refusal)) => terminal.say(&format!("{:?}", asking::refused(&refusal))),
        Ok(Answer::Changed { .. } | Answer::Same { .. } | Answer::Submitted { .. }) => {}
        // That it is gone is heard by who follows it.
        Err(AskError::NoDaemon(_) | AskError::Ended(_)) => {}
        Err(error @ (AskError::Socket { .. } | AskError::Late { .. } | AskError::Answer { .. })) => {
            terminal.say(&format!("× {error}"));
        }
    }
}
