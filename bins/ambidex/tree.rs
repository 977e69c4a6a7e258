//! `ambidex tree`.

use std::path::{Path, PathBuf};

use ambidex::files::{self, Disk, Setting};
use ambidex::model::Header;
use ambidex::record::{History, JournalError, Reader};
use ambidex::show::tree as show;
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
    /// Tell the mission a value for one of its parameters; can be given for each.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<Setting>,
}

/// Draws a task tree.
pub fn tree(args: &TreeArgs) -> Result<Exit> {
    let path = log::find(Some(&args.mission)).unwrap_or_else(|_| PathBuf::from(&args.mission));
    out::spare(&path, args.output.as_deref())?;
    let (header, history) = load(&path, args.robot.as_deref(), &args.set)?;
    match &args.output {
        Some(output) => out::write(output, &show::picture(&header, history.as_ref()))?,
        None => {
            let mut page = Page::new();
            let text = show::text(&header, history.as_ref(), page.width(), &page.palette());
            page.text(&text)?;
        }
    }
    Ok(Exit::Done)
}

/// The content decides: what begins with a header is a log, anything else is told as a mission what is wrong with it.
fn load(path: &Path, robot: Option<&Path>, settings: &[Setting]) -> Result<(Header, Option<History>)> {
    let reader = match Reader::open(path) {
        Ok(reader) => reader,
        Err(JournalError::NoHeader { .. } | JournalError::Open { .. }) => {
            let loaded = files::load_mission(&Disk, path, robot, settings).map_err(|error| report_all(&error))?;
            // What nobody sees: a tree is the same under every allocator.
            return Ok((Header::new(&loaded.mission, "", false), None));
        }
        Err(error) => return Err(error).into_diagnostic(),
    };
    let history = History::new(reader.header());
    let history = log::folded(reader, history, History::apply)?;
    Ok((history.header().clone(), Some(history)))
}
