//! Asking a daemon, and saying what it answered: what all verbs have in common that do.

use ambidex::http::{self, AskError, Request};
use ambidex::link::Instance;
use ambidex::runtime::control::{Answer, Refusal, Why};
use clap::Args;
use miette::{IntoDiagnostic, Report, Result, miette};

use crate::diagnostics::{self, legible};
use crate::exit::Exit;
use crate::page::Page;
use crate::values;

/// Who is asked.
#[derive(Debug, Args)]
pub struct AskArgs {
    /// Name of the robot's runtime.
    #[arg(long, global = true, default_value = "default", value_parser = values::instance)]
    pub instance: Instance,
    /// Print the answer as one object on stdout, and nothing else.
    #[arg(long, global = true)]
    pub json: bool,
}

/// Asks the daemon, and tells what came of it.
pub fn tell(args: &AskArgs, request: &Request) -> Result<Exit> {
    match http::ask(&args.instance, request) {
        Ok(answer) => told(&answer, args.json),
        Err(error) => unanswered(error),
    }
}

/// Tells what came of a request.
pub fn told(answer: &Answer, is_json: bool) -> Result<Exit> {
    if is_json {
        print(&http::json(answer))?;
    }
    match answer {
        Answer::Changed { said } | Answer::Same { said } if !is_json => print(&legible(said))?,
        Answer::Submitted { task, name } if !is_json => print(&format!("task {task}: {}", legible(name)))?,
        Answer::Changed { .. } | Answer::Same { .. } | Answer::Submitted { .. } => {}
        Answer::Refused(refusal) => {
            if !is_json && refusal.why == Why::Faulty {
                // A report already, of several lines.
                diagnostics::say_lines(refusal.said.lines());
            } else if !is_json {
                diagnostics::say(&refused(refusal));
            }
            return Ok(of_refusal(refusal.why));
        }
    }
    Ok(Exit::Done)
}

/// A refusal as it is said.
pub fn refused(refusal: &Refusal) -> Report {
    let said = legible(&refusal.said);
    match refusal.help.as_deref().map(legible) {
        Some(help) => miette!(help = help, "{said}"),
        None => miette!("{said}"),
    }
}

/// That nobody answered.
///
/// # Errors
/// What is wrong with the way to the daemon.
pub fn unanswered(error: AskError) -> Result<Exit> {
    match error {
        AskError::NoDaemon(_) | AskError::Ended(_) | AskError::Late { .. } => {
            diagnostics::say(&miette!("{error}"));
            Ok(Exit::Controller)
        }
        AskError::Socket { .. } | AskError::Answer { .. } => Err(error).into_diagnostic(),
    }
}

/// How a verb ends whose request was refused.
pub fn of_refusal(why: Why) -> Exit {
    match why {
        Why::Malformed | Why::NoSuchPath | Why::NoSuchName | Why::TooLarge | Why::Faulty => Exit::Usage,
        Why::Foreign | Why::Token | Why::TooSlow | Why::TooOften | Why::Busy | Why::Late => Exit::Failed,
        Why::NotOutside | Why::Held | Why::NotTheirs | Why::NotBegun => Exit::Failed,
        Why::TakesNoWork | Why::NotNow | Why::Over => Exit::Failed,
    }
}

fn print(line: &str) -> Result<()> {
    let mut page = Page::new();
    page.line(line)?;
    page.flush().map(drop)
}
