//! `ambidex timeline`.

use std::path::{Path, PathBuf};

use ambidex::draw;
use ambidex::draw::svg::{self, History};
use clap::Args;
use miette::{IntoDiagnostic, Result};

use crate::exit::Exit;
use crate::{log, out};

/// `ambidex timeline`.
#[derive(Debug, Args)]
pub struct TimelineArgs {
    /// The log of a run, or the name of the instance that left it, as `simulate`.
    pub log: String,
    /// Draw a second run below the first, on the same axis.
    #[arg(long, value_name = "LOG2")]
    pub compare: Option<String>,
    /// Draw an SVG picture into this file; - is stdout. Without it the diagram is printed as text.
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Draws one run or two.
pub fn timeline(args: &TimelineArgs) -> Result<Exit> {
    let logs: Vec<PathBuf> =
        [Some(&args.log), args.compare.as_ref()].into_iter().flatten().map(|log| log::path(log)).collect();
    logs.iter().try_for_each(|log| out::spare(log, args.output.as_deref()))?;
    let runs: Vec<History> = logs.iter().map(|log| read(log)).collect::<Result<_>>()?;
    match &args.output {
        Some(output) => out::write(output, &picture(&runs))?,
        None => out::print(&text(&runs))?,
    }
    Ok(Exit::Done)
}

fn read(log: &Path) -> Result<History> {
    let mut history = History::default();
    log::read(log, |record| history.add(record)).into_diagnostic()?;
    Ok(history)
}

fn picture(runs: &[History]) -> String {
    match runs {
        [upper, lower] => svg::compare(upper, lower),
        [run, ..] => svg::timeline(run),
        [] => String::new(),
    }
}

fn text(runs: &[History]) -> String {
    let (width, palette) = (out::width(), out::palette());
    let diagrams = runs.iter().map(|run| draw::timing(run.tally(), width, &palette));
    diagrams.collect::<Vec<_>>().join("\n")
}
