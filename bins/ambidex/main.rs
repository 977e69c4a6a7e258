//! The command line of Ambidex: one file per verb, no logic of its own.

mod args;
mod children;
mod controller;
mod exit;
mod import;
mod mission;
mod observer;
mod robot;
mod simulate;
mod terminal;

use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use args::{Cli, Verb};
use exit::Exit;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let exit = match cli.verb {
        Verb::Run(args) => mission::run(&args),
        Verb::Daemon(args) => mission::daemon(&args),
        Verb::Controller(args) => controller::controller(&args),
        Verb::Simulate(args) => simulate::simulate(&args),
        Verb::Import(args) => import::import(&args),
        Verb::Completions { shell } => {
            clap_complete::generate(shell, &mut Cli::command(), "ambidex", &mut std::io::stdout());
            Ok(Exit::Done)
        }
    };
    match exit {
        Ok(exit) => exit.into(),
        Err(report) => {
            drop(writeln!(std::io::stderr(), "{report:?}"));
            Exit::Usage.into()
        }
    }
}
