//! `--resume`: a run that goes on in its log.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use ambidex::files;
use ambidex::link::Instance;
use ambidex::model::{Record, Source};
use ambidex::record::{Beginning, History, JournalError, Reader, shown};
use ambidex::replay::{Replay, Resumed};
use ambidex::runtime::log::{JournalFile, default_path};
use miette::{Context, IntoDiagnostic, Result, miette};

use crate::args::{LiveArgs, MissionArgs};
use crate::log;
use crate::mission::loaded;
use crate::observer::of_run;
use crate::verify::{Rerun, differs, follow, reading, rerun};

/// A run as its log leaves it.
pub struct Resume {
    pub rerun: Rerun,
    pub resumed: Resumed,
    /// The log, in which it goes on.
    pub file: JournalFile,
    /// What the log comes to.
    pub history: History,
    /// What another log of this run would begin with.
    pub beginning: Beginning,
}

/// The robot file of a log, beside the log for controllers to read it; gone when this is dropped.
pub struct RobotFile(PathBuf);

/// Reads a log, compares all its decisions, and cuts it where its writer was killed in the middle of a line. A mission
/// that is given must be that of the log.
///
/// # Errors
/// When the log cannot be read, does not carry its files, is being written, or is of another mission.
pub fn resume(log: &str, live: &LiveArgs, args: &MissionArgs) -> Result<Resume> {
    let path = log::find(Some(log))?;
    let given = live.mission.as_deref().or(live.world.as_deref());
    if given.is_none() && (args.robot.is_some() || !args.set.is_empty()) {
        return Err(miette!(
            help = "name the mission too, and it is compared with that of the log with these",
            "--robot and --set say nothing of a run that goes on: it has the robot and the values of its log"
        ));
    }
    let mut file = JournalFile::reopen(&path).into_diagnostic()?;
    let opened = Reader::open(&path);
    if let Err(JournalError::NoHeader { .. }) = &opened
        && std::fs::read(&path).is_ok_and(|text| !text.contains(&b'\n'))
    {
        return Err(miette!(
            help = "run the mission anew",
            "{} does not even have a first line: nothing had happened yet",
            shown(&path)
        ));
    }
    let mut reader = opened.into_diagnostic()?;
    let header = reader.header().clone();
    let rerun = rerun(&header, &path)?;
    if let Some(path) = given {
        let given = loaded(live, args)?.mission;
        compare(rerun.mission.source.as_ref(), given.source.as_ref(), path)?;
    }
    let mut replay = reading(Replay::new(&rerun.mission, &rerun.settings), &rerun.mission)?;
    let (mut history, mut beginning) = (of_run(&header), Beginning::default());
    for (line, record) in (1..).zip(reader.by_ref()) {
        let record = record.into_diagnostic()?;
        follow(&mut replay, &record).map_err(|difference| differs(&difference, line))?;
        history.apply(&record);
        beginning.take(&record, &history);
    }
    let removed = file.cut(reader.whole_bytes()).into_diagnostic()?;
    if removed > 0 {
        log::say(&format!("the log was cut off in its last line; {removed} bytes of it are removed"));
    }
    let resumed = replay.finish();
    Ok(Resume { rerun, resumed, file, history, beginning })
}

/// The log of an instance's last run, or that of `--log`, if its runtime was gone before the mission had ended.
///
/// # Errors
/// When there is one, and it cannot be read.
pub fn unfinished(instance: &Instance, args: &MissionArgs) -> Result<Option<String>> {
    let path = args.log.clone().unwrap_or_else(|| default_path(instance.name()));
    let mut reader = match Reader::open(&path) {
        Ok(reader) => reader,
        Err(JournalError::Open { source, .. }) if source.kind() == ErrorKind::NotFound => return Ok(None),
        // Nothing had happened yet, or another version of the program wrote it, which says nothing of how it ended.
        Err(error @ (JournalError::NoHeader { .. } | JournalError::Version { .. })) => {
            log::say(&format!("the log of the last run is left alone: {error}"));
            return Ok(None);
        }
        Err(error) => return Err(error).into_diagnostic(),
    };
    let mut has_ended = false;
    for record in reader.by_ref() {
        has_ended |= matches!(record.into_diagnostic()?, Record::Ended { .. });
    }
    if has_ended {
        return Ok(None);
    }
    log::say(&format!("the last run did not end; it goes on in {}", shown(&path)));
    let path = path.into_os_string().into_string();
    path.map(Some).map_err(|path| miette!("{} is no path that can be told", shown(Path::new(&path))))
}

impl Resume {
    /// Writes the robot file of the log where controllers find it.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn robot_file(&self) -> Result<RobotFile> {
        let Rerun { mission, robot_path, .. } = &self.rerun;
        let text = mission.source.as_ref().and_then(|source| files::kept_text(source, robot_path)).unwrap_or_default();
        let path = self.file.path().with_extension("robot.yaml");
        let written = std::fs::write(&path, text).into_diagnostic();
        written
            .wrap_err_with(|| format!("cannot write {}, of which the controllers read their robot", shown(&path)))?;
        Ok(RobotFile(path))
    }
}

impl RobotFile {
    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for RobotFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Refuses a mission that is not that of the log.
fn compare(log: Option<&Source>, given: Option<&Source>, mission: &Path) -> Result<()> {
    let difference = log.zip(given).and_then(|(log, given)| files::difference(log, given));
    match difference {
        None => Ok(()),
        Some(difference) => Err(miette!(
            help = "leave the mission out to go on with that of the log, or run the new one with a log of its own",
            "{} is not the mission of the log: {difference}",
            shown(mission)
        )),
    }
}
