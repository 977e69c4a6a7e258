//! `ambidex controller`.

use ambidex::config;
use ambidex::controller::{ServeOptions, Stop, serve};
use ambidex::motion;
use miette::{IntoDiagnostic, Result, miette};

use crate::args::ControllerArgs;
use crate::exit::Exit;
use crate::terminal::Terminal;

/// Serves one simulated controller until it is told to stop.
pub fn controller(args: &ControllerArgs) -> Result<Exit> {
    let file = config::load_robot(&args.robot)?;
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
    Terminal::start(args.log_format);
    let stop = Stop::on_signals().into_diagnostic()?;
    let options = ServeOptions { once: args.once, parent: args.parent, stop: Some(stop) };
    serve(&args.instance, &args.name, motion::simulated(&spec.kind), options).into_diagnostic()?;
    Ok(Exit::Done)
}
