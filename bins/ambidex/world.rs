//! `ambidex world`: what somebody outside says of the world.

use ambidex::link::Instance;
use ambidex::runtime::control::{self, Answer, AskError, Request, Why, WorldChange};
use clap::{Args, Subcommand};
use miette::{IntoDiagnostic, Result, miette};

use crate::diagnostics;
use crate::exit::Exit;
use crate::page::Page;
use crate::values;

/// `ambidex world`.
#[derive(Debug, Args)]
pub struct WorldArgs {
    /// What is different.
    #[command(subcommand)]
    change: ChangeArgs,
    /// Name of the robot's runtime.
    #[arg(long, global = true, default_value = "default", value_parser = values::instance)]
    instance: Instance,
    /// Print the answer as one object on stdout, and nothing else.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Subcommand)]
enum ChangeArgs {
    /// A fact holds that the mission declares `outside: true`.
    Set {
        /// The fact.
        fact: String,
    },
    /// A fact does not hold that the mission declares `outside: true`.
    Clear {
        /// The fact.
        fact: String,
    },
    /// An object that no gripper holds lies at a place now.
    Move {
        /// The object.
        object: String,
        /// The place.
        place: String,
    },
}

/// Tells it to the daemon of the instance, and what came of it.
pub fn world(args: &WorldArgs) -> Result<Exit> {
    let change = match &args.change {
        ChangeArgs::Set { fact } => WorldChange::Set(fact.clone()),
        ChangeArgs::Clear { fact } => WorldChange::Clear(fact.clone()),
        ChangeArgs::Move { object, place } => WorldChange::Move { object: object.clone(), to: place.clone() },
    };
    let answer = match control::ask(&args.instance, &Request::World(change)) {
        Ok(answer) => answer,
        Err(error @ (AskError::NoDaemon(_) | AskError::Ended(_) | AskError::Late { .. })) => {
            diagnostics::say(&miette!("{error}"));
            return Ok(Exit::Controller);
        }
        Err(error @ (AskError::Socket { .. } | AskError::Answer { .. })) => return Err(error).into_diagnostic(),
    };
    if args.json {
        print(&serde_json::to_string(&answer).into_diagnostic()?)?;
    }
    match answer {
        Answer::Changed { said } | Answer::Same { said } => {
            if !args.json {
                print(&legible(said))?;
            }
            Ok(Exit::Done)
        }
        Answer::Refused { why, said, help } => {
            if !args.json {
                let said = legible(said);
                diagnostics::say(&match help.map(legible) {
                    Some(help) => miette!(help = help, "{said}"),
                    None => miette!("{said}"),
                });
            }
            Ok(of_refusal(why))
        }
    }
}

fn print(line: &str) -> Result<()> {
    let mut page = Page::new();
    page.line(line)?;
    page.flush().map(drop)
}

fn of_refusal(why: Why) -> Exit {
    match why {
        Why::Malformed | Why::Version | Why::NoSuchName => Exit::Usage,
        Why::Busy | Why::NotOutside | Why::Held | Why::NotTheirs | Why::NotBegun | Why::Over => Exit::Failed,
    }
}

/// Names are whatever a file says, and a terminal obeys some letters.
fn legible(mut said: String) -> String {
    ambidex::model::make_legible(&mut said);
    said
}
