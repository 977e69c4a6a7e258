//! `ambidex simulate`.

use std::time::Duration;

use ambidex::model::{Mishap, Time};
use ambidex::sim;
use ambidex::tree::Settings;
use miette::{IntoDiagnostic, Result};

use crate::args::{Messages, SimulateArgs};
use crate::exit::Exit;
use crate::mission::load;
use crate::observer::Observer;
use crate::purpose::{self, Purpose};
use crate::terminal::{Patience, QUIET, Terminal};

/// Runs a mission under a virtual clock.
pub fn simulate(args: &SimulateArgs) -> Result<Exit> {
    let (mission, fail, until, args) = (&args.mission, args.fail.as_deref(), args.until, &args.common);
    let loaded = load(mission, args)?;
    let mut failures = purpose::load(fail, &loaded.mission)?;
    failures.mishaps.extend(until.map(|until| (Time::ZERO + until, Mishap::Cancel)));
    let terminal = Terminal::start(args.log_format, QUIET, Patience::Waits);
    let mut observer = Observer::new(&loaded.mission, args, "simulate", &terminal, false).into_diagnostic()?;
    let has_messages = Messages::are_told(args.messages, &loaded.mission);
    let settings = Settings {
        allocator: args.allocator.allocator(),
        has_messages,
        reattach: args.reattach_timeout,
        cleanup_grace: args.cleanup_grace,
        ..Settings::default()
    };
    observer.purpose = Purpose::of_simulation(&failures, &loaded.mission.names);
    let end = sim::simulate_failures(&loaded.mission, &settings, &failures, &mut |record| observer.take(record));
    let (end, is_whole) = (Exit::from(end), observer.finish());
    // Nothing moves any more, so the last words may wait for their reader.
    terminal.finish(Duration::ZERO);
    Ok(if is_whole { end } else { end.with_incomplete_log() })
}
