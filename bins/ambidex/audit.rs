//! `ambidex audit`: what must hold in every run, looked at in a log.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};

use ambidex::files;
use ambidex::record::audit::{Audit, AuditReport, OwnRecords};
use ambidex::record::{Reader, shown};
use ambidex::show::audit;
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr};

use crate::exit::Exit;
use crate::log;
use crate::page::Page;

/// `ambidex audit`.
#[derive(Debug, Args)]
#[command(after_help = "\
LOG is a file or the name of an instance. Left out, it is the newest log there.

The auditor folds the records by itself: it shares neither the state nor the rules of what
decided. With the records that controllers wrote themselves (`ambidex controller NAME --record
FOLDER/NAME.jsonl`) it looks at these too. That every decision follows from what was told is
another question, which `ambidex verify` answers.

Exit codes: 0 all holds, 1 something does not, 2 the log or a record cannot be read.")]
pub struct AuditArgs {
    /// The log: a file or an instance.
    pub log: Option<String>,
    /// The folder with the controllers' own records, each NAME.jsonl.
    #[arg(long, value_name = "FOLDER")]
    pub records: Option<PathBuf>,
    /// Print one object on stdout, and nothing else there.
    #[arg(long)]
    pub json: bool,
}

/// Looks at a log, and says what does not hold.
pub fn audit(args: &AuditArgs) -> Result<Exit> {
    let path = log::find(args.log.as_deref())?;
    let report = look(&path, args.records.as_deref(), true)?;
    let has_records = args.records.is_some();
    Page::new().tell(args.json, &report, |report, width, palette| audit::text(report, has_records, width, palette))?;
    Ok(if report.findings.is_empty() { Exit::Done } else { Exit::Failed })
}

/// What an audit of a log comes to; `is_whole` unless it is known to lack something.
///
/// # Errors
/// When the log or a record cannot be read.
pub fn look(path: &Path, records: Option<&Path>, is_whole: bool) -> Result<AuditReport> {
    let own = records.map(own_records).transpose()?;
    let mut reader = Reader::open(path).into_diagnostic()?;
    // Of a log without its files, or with those of another version, goals cannot be looked at.
    let source = reader.header().source.as_ref();
    let mission = source.and_then(|source| files::load_source(source).ok()).map(|loaded| loaded.mission);
    let mut audit = Audit::new(reader.header(), mission);
    for record in reader.by_ref() {
        audit.take(&record.into_diagnostic()?);
    }
    Ok(audit.finish(own.as_ref(), is_whole && !reader.is_truncated()))
}

fn own_records(folder: &Path) -> Result<OwnRecords> {
    let cannot = || format!("cannot read the records in {}", shown(folder));
    let mut own = OwnRecords::default();
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).into_diagnostic().wrap_err_with(cannot)? {
        let path = entry.into_diagnostic().wrap_err_with(cannot)?.path();
        if path.extension().is_some_and(|extension| extension == "jsonl") {
            files.push(path);
        }
    }
    files.sort();
    for path in files {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let cannot = || format!("{} is no controller's own record", shown(&path));
        let file = File::open(&path).into_diagnostic().wrap_err_with(cannot)?;
        own.read(&name, BufReader::new(file)).into_diagnostic().wrap_err_with(cannot)?;
    }
    Ok(own)
}
