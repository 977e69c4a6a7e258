//! `ambidex simulate`.

use ambidex::config::{self, ConfigError};
use ambidex::sim;
use ambidex::tree::Settings;
use miette::{IntoDiagnostic, Result};

use crate::args::SimulateArgs;
use crate::exit::Exit;
use crate::observer::Observer;
use crate::terminal::{QUIET, Terminal};

/// Runs a mission under a virtual clock.
pub fn simulate(args: &SimulateArgs) -> Result<Exit> {
    let args = &args.mission;
    let loaded = config::load_mission(&args.mission, args.robot.as_deref()).map_err(ConfigError::into_report)?;
    let terminal = Terminal::start(args.log_format, QUIET);
    let mut observer = Observer::new(&loaded.mission, args, "simulate", &terminal).into_diagnostic()?;
    let settings = Settings { allocator: args.allocator.allocator(), ..Settings::default() };
    let end = sim::simulate(&loaded.mission, &settings, Vec::new(), &mut |record| observer.take(record));
    observer.finish().into_diagnostic()?;
    Ok(end.into())
}
