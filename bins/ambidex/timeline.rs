//! `ambidex timeline`.

use std::path::{Path, PathBuf};

use ambidex::record::{History, Reader};
use ambidex::show::timeline as show;
use clap::Args;
use miette::{IntoDiagnostic, Result};

use crate::exit::Exit;
use crate::page::Page;
use crate::{log, out};

/// `ambidex timeline`.
#[derive(Debug, Args)]
#[command(after_help = log::HELP)]
pub struct TimelineArgs {
    /// The log of a run: a file or an instance.
    pub log: Option<String>,
    /// Draw a second run below the first, on the same axis.
    #[arg(long, value_name = "LOG2")]
    pub compare: Option<String>,
    /// Draw an SVG picture into this file; - is stdout. Without it the diagram is printed as text.
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Draws one run or two.
pub fn timeline(args: &TimelineArgs) -> Result<Exit> {
    let second = args.compare.iter().map(|log| log::find(Some(log)));
    let logs: Vec<PathBuf> = std::iter::once(log::find(args.log.as_deref())).chain(second).collect::<Result<_>>()?;
    logs.iter().try_for_each(|log| out::spare(log, args.output.as_deref()))?;
    let runs: Vec<History> = logs.iter().map(|log| read(log)).collect::<Result<_>>()?;
    match &args.output {
        Some(output) => out::write(output, &picture(&runs))?,
        None => drop(Page::new().text(&text(&runs))?),
    }
    Ok(Exit::Done)
}

fn read(log: &Path) -> Result<History> {
    let reader = Reader::open(log).into_diagnostic()?;
    let history = History::with_past(reader.header());
    log::folded(reader, history, History::apply)
}

fn picture(runs: &[History]) -> String {
    match runs {
        [upper, lower] => show::compare(upper, lower),
        [run, ..] => show::picture(run),
        [] => String::new(),
    }
}

fn text(runs: &[History]) -> String {
    let page = Page::new();
    let (width, palette) = (page.width(), page.palette());
    let diagrams = runs.iter().map(|run| show::text(run, width, &palette));
    diagrams.collect::<Vec<_>>().join("\n")
}
