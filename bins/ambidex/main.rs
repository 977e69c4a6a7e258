//! The command line of Ambidex: one file per verb, no logic of its own.

mod args;
mod asking;
mod audit;
mod chaos;
mod check;
mod children;
mod controller;
mod descriptors;
mod diagnostics;
mod doctor;
mod edit;
mod emergency_stop;
mod exit;
mod explain;
mod export;
mod following;
mod import;
mod keeping;
mod log;
mod man;
mod map;
mod mission;
mod observer;
mod out;
mod own_record;
mod pacing;
mod page;
mod parallel;
mod purpose;
mod reading;
mod recording;
mod resume;
mod robot;
mod service;
mod signals;
mod simulate;
mod status;
mod submit;
mod task_events;
mod tasks;
mod telling;
mod terminal;
mod timeline;
mod trace;
mod tree;
mod trials;
mod values;
mod verify;
mod waiting;
mod watch;
mod world;

use std::process::ExitCode;

use ambidex::runtime::control::Work;
use clap::{CommandFactory, Parser};

use args::{Cli, Verb};
use exit::Exit;
use page::Page;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let exit = match cli.verb {
        Verb::Run(args) => mission::run(&args),
        Verb::Daemon(args) => mission::daemon(&args),
        Verb::Controller(args) => controller::controller(&args),
        Verb::Simulate(args) => simulate::simulate(&args),
        Verb::Check(args) => check::check(&args),
        Verb::Schema(args) => check::schema(&args),
        Verb::Status(args) => status::status(&args),
        Verb::Timeline(args) => timeline::timeline(&args),
        Verb::Tree(args) => tree::tree(&args),
        Verb::Map(args) => map::map(&args),
        Verb::Trace(args) => trace::trace(&args),
        Verb::Explain(args) => explain::explain(&args),
        Verb::Export(args) => export::export(&args),
        Verb::Verify(args) => verify::verify(&args),
        Verb::Audit(args) => audit::audit(&args),
        Verb::Chaos(args) => chaos::chaos(&args),
        Verb::World(args) => world::world(&args),
        Verb::Submit(args) => submit::submit(&args),
        Verb::List(args) => tasks::list(&args),
        Verb::Show(args) => tasks::show(&args),
        Verb::Watch(args) => watch::watch(&args),
        Verb::Cancel(args) => pacing::cancel(&args),
        Verb::Pause(args) => pacing::pace(&args, Work::Pause),
        Verb::Resume(args) => pacing::pace(&args, Work::Resume),
        Verb::Step(args) => pacing::pace(&args, Work::Step),
        Verb::Edit(args) => edit::edit(&args),
        Verb::Stop(args) => pacing::stop(&args),
        Verb::Import(args) => import::import(&args),
        Verb::Doctor(args) => doctor::doctor(&args),
        Verb::Man(args) => man::man(&args),
        Verb::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "ambidex", &mut script);
            Page::new().text(&String::from_utf8_lossy(&script)).map(|_| Exit::Done)
        }
    };
    match exit {
        Ok(exit) => exit.into(),
        Err(report) => {
            diagnostics::say(&report);
            Exit::Usage.into()
        }
    }
}
