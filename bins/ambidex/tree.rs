//! `ambidex tree`.

use std::path::{Path, PathBuf};

use ambidex::files::{self, Disk};
use ambidex::model::{Header, Tally};
use ambidex::record::{JournalError, Reader};
use ambidex::show;
use clap::Args;
use miette::{IntoDiagnostic, Result};

use crate::diagnostics::report_all;
use crate::exit::Exit;
use crate::page::Page;
use crate::{log, out};

/// `ambidex tree`.
#[derive(Debug, Args)]
pub struct TreeArgs {
    /// A mission file; or a log, or the name of an instance that left one: then with the state of every behavior.
    #[arg(value_name = "MISSION|LOG")]
    pub mission: String,
    /// Draw an SVG picture into this file; - is stdout. Without it the tree is printed as text.
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Use this robot file instead of the one that the mission names.
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
}

/// Draws a task tree.
pub fn tree(args: &TreeArgs) -> Result<Exit> {
    let path = log::find(Some(&args.mission)).unwrap_or_else(|_| PathBuf::from(&args.mission));
    out::spare(&path, args.output.as_deref())?;
    let (header, tally) = load(&path, args.robot.as_deref())?;
    match &args.output {
        Some(output) => out::write(output, &show::svg::tree(&header, tally.as_ref()))?,
        None => {
            let mut page = Page::new();
            let text = show::tree(&header, tally.as_ref(), page.width(), &page.palette());
            page.text(&text)?;
        }
    }
    Ok(Exit::Done)
}

/// The content decides: what begins with a header is a log, anything else is told as a mission what is wrong with it.
fn load(path: &Path, robot: Option<&Path>) -> Result<(Header, Option<Tally>)> {
    let reader = match Reader::open(path) {
        Ok(reader) => reader,
        Err(JournalError::NoHeader { .. } | JournalError::Open { .. }) => {
            let loaded = files::load_mission(&Disk, path, robot).map_err(|error| report_all(&error))?;
            // What nobody sees: a tree is the same under every allocator.
            return Ok((Header::new(&loaded.mission, ""), None));
        }
        Err(error) => return Err(error).into_diagnostic(),
    };
    let header = reader.header().clone();
    let mut tally = Tally::default();
    log::read(reader, |record| {
        tally.add(record);
        Ok(true)
    })?;
    Ok((header, Some(tally)))
}
