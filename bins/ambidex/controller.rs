//! `ambidex controller`.

use ambidex::files::{self, Disk};
use ambidex::link::{ServeOptions, Stop, serve};
use ambidex::motion;
use miette::{IntoDiagnostic, Result, miette};

use crate::args::{ControllerArgs, LogFormat};
use crate::diagnostics::report_all;
use crate::exit::Exit;
use crate::terminal::{Patience, QUIET, TALKING, Terminal};
use crate::{descriptors, signals};

/// Serves one simulated controller until it is told to stop.
pub fn controller(args: &ControllerArgs) -> Result<Exit> {
    let file = files::load_robot(&Disk, &args.robot).map_err(|error| report_all(&error))?;
    let controllers = &file.robot.controllers;
    let Some(spec) = controllers.iter().find(|spec| spec.name == args.name) else {
        let names: Vec<_> = controllers.iter().map(|spec| spec.name.as_str()).collect();
        return Err(miette!(
            "{} has no controller \"{}\"; it has {}",
            args.robot.display(),
            args.name,
            names.join(", ")
        ));
    };
    descriptors::ensure(1)?;
    let filter = if args.parent.is_some() { QUIET } else { TALKING };
    let terminal = Terminal::start(args.log_format, filter, Patience::Drops);
    let stop = Stop::on_signals().into_diagnostic()?;
    signals::end_on_the_second().into_diagnostic()?;
    let options = ServeOptions { once: args.once, parent: args.parent, stop: Some(stop) };
    if args.parent.is_none() && args.log_format == LogFormat::Text {
        let (name, instance) = (&args.name, args.instance.name());
        terminal.say(&format!("{name} serves instance {instance}; Ctrl-C ends it"));
    }
    serve(&args.instance, &args.name, motion::simulated(&spec.kind), options).into_diagnostic()?;
    Ok(Exit::Done)
}
