//! The log that a verb reads: found by its path, its instance, or by being the newest; and read to its end or cut.

use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use ambidex::link::Instance;
use ambidex::model::Record;
use ambidex::record::Reader;
use ambidex::runtime;
use ambidex::show::Unknown;
use miette::{IntoDiagnostic, Report, Result, miette};

/// What a log is called in its instance's folder.
const FILE: &str = "journal.jsonl";

/// What `--help` says of LOG.
pub const HELP: &str = "\
LOG is a file or the name of an instance, such as `simulate`, whose log lies in $XDG_STATE_HOME/ambidex/INSTANCE/.
Left out, it is the newest log there.

Exit codes: 0, or 2 for a log that cannot be read and for names that it does not have.";

/// Where the log lies.
///
/// # Errors
/// When there is neither such a file nor such an instance, or no log at all.
pub fn find(log: Option<&str>) -> Result<PathBuf> {
    let Some(log) = log else {
        let newest = newest().ok_or_else(|| miette!("no run has left a log in {}", folder().display()))?;
        eprintln!("log: {}", newest.display());
        return Ok(newest);
    };
    let file = PathBuf::from(log);
    if file.exists() {
        return Ok(file);
    }
    match of_instance(log) {
        Some(of_instance) if of_instance.exists() => Ok(of_instance),
        Some(of_instance) => Err(miette!("there is no log `{log}`: neither that file nor {}", of_instance.display())),
        None => Err(miette!("there is no log `{log}`")),
    }
}

/// Where a log will lie that somebody has yet to begin.
pub fn place(log: Option<&str>) -> Result<PathBuf> {
    let is_file = |log: &str| log.contains(['/', '.']) || Path::new(log).exists();
    match log {
        None => find(None),
        Some(log) if is_file(log) => Ok(PathBuf::from(log)),
        Some(log) => of_instance(log).ok_or_else(|| miette!("`{log}` is neither a file nor the name of an instance")),
    }
}

/// Hands every record to `take` until that wants no more; says if the log was cut off.
///
/// # Errors
/// When the log cannot be read, has another version, or `take` fails.
pub fn read(mut reader: Reader<BufReader<fs::File>>, mut take: impl FnMut(&Record) -> Result<bool>) -> Result<()> {
    let mut count = 0_u64;
    for record in reader.by_ref() {
        count += 1;
        if !take(&record.into_diagnostic()?)? {
            return Ok(());
        }
    }
    if reader.is_truncated() {
        eprintln!("the log was cut off in its last line; {count} records read");
    }
    Ok(())
}

/// What every record of a log comes to.
///
/// # Errors
/// When the log cannot be read or has another version.
pub fn folded<T>(reader: Reader<BufReader<fs::File>>, mut fold: T, add: impl Fn(&mut T, &Record)) -> Result<T> {
    read(reader, |record| {
        add(&mut fold, record);
        Ok(true)
    })?;
    Ok(fold)
}

/// A name that the log does not have, with what it has.
pub fn unknown(unknown: &Unknown) -> Report {
    miette!(help = unknown.help().to_owned(), "{unknown}")
}

fn of_instance(name: &str) -> Option<PathBuf> {
    Instance::new(name).ok().map(|instance| runtime::log::default_folder(instance.name()).join(FILE))
}

/// The folder of all instances.
fn folder() -> PathBuf {
    let mut folder = runtime::log::default_folder("any");
    folder.pop();
    folder
}

fn newest() -> Option<PathBuf> {
    let logs = fs::read_dir(folder()).ok()?.flatten().map(|entry| entry.path().join(FILE));
    let dated = logs.filter_map(|log| Some((written(&log)?, log)));
    dated.max().map(|(_, log)| log)
}

fn written(log: &Path) -> Option<SystemTime> {
    fs::metadata(log).and_then(|log| log.modified()).ok()
}
