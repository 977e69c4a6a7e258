//! Follows a run: log file, tracing events, live display, and the tally for the report.

use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use ambidex::draw::{self, Progress};
use ambidex::journal::{self, JournalError, JournalFile};
use ambidex::model::{MissionSpec, Record, Tally};

use crate::args::MissionArgs;
use crate::terminal::Terminal;

/// How often the live display is drawn anew at most.
const REDRAW: Duration = Duration::from_millis(100);

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
}

impl Observer {
    /// Opens the log and takes hold of the terminal.
    ///
    /// # Errors
    /// When the log cannot be made.
    pub fn new(
        mission: &MissionSpec,
        args: &MissionArgs,
        instance: &str,
        terminal: &Terminal,
    ) -> Result<Self, JournalError> {
        let default = || journal::default_folder(instance).join("journal.jsonl");
        let path: PathBuf = args.log.clone().unwrap_or_else(default);
        Ok(Self {
            names: mission.names.clone(),
            file: JournalFile::create(path)?,
            failure: None,
            progress: Progress::new(&mission.robot),
            terminal: terminal.clone(),
            is_quiet: args.quiet,
            is_json: args.json,
            drawn: None,
        })
    }

    /// Takes the next record.
    pub fn take(&mut self, record: &Record) {
        if self.failure.is_none()
            && let Err(error) = self.file.write(record)
        {
            self.terminal.say(&format!("error: the log is incomplete: {error}"));
            self.failure = Some(error);
        }
        journal::emit(record, &self.names);
        self.progress.add(record);
        if self.is_quiet {
            return;
        }
        if self.terminal.is_tty() {
            self.draw();
        } else if let Some(line) = self.progress.plain_line(record) {
            eprintln!("{line}");
        }
    }

    /// Names the controllers without which the mission does not begin.
    pub fn say_what_it_waits_for(&self, mission: &MissionSpec) {
        if !self.is_quiet {
            self.terminal.say(&format!("waiting for {}", mission.names.controllers.join(", ")));
        }
    }

    /// What is known so far.
    pub fn tally(&self) -> &Tally {
        self.progress.tally()
    }

    /// Closes the log, clears the live display, and tells the end.
    pub fn finish(&mut self) -> io::Result<()> {
        let flushed = self.file.flush();
        self.terminal.clear();
        if !self.is_quiet {
            self.tell();
        }
        if let Some(report) = self.tally().report().filter(|_| self.is_json) {
            println!("{}", serde_json::to_string(&report).map_err(io::Error::other)?);
        }
        flushed.map_err(io::Error::other)
    }

    fn tell(&self) {
        let (width, palette) = (self.terminal.width(), self.terminal.palette());
        eprintln!("\n{}", draw::timing(self.tally(), width, &palette));
        eprintln!("{}", draw::summary(self.tally(), width, &palette));
        eprintln!("log: {}", self.file.path().display());
    }

    fn draw(&mut self) {
        if self.drawn.is_some_and(|drawn| drawn.elapsed() < REDRAW) {
            return;
        }
        self.drawn = Some(Instant::now());
        let lines = self.progress.lines(self.terminal.width(), &self.terminal.palette());
        self.terminal.show(&lines);
    }
}
