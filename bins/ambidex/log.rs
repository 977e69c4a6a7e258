//! The log that a verb reads: found by its path, its instance, or by being the newest; and read to its end or cut.

use std::fs;
use std::io::{self, BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use ambidex::link::Instance;
use ambidex::model::Record;
use ambidex::record::{Reader, shown};
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
        let (at, newest) = newest().ok_or_else(|| miette!("no run has left a log in {}", shown(&folder())))?;
        say(&format!("log: {}, {}: {}", mission(&newest), ago(at), shown(&newest)));
        return Ok(newest);
    };
    let file = PathBuf::from(log);
    if file.exists() {
        return Ok(file);
    }
    match of_instance(log) {
        Some(of_instance) if of_instance.exists() => Ok(of_instance),
        Some(of_instance) => Err(miette!("there is no log `{log}`: neither that file nor {}", shown(&of_instance))),
        None => Err(miette!("there is no log `{}`", shown(&file))),
    }
}

/// Where a log will lie that somebody has yet to begin.
pub fn place(log: Option<&str>) -> Result<PathBuf> {
    let is_file = |log: &str| log.contains(['/', '.']) || Path::new(log).exists();
    match log {
        None => find(None),
        Some(log) if is_file(log) => Ok(PathBuf::from(log)),
        Some(log) => of_instance(log)
            .ok_or_else(|| miette!("`{}` is neither a file nor the name of an instance", shown(Path::new(log)))),
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
        say(&format!("the log was cut off in its last line; {count} records read"));
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

/// What the log is about, where it can be read.
fn mission(log: &Path) -> String {
    Reader::open(log).map_or("no log that can be read".into(), |reader| reader.header().mission.clone())
}

/// How long ago something was written: "written 12 minutes ago".
fn ago(at: SystemTime) -> String {
    let seconds = at.elapsed().unwrap_or_default().as_secs();
    let (number, unit) = match seconds {
        0..60 => return "written just now".into(),
        60..3_600 => (seconds / 60, "minute"),
        3_600..86_400 => (seconds / 3_600, "hour"),
        _ => (seconds / 86_400, "day"),
    };
    format!("written {number} {unit}{} ago", if number == 1 { "" } else { "s" })
}

/// Says something on stderr, where perhaps nobody listens.
pub fn say(text: &str) {
    drop(writeln!(io::stderr(), "{text}"));
}

fn newest() -> Option<(SystemTime, PathBuf)> {
    let logs = fs::read_dir(folder()).ok()?.flatten().map(|entry| entry.path().join(FILE));
    let dated = logs.filter_map(|log| Some((written(&log)?, log)));
    dated.max()
}

fn written(log: &Path) -> Option<SystemTime> {
    fs::metadata(log).and_then(|log| log.modified()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn it_is_said_how_old_a_log_is() {
        let check = |seconds: u64, expected: &str| {
            assert_eq!(ago(SystemTime::now() - Duration::from_secs(seconds)), expected);
        };
        check(5, "written just now");
        check(70, "written 1 minute ago");
        check(725, "written 12 minutes ago");
        check(2 * 3_600 + 5, "written 2 hours ago");
        check(90_000, "written 1 day ago");
    }
}
