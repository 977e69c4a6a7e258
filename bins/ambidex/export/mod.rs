//! `ambidex export`: a log for other programs.

mod form;

use std::path::PathBuf;
use std::time::Duration;

use ambidex::link::Stop;
use ambidex::record::Reader;
use ambidex::show::export::Table;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use miette::{Context, IntoDiagnostic, Result};
use strum::VariantArray;

use crate::exit::Exit;
use crate::out::{self, Output};
use crate::waiting::is_stopped;
use crate::{log, page};
use form::Form;

/// How many records may come between two looks for Ctrl-C.
const AT_ONCE: u64 = 256;

/// `ambidex export`.
#[derive(Debug, Args)]
#[command(after_help = log::HELP, group = ArgGroup::new("form").required(true).args(["chrome_trace", "csv", "mcap"]))]
pub struct ExportArgs {
    /// The log of a run: a file or an instance.
    pub log: Option<String>,
    /// Trace events as JSON, for Perfetto and chrome://tracing: a row per resource, controller and behavior; what root
    /// decided, what went wrong, and arrows from behaviors to their commands.
    #[arg(long)]
    pub chrome_trace: bool,
    /// A table with a row per attempt of a behavior; or, with a name, another one.
    #[arg(long, value_name = "TABLE", num_args = 0..=1, require_equals = true, default_missing_value = Table::Behaviors.word(), value_parser = tables())]
    pub csv: Option<Table>,
    /// An MCAP file, for Foxglove and other viewers: what `--record` writes while a mission runs.
    #[arg(long, requires = "output")]
    pub mcap: bool,
    /// Where it goes, in the place of what is there [default: stdout]; - is stdout.
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Writes a log in another form.
pub fn export(args: &ExportArgs) -> Result<Exit> {
    let path = log::find(args.log.as_deref())?;
    out::spare(&path, args.output.as_deref())?;
    let reader = Reader::open(&path).into_diagnostic()?;
    let output = Output::open(args.output.as_deref())?;
    // What is half-written must not be left beside the file that it was to be.
    let stop = if output.is_beside() { Some(Stop::on_signals().into_diagnostic()?) } else { None };
    let cannot = output.complaint();
    let mut form = match (args.chrome_trace, args.csv) {
        (true, _) => Form::trace(reader.header(), output)?,
        (false, Some(table)) => Form::table(table, reader.header(), output)?,
        (false, None) => Form::recording(reader.header(), &path, output)?,
    };
    let (mut count, mut is_over) = (0_u64, false);
    let mut is_read = true;
    log::read(reader, |record| {
        count += 1;
        is_read = page::is_read(form.take(record)).wrap_err_with(|| cannot.clone())?;
        is_over = match &stop {
            Some(stop) if count.is_multiple_of(AT_ONCE) => is_stopped(stop, Duration::ZERO)?,
            Some(_) | None => false,
        };
        Ok(is_read && !is_over)
    })?;
    if is_over {
        return Ok(Exit::Canceled);
    }
    if is_read {
        form.finish().wrap_err(cannot)?;
    }
    Ok(Exit::Done)
}

fn tables() -> impl TypedValueParser<Value = Table> {
    let words = Table::VARIANTS.iter().map(|table| table.word());
    PossibleValuesParser::new(words).map(|word| word.parse().expect("one of the words"))
}
