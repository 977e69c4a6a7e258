//! `ambidex simulate`.

use std::sync::Arc;
use std::time::Duration;

use ambidex::files::failures_text;
use ambidex::model::{Failures, Mishap, MissionSpec, Time};
use ambidex::show::recording::WallClock;
use ambidex::sim::{self, Chance};
use ambidex::tree::Settings;
use miette::{IntoDiagnostic, Result, Severity, miette};

use crate::args::{Messages, MissionArgs, SimulateArgs};
use crate::exit::Exit;
use crate::mission::load;
use crate::observer::Observer;
use crate::purpose::{self, Purpose};
use crate::terminal::{Patience, QUIET, Terminal};
use crate::values::Fail;
use crate::{diagnostics, out, recording, trials};

/// Runs a mission under a virtual clock, once or many times.
pub fn simulate(args: &SimulateArgs) -> Result<Exit> {
    let common = &args.common;
    let loaded = load(&args.mission, common)?;
    let settings = settings(common, &loaded.mission);
    let mut failures = purpose::load(args.fail.as_ref().and_then(Fail::file), &loaded.mission)?;
    failures.mishaps.extend(args.until.map(|until| (Time::ZERO + until, Mishap::Cancel)));
    let probability = args.fail.as_ref().and_then(Fail::probability);
    let Some(probability) = probability else {
        return match args.chance_option() {
            Some(option) => Err(miette!(
                help = "give a probability, as in `--fail 0.05`",
                "{option} is about what goes wrong by chance, and nothing does"
            )),
            None => run(args, &loaded.mission, &settings, &failures),
        };
    };
    let chance = Chance { probability, seed: args.seed.unwrap_or(1) };
    if let Some(runs) = args.runs {
        return trials::run(common, &loaded.mission, &settings, &failures, chance, runs.get());
    }
    // What is drawn is known only in the end; with that it is run again, to be told and logged like any other.
    let (_, drawn) = sim::simulate_chance(&loaded.mission, &settings, &failures, chance, &mut |_| {});
    if let Some(file) = &args.save_failures {
        match failures_text(&drawn, &loaded.mission.names) {
            Some(text) => out::write(file, &text)?,
            None => diagnostics::say(&miette!(severity = Severity::Advice, "nothing goes wrong: no file is written")),
        }
    }
    run(args, &loaded.mission, &settings, &drawn)
}

fn run(args: &SimulateArgs, mission: &Arc<MissionSpec>, settings: &Settings, failures: &Failures) -> Result<Exit> {
    let common = &args.common;
    let terminal = Terminal::start(common.log_format, QUIET, Patience::Waits);
    let recorder = recording::start(common, mission, WallClock::NONE, Patience::Waits)?;
    let mut observer = Observer::new(mission, common, "simulate", &terminal, false).into_diagnostic()?;
    observer.recorder = recorder;
    observer.purpose = Purpose::of_simulation(failures, &mission.names);
    let end = sim::simulate_failures(mission, settings, failures, &mut |record| observer.take(record));
    let (end, is_whole) = (Exit::from(end), observer.finish());
    // Nothing moves any more, so the last words may wait for their reader.
    terminal.finish(Duration::ZERO);
    Ok(if is_whole { end } else { end.with_incomplete_log() })
}

fn settings(args: &MissionArgs, mission: &MissionSpec) -> Settings {
    Settings {
        allocator: args.allocator.allocator(),
        has_messages: Messages::are_told(args.messages, mission),
        reattach: args.reattach_timeout,
        cleanup_grace: args.cleanup_grace,
        ..Settings::default()
    }
}
