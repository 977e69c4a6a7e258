//! `ambidex simulate`.

use ambidex::sim;
use ambidex::tree::Settings;
use miette::{IntoDiagnostic, Result};

use crate::args::SimulateArgs;
use crate::exit::Exit;
use crate::mission::load;
use crate::observer::Observer;
use crate::terminal::{QUIET, Terminal};

/// Runs a mission under a virtual clock.
pub fn simulate(args: &SimulateArgs) -> Result<Exit> {
    let args = &args.mission;
    let loaded = load(args)?;
    let terminal = Terminal::start(args.log_format, QUIET);
    let mut observer = Observer::new(&loaded.mission, args, "simulate", &terminal, false).into_diagnostic()?;
    let settings = Settings { allocator: args.allocator.allocator(), ..Settings::default() };
    let end = sim::simulate(&loaded.mission, &settings, Vec::new(), &mut |record| observer.take(record));
    observer.finish().into_diagnostic()?;
    Ok(end.into())
}
