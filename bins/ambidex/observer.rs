//! Follows a run: log file, tracing events, live display, and the tally for the report.

use std::io::{self, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use ambidex::model::{ControllerMessage, MissionEnd, MissionSpec, Record, Tally};
use ambidex::record::JournalError;
use ambidex::runtime::log::{self, JournalFile};
use ambidex::show::{self, Progress};

use crate::args::MissionArgs;
use crate::terminal::Terminal;

/// How often the live display is drawn anew at most.
pub const REDRAW: Duration = Duration::from_millis(100);

/// Takes every record of a run.
pub struct Observer {
    names: ambidex::model::Names,
    file: JournalFile,
    failure: Option<JournalError>,
    progress: Progress,
    terminal: Terminal,
    is_quiet: bool,
    is_json: bool,
    drawn: Option<Instant>,
    is_stale: bool,
    /// Controllers that are awaited; none where they are only simulated.
    missing: Option<Vec<String>>,
}

impl Observer {
    /// Opens the log and takes hold of the terminal; `is_live` where controllers are awaited.
    ///
    /// # Errors
    /// When the log cannot be made.
    pub fn new(
        mission: &MissionSpec,
        args: &MissionArgs,
        instance: &str,
        terminal: &Terminal,
        is_live: bool,
    ) -> Result<Self, JournalError> {
        let default = || log::default_path(instance);
        let path: PathBuf = args.log.clone().unwrap_or_else(default);
        Ok(Self {
            names: mission.names.clone(),
            file: JournalFile::create(path)?,
            failure: None,
            progress: Progress::default(),
            terminal: terminal.clone(),
            is_quiet: args.quiet,
            is_json: args.json,
            drawn: None,
            is_stale: false,
            missing: is_live.then(|| mission.names.controllers.clone()),
        })
    }

    /// Takes the next record.
    pub fn take(&mut self, record: &Record) {
        if self.failure.is_none()
            && let Err(error) = self.file.write(record)
        {
            self.fail(error);
        }
        log::emit(record, &self.names);
        self.progress.add(record);
        if self.is_quiet {
            return;
        }
        if self.terminal.is_tty() {
            self.draw();
        } else if let Some(line) = self.progress.plain_line(record).filter(|_| self.is_news(record)) {
            self.terminal.say(&line);
            self.say_who_is_missing(record);
        }
    }

    /// Simulated controllers are there from the beginning.
    fn is_news(&self, record: &Record) -> bool {
        let is_attached = matches!(record, Record::Controller { message: ControllerMessage::Attached, .. });
        self.missing.is_some() || !is_attached
    }

    /// Nothing waits: what was taken so far is safe from now on.
    pub fn rest(&mut self) {
        if self.failure.is_none()
            && let Err(error) = self.file.flush()
        {
            self.fail(error);
        }
    }

    /// Draws what came since the last drawing.
    pub fn refresh(&mut self) {
        if self.is_stale && self.terminal.is_tty() && !self.is_quiet {
            self.draw();
        }
    }

    fn fail(&mut self, error: JournalError) {
        self.terminal.say(&format!("error: the log is incomplete: {error}"));
        self.failure = Some(error);
    }

    /// Names the controllers without which the mission does not begin.
    pub fn say_what_it_waits_for(&self) {
        if let Some(missing) = self.missing.as_ref().filter(|missing| !self.is_quiet && !missing.is_empty()) {
            self.terminal.say(&format!("waiting for {}", missing.join(", ")));
        }
    }

    /// Where no live display shows it: who is missing after one more has come or gone.
    fn say_who_is_missing(&mut self, record: &Record) {
        let Record::Controller { controller, message, .. } = record else {
            return;
        };
        let has_begun = self.tally().rounds > 0;
        let name = self.names.controller(*controller).to_owned();
        let Some(awaited) = &mut self.missing else { return };
        match message {
            ControllerMessage::Attached => awaited.retain(|missing| *missing != name),
            ControllerMessage::Lost { .. } if !has_begun => awaited.push(name),
            ControllerMessage::Lost { .. }
            | ControllerMessage::Told { .. }
            | ControllerMessage::Joined { .. }
            | ControllerMessage::Heard { .. }
            | ControllerMessage::Refused { .. } => return,
        }
        self.say_what_it_waits_for();
    }

    /// What is known so far.
    pub fn tally(&self) -> &Tally {
        self.progress.tally()
    }

    /// Closes the log, clears the live display, and tells the end.
    pub fn finish(&mut self) -> io::Result<()> {
        let flushed = self.file.flush();
        self.terminal.clear();
        let (width, palette) = (self.terminal.width(), self.terminal.palette());
        let tally = self.tally();
        if !self.is_quiet && !tally.intervals.is_empty() {
            self.terminal.say(&format!("\n{}", show::timing(tally, width, &palette)));
        }
        if !self.is_quiet || tally.end == Some(MissionEnd::Stalled) {
            self.terminal.say(&show::summary(tally, width, &palette));
        }
        if !self.is_quiet {
            self.terminal.say(&format!("log: {}", self.file.path().display()));
        }
        if let Some(report) = tally.report().filter(|_| self.is_json) {
            writeln!(io::stdout(), "{}", serde_json::to_string(&report).map_err(io::Error::other)?)?;
        }
        flushed.map_err(io::Error::other)
    }

    fn draw(&mut self) {
        self.is_stale = self.drawn.is_some_and(|drawn| drawn.elapsed() < REDRAW);
        if self.is_stale {
            return;
        }
        self.drawn = Some(Instant::now());
        let lines = self.progress.lines(self.terminal.width(), &self.terminal.palette());
        self.terminal.show(&lines);
    }
}
