//! `ambidex verify`: every decision of a log computed again.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ambidex::files;
use ambidex::model::state::Saved;
use ambidex::model::{Header, MissionSpec, Record};
use ambidex::record::{Reader, shown};
use ambidex::replay::{Difference, Replay};
use ambidex::show::conversation::{Conversation, Filters, Selection};
use ambidex::tree::Settings;
use clap::{Args, ValueEnum};
use miette::{IntoDiagnostic, Report, Result, miette};

use crate::args::AllocatorName;
use crate::diagnostics::report_all;
use crate::exit::Exit;
use crate::log;
use crate::page::Page;
use crate::reading::FileReader;

/// `ambidex verify`.
#[derive(Debug, Args)]
#[command(after_help = "\
LOG is a file or the name of an instance. Left out, it is the newest log there.

A log carries the files that its mission was made of, and all that root was told. From these every decision is computed
again: with the same version of this program it is the same, wherever and however fast it runs. Messages between nodes
and what controllers said are not compared: they have the order of the machine.

Exit codes: 0 the same, 1 a record differs, 2 the log cannot be read, or was written without its files.")]
pub struct VerifyArgs {
    /// The log: a file or an instance.
    pub log: Option<String>,
}

/// A log's mission and how it was run.
pub struct Rerun {
    pub mission: Arc<MissionSpec>,
    /// Where its robot stands among the files of the log.
    pub robot_path: PathBuf,
    pub settings: Settings,
}

/// Computes every decision of a log again.
pub fn verify(args: &VerifyArgs) -> Result<Exit> {
    let path = log::find(args.log.as_deref())?;
    let mut page = Page::new();
    match again(&path)? {
        Again::Different { difference, line, header } => {
            let said = said_until(&path, &header, line)?;
            page.text(&told(&difference, line, &said, &page.palette()))?;
            Ok(Exit::Failed)
        }
        Again::Same { decisions, records, is_truncated } => {
            let cut = if is_truncated { "; its last line was cut off" } else { "" };
            page.text(&format!("same: {decisions} decisions computed again from {records} records{cut}\n"))?;
            Ok(Exit::Done)
        }
    }
}

/// What comes of deciding all of a log again.
pub enum Again {
    /// All is the same.
    Same { decisions: u64, records: u64, is_truncated: bool },
    /// A line is not what follows from those before it.
    Different { difference: Difference, line: u64, header: Box<Header> },
}

/// Decides all of a log again.
///
/// # Errors
/// When it cannot be read, or was written without its files.
pub fn again(path: &Path) -> Result<Again> {
    let mut reader = Reader::open(path).into_diagnostic()?;
    let Rerun { mission, settings, .. } = rerun(reader.header(), path)?;
    let mut replay = reading(Replay::new(&mission, &settings), &mission)?;
    let mut records = 0_u64;
    for record in reader.by_ref() {
        let record = record.into_diagnostic()?;
        records += 1;
        if let Err(difference) = follow(&mut replay, &record) {
            let header = Box::new(reader.header().clone());
            return Ok(Again::Different { difference, line: records, header });
        }
    }
    Ok(Again::Same { decisions: replay.decisions(), records, is_truncated: reader.is_truncated() })
}

/// The log as a conversation up to a line, in which that line can be told.
fn said_until(path: &Path, header: &Header, line: u64) -> Result<Conversation> {
    let selection = Selection::new(&Filters::default(), header).map_err(|error| log::unknown(&error))?;
    let mut said = Conversation::new(header, selection);
    for (_, record) in (0..line).zip(Reader::open(path).into_diagnostic()?) {
        said.take(&record.into_diagnostic()?);
    }
    Ok(said)
}

/// The mission of a log, made again of the files that the log carries.
///
/// # Errors
/// When it carries none, or none that this version of the program takes.
pub fn rerun(header: &Header, path: &Path) -> Result<Rerun> {
    let source = header.source.as_ref();
    let source = source.ok_or_else(|| miette!("the log {} does not carry the files of its mission", shown(path)))?;
    let loaded = files::load_source(source).map_err(|error| report_all(&error))?;
    let unknown = |_| miette!("the log {} was made with the allocator `{}`", shown(path), header.allocator);
    let allocator = AllocatorName::from_str(&header.allocator, false).map_err(unknown)?;
    let settings = Settings::of(header, allocator.allocator());
    Ok(Rerun { mission: loaded.mission, robot_path: loaded.robot_path, settings })
}

/// A replay that reads what was submitted.
///
/// # Errors
/// When the files of its world cannot be read any more.
pub fn reading(replay: Replay, mission: &MissionSpec) -> Result<Replay> {
    Ok(match FileReader::again(mission)? {
        Some(reader) => replay.reading(reader),
        None => replay,
    })
}

/// Takes the next record, with which the log may go on where another was put aside.
///
/// # Errors
/// When it does not follow from those before it.
pub fn follow(replay: &mut Replay, record: &Record) -> Result<(), Difference> {
    if let Record::Checkpoint { saved, .. } = record {
        let saved = serde_json::from_str::<Saved>(saved).ok();
        if saved.is_none_or(|saved| replay.restore(&saved).is_err()) {
            return Err(Difference { found: Some(Box::new(record.clone())), expected: None });
        }
    }
    replay.take(record)
}

/// A difference as an error, for verbs that need a log without one.
pub fn differs(difference: &Difference, line: u64) -> Report {
    miette!(
        help = "`ambidex verify` shows the difference",
        "line {line} of the log does not follow from what stands before it{}",
        if difference.found.is_none() { ": something is missing" } else { "" }
    )
}

/// Where the log and what follows part.
fn told(difference: &Difference, line: u64, said: &Conversation, palette: &ambidex::show::Palette) -> String {
    let line_of = |record: &Option<Box<Record>>| match record {
        Some(record) => said.line(record, palette).trim_end().to_owned(),
        None => "nothing".to_owned(),
    };
    let (mut found, mut expected) = (line_of(&difference.found), line_of(&difference.expected));
    if found == expected {
        let json = |record: &Option<Box<Record>>| serde_json::to_string(record).unwrap_or_default();
        (found, expected) = (json(&difference.found), json(&difference.expected));
    }
    if difference.found.is_none() {
        found = "goes on with the next turn".to_owned();
    }
    format!("different at line {line}\n  the log:  {found}\n  computed: {expected}\n")
}
