//! Follows a run: log file, tracing events, live display, and the report.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use ambidex::model::{ControllerId, ControllerMessage, Loss, MissionEnd, MissionSpec, Names, Record, Rejection};
use ambidex::record::{History, JournalError, Presence, shown};
use ambidex::runtime::log::{self, JournalFile};
use ambidex::show::{live, timeline};

use crate::args::MissionArgs;
use crate::purpose::Purpose;
use crate::terminal::Terminal;

/// How often the live display is drawn anew at most.
const REDRAW: Duration = Duration::from_millis(100);

/// How long the report may wait for a reader.
const PRINT_WITHIN: Duration = Duration::from_secs(2);

/// Takes every record of a run.
pub struct Observer {
    names: Names,
    file: JournalFile,
    failure: Option<JournalError>,
    /// None before the first record.
    history: Option<History>,
    terminal: Terminal,
    is_quiet: bool,
    is_json: bool,
    drawn: Option<Instant>,
    is_stale: bool,
    /// Whether controllers are awaited; they are there from the beginning where they are only simulated.
    is_live: bool,
    /// What is told of what goes wrong on purpose.
    pub purpose: Purpose,
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
        let default = || {
            log::make_room(instance, args.keep_logs as usize);
            log::default_path(instance)
        };
        let path: PathBuf = args.log.clone().unwrap_or_else(default);
        let names = mission.names.clone();
        Ok(Self { is_live, ..Self::on(JournalFile::create(path)?, names, args, terminal) })
    }

    /// Goes on with a log, of which the history is known; controllers are awaited.
    pub fn resume(file: JournalFile, history: History, args: &MissionArgs, terminal: &Terminal) -> Self {
        let names = history.names().clone();
        Self { history: Some(history), ..Self::on(file, names, args, terminal) }
    }

    fn on(file: JournalFile, names: Names, args: &MissionArgs, terminal: &Terminal) -> Self {
        Self {
            names,
            file,
            failure: None,
            history: None,
            terminal: terminal.clone(),
            is_quiet: args.quiet,
            is_json: args.json,
            drawn: None,
            is_stale: false,
            is_live: true,
            purpose: Purpose::default(),
        }
    }

    /// Takes the next record.
    pub fn take(&mut self, record: &Record) {
        if let Some(disk) = self.purpose.disk(record) {
            self.file.set_disk(disk);
        }
        if self.failure.is_none()
            && let Err(error) = self.file.write(record)
        {
            self.fail(error);
        }
        log::emit(record, &self.names);
        match (&mut self.history, record) {
            (Some(history), record) => history.apply(record),
            (history, Record::Header(header)) => *history = Some(History::with_past(header)),
            (None, _) => {}
        }
        if self.is_quiet {
            return;
        }
        self.purpose.before(record).iter().for_each(|line| self.terminal.say(line));
        if self.terminal.is_tty() {
            self.draw();
        } else if let Some(line) = self.line(record) {
            self.terminal.say(&line);
            self.say_who_is_missing(record);
        }
        self.purpose.after(record, &self.names).iter().for_each(|line| self.terminal.say(line));
    }

    /// The plain line for a record; simulated controllers are there from the beginning, which is no news.
    fn line(&self, record: &Record) -> Option<String> {
        let is_attached = matches!(record, Record::Controller { message: ControllerMessage::Attached, .. });
        // That not all attached is told once, in the end.
        let is_told_later = matches!(record, Record::Ended { end: MissionEnd::NotAttached, .. });
        let is_news = (self.is_live || !is_attached) && !is_told_later;
        live::line(self.history.as_ref().filter(|_| is_news)?, record)
    }

    /// Nothing waits: what was taken so far is safe from now on. When to draw what came since the last drawing.
    pub fn rest(&mut self) -> Option<Duration> {
        if self.failure.is_none()
            && let Err(error) = self.file.flush()
        {
            self.fail(error);
        }
        if self.is_stale && self.terminal.is_tty() && !self.is_quiet {
            self.draw();
        }
        self.is_stale.then_some(REDRAW)
    }

    fn fail(&mut self, error: JournalError) {
        let source = std::error::Error::source(&error).map(|source| format!(": {source}")).unwrap_or_default();
        self.terminal.say(&format!("error: the log is incomplete from here on: {error}{source}"));
        self.failure = Some(error);
    }

    /// Names the controllers without which the mission does not begin.
    pub fn say_what_it_waits_for(&self) {
        let is_missing = |controller: ControllerId| {
            let view = self.history.as_ref().and_then(|history| history.controllers().view(controller));
            view.is_none_or(|view| view.presence == Presence::Lost)
        };
        let controllers = (0..self.names.controllers.len()).map(ControllerId::from);
        let missing: Vec<&str> = controllers.filter(|id| is_missing(*id)).map(|id| self.names.controller(id)).collect();
        if self.is_live && !self.is_quiet && !missing.is_empty() {
            self.terminal.say(&format!("waiting for {}", missing.join(", ")));
        }
    }

    /// Where no live display shows it: who is missing after one more has come or gone.
    fn say_who_is_missing(&self, record: &Record) {
        let Record::Controller { message, .. } = record else { return };
        let has_begun = self.history.as_ref().is_some_and(|history| history.rounds() > 0);
        match message {
            ControllerMessage::Attached => self.say_what_it_waits_for(),
            ControllerMessage::Lost { .. } if !has_begun => self.say_what_it_waits_for(),
            ControllerMessage::Lost { .. }
            | ControllerMessage::Told { .. }
            | ControllerMessage::Joined { .. }
            | ControllerMessage::Heard { .. }
            | ControllerMessage::Refused { .. }
            | ControllerMessage::Misreported { .. } => {}
        }
    }

    /// How a controller was lost, if it was.
    pub fn lost(&self, controller: ControllerId) -> Option<Loss> {
        self.history.as_ref()?.lost(controller).map(|(_, why)| why)
    }

    /// Why something that a controller said was not used, the last time.
    pub fn refusal(&self, controller: ControllerId) -> Option<Rejection> {
        self.history.as_ref()?.controllers().refusal(controller)
    }

    /// Closes the log, clears the live display, and tells the end. False if the log is incomplete.
    pub fn finish(&mut self) -> bool {
        if self.failure.is_none()
            && let Err(error) = self.file.flush()
        {
            self.fail(error);
        }
        self.terminal.clear();
        let (width, palette) = (self.terminal.width(), self.terminal.palette());
        let has_begun = |history: &&History| history.end() != Some(MissionEnd::NotAttached);
        if let Some(history) = self.history.as_ref().filter(has_begun) {
            if !self.is_quiet && history.step_count() > 0 {
                self.terminal.say(&format!("\n{}", timeline::text(history, width, &palette)));
            }
            if !self.is_quiet || history.end() == Some(MissionEnd::Stalled) {
                self.terminal.say(&live::summary(history, width, &palette));
            }
        }
        if !self.is_quiet {
            self.terminal.say(&format!("log: {}", shown(self.file.path())));
        }
        if let Some(report) = self.history.as_ref().and_then(History::report).filter(|_| self.is_json) {
            let text = serde_json::to_string(&report).expect("a report is plain");
            if !print(text, PRINT_WITHIN) {
                self.terminal.say("error: nobody reads stdout; the report is not written");
            }
        }
        self.failure.is_none()
    }

    fn draw(&mut self) {
        self.is_stale = self.drawn.is_some_and(|drawn| drawn.elapsed() < REDRAW);
        if self.is_stale {
            return;
        }
        self.drawn = Some(Instant::now());
        if let Some(history) = &self.history {
            self.terminal.show(live::rows(history, self.terminal.width(), &self.terminal.palette()));
        }
    }
}

/// Prints a line on stdout from a thread of its own; false if nobody took it in time. A reader that has left is one.
fn print(text: String, within: Duration) -> bool {
    let (printed, is_printed) = mpsc::sync_channel(1);
    let print = move || {
        let mut out = io::stdout();
        // Who has gone does not want it.
        let _ = writeln!(out, "{text}").and_then(|()| out.flush());
        let _ = printed.try_send(());
    };
    thread::Builder::new().name("report".into()).spawn(print).is_ok_and(|_| is_printed.recv_timeout(within).is_ok())
}
