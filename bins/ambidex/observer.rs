//! Follows a run: log file, tracing events, live display, and the report.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use ambidex::http::Feed;
use ambidex::model::state::Saved;
use ambidex::model::{
    ControllerId, ControllerMessage, Header, Loss, MissionEnd, MissionSpec, Names, Record, Rejection, Time, Told,
};
use ambidex::record::{Beginning, History, JournalError, shown};
use ambidex::runtime::log::{self, JournalFile};
use ambidex::show::{live, timeline};

use crate::args::MissionArgs;
use crate::purpose::Purpose;
use crate::recording::Recorder;
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
    /// What another log of this run would begin with.
    beginning: Beginning,
    /// How long the log may be before it begins anew with what the run is, bytes.
    size: u64,
    limit: u64,
    keep_logs: usize,
    terminal: Terminal,
    is_quiet: bool,
    is_json: bool,
    drawn: Option<Instant>,
    is_stale: bool,
    /// Whether controllers are awaited; they are there from the beginning where they are only simulated.
    is_live: bool,
    /// What is told of what goes wrong on purpose.
    pub purpose: Purpose,
    /// What viewers read of the run, if that is wanted.
    pub recorder: Option<Recorder>,
    /// Whether there is less in the recording than there should be.
    is_recording_incomplete: bool,
    /// Where others are told of what is written.
    pub feed: Option<Feed>,
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
    pub fn resume(
        file: JournalFile,
        (history, beginning): (History, Beginning),
        args: &MissionArgs,
        terminal: &Terminal,
    ) -> Self {
        let names = history.names().clone();
        Self { history: Some(history), beginning, ..Self::on(file, names, args, terminal) }
    }

    fn on(file: JournalFile, names: Names, args: &MissionArgs, terminal: &Terminal) -> Self {
        Self {
            names,
            file,
            failure: None,
            history: None,
            beginning: Beginning::default(),
            size: args.log_size,
            limit: args.log_size,
            keep_logs: args.keep_logs as usize,
            terminal: terminal.clone(),
            is_quiet: args.quiet,
            is_json: args.json,
            drawn: None,
            is_stale: false,
            is_live: true,
            purpose: Purpose::default(),
            recorder: None,
            is_recording_incomplete: false,
            feed: None,
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
        match (&mut self.history, record) {
            (Some(history), record) => history.apply(record),
            (history, Record::Header(header)) => *history = Some(of_run(header)),
            (None, _) => {}
        }
        // No other log begins anew.
        if let Some(history) = self.history.as_ref().filter(|history| history.is_standing()) {
            self.beginning.take(record, history);
        }
        log::emit(record, self.history.as_ref().map_or(&self.names, History::names));
        self.record(record);
        if let (Some(feed), Some(history)) = (&mut self.feed, &self.history) {
            feed.take(record, history);
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
        let names = self.history.as_ref().map_or(&self.names, History::names);
        self.purpose.after(record, names).iter().for_each(|line| self.terminal.say(line));
    }

    fn record(&mut self, record: &Record) {
        let is_recorded = match (&mut self.recorder, &self.history) {
            (Some(recorder), Some(history)) => recorder.take(history, record),
            (Some(_), None) | (None, _) => true,
        };
        if !is_recorded {
            self.finish_recording();
        }
    }

    /// Ends the recording, and tells what is wrong with it.
    fn finish_recording(&mut self) {
        let Some(recorder) = self.recorder.take() else { return };
        let path = recorder.path().to_owned();
        match recorder.finish() {
            Ok(missing) => {
                let missing = match missing {
                    0 => String::new(),
                    1 => "; a message is missing: its disk was too slow".into(),
                    many => format!("; {many} messages are missing: its disk was too slow"),
                };
                if !self.is_quiet || !missing.is_empty() {
                    self.terminal.say(&format!("recording: {}{missing}", shown(&path)));
                }
            }
            Err(error) => {
                self.is_recording_incomplete = true;
                let source = std::error::Error::source(&error).map(|source| format!(": {source}")).unwrap_or_default();
                self.terminal.say(&format!("error: the recording is incomplete: {error}{source}"));
            }
        }
    }

    /// The plain line for a record; simulated controllers are there from the beginning, which is no news.
    fn line(&self, record: &Record) -> Option<String> {
        let is_attached = matches!(record, Record::Controller { message: ControllerMessage::Attached, .. });
        // That not all attached is told once, in the end.
        let is_told_later = matches!(record, Record::Ended { end: MissionEnd::NotAttached, .. });
        let is_news = (self.is_live || !is_attached) && !is_told_later;
        live::line(self.history.as_ref().filter(|_| is_news)?, record)
    }

    /// What was taken is with the operating system, so that it outlives this process; false where it is not.
    pub fn settle(&mut self) -> bool {
        self.flush();
        self.tell_others();
        self.failure.is_none()
    }

    fn flush(&mut self) {
        if self.failure.is_none()
            && let Err(error) = self.file.flush()
        {
            self.fail(error);
        }
    }

    /// Whether the log is so long that it is to begin anew.
    pub fn is_full(&self) -> bool {
        self.failure.is_none() && self.file.bytes() >= self.limit
    }

    /// The log begins anew with what the run is; the one so far is put aside.
    pub fn begin_anew(&mut self, at: Time, saved: &Saved) {
        let Some(history) = self.history.as_ref().filter(|_| self.failure.is_none()) else { return };
        let records = self.beginning.records(history, at, saved);
        if let Err(error) = self.file.begin_anew(&records, self.keep_logs) {
            let source = std::error::Error::source(&error).map(|source| format!(": {source}")).unwrap_or_default();
            self.terminal.say(&format!("warning: the log is not put aside and grows on: {error}{source}"));
        }
        // What cannot be short is not to be written over and over.
        self.limit = self.size.max(self.file.bytes().saturating_mul(2));
    }

    /// Nothing waits: what was taken so far is safe from now on. When to tell what could not be drawn or told yet.
    pub fn rest(&mut self) -> Option<Duration> {
        self.flush();
        if self.is_stale && self.terminal.is_tty() && !self.is_quiet {
            self.draw();
        }
        (!self.tell_others() || self.is_stale).then_some(REDRAW)
    }

    /// Tells others what they were not told yet; false while that is not possible.
    pub fn tell_others(&mut self) -> bool {
        match (&mut self.feed, &self.history) {
            (Some(feed), Some(history)) => feed.flush(history),
            (Some(_), None) | (None, _) => true,
        }
    }

    /// What the run comes to so far, without its past; none before the first record.
    pub fn present(&self) -> Option<History> {
        self.history.as_ref().map(History::present)
    }

    fn fail(&mut self, error: JournalError) {
        let source = std::error::Error::source(&error).map(|source| format!(": {source}")).unwrap_or_default();
        self.terminal.say(&format!("error: the log is incomplete from here on: {error}{source}"));
        self.failure = Some(error);
    }

    /// Says something that is no error.
    pub fn say(&self, text: &str) {
        if !self.is_quiet {
            self.terminal.say(text);
        }
    }

    /// Names the controllers without which the mission does not begin.
    pub fn say_what_it_waits_for(&self) {
        let all = || self.names.controllers.iter().map(String::as_str).collect();
        let missing: Vec<&str> = self.history.as_ref().map_or_else(all, live::absent);
        if self.is_live && !self.is_quiet && !missing.is_empty() {
            self.terminal.say(&format!("waiting for {}", missing.join(", ")));
        }
    }

    /// Where no live display shows it: who is missing after one more has come or gone.
    fn say_who_is_missing(&self, record: &Record) {
        let Record::Controller { message, .. } = record else {
            if let Record::Told { input: Told::Resumed, .. } = record {
                self.say_what_it_waits_for();
            }
            return;
        };
        let has_begun = self.history.as_ref().is_some_and(|history| history.rounds() > 0);
        match message {
            ControllerMessage::Attached => self.say_what_it_waits_for(),
            ControllerMessage::Lost { .. } if !has_begun => self.say_what_it_waits_for(),
            ControllerMessage::Lost { .. }
            | ControllerMessage::Told { .. }
            | ControllerMessage::Joined { .. }
            | ControllerMessage::Heard { .. }
            | ControllerMessage::Refused { .. }
            | ControllerMessage::Misreported { .. }
            | ControllerMessage::Diagnosed { .. } => {}
        }
    }

    /// How far the run is, in one line; none before the first record.
    pub fn stage(&self) -> Option<String> {
        self.history.as_ref().map(live::stage)
    }

    /// How a controller was lost, if it was.
    pub fn lost(&self, controller: ControllerId) -> Option<Loss> {
        self.history.as_ref()?.lost(controller).map(|(_, why)| why)
    }

    /// Why something that a controller said was not used, the last time.
    pub fn refusal(&self, controller: ControllerId) -> Option<Rejection> {
        self.history.as_ref()?.controllers().refusal(controller)
    }

    /// Closes log and recording, clears the live display, and tells the end. False if one of them is incomplete.
    pub fn finish(&mut self) -> bool {
        self.flush();
        self.terminal.clear();
        let (width, palette) = (self.terminal.width(), self.terminal.palette());
        let has_begun = |history: &&History| history.end() != Some(MissionEnd::NotAttached);
        if let Some(history) = self.history.as_ref().filter(has_begun) {
            if !self.is_quiet && history.step_count() > 0 && !history.is_standing() {
                self.terminal.say(&format!("\n{}", timeline::text(history, width, &palette)));
            }
            if !self.is_quiet || history.end() == Some(MissionEnd::Stalled) {
                self.terminal.say(&live::summary(history, width, &palette));
            }
        }
        if !self.is_quiet {
            self.terminal.say(&format!("log: {}", shown(self.file.path())));
        }
        self.finish_recording();
        if let Some(report) = self.history.as_ref().and_then(History::report).filter(|_| self.is_json) {
            let text = serde_json::to_string(&report).expect("a report is plain");
            if !print(text, PRINT_WITHIN) {
                self.terminal.say("error: nobody reads stdout; the report is not written");
            }
        }
        self.failure.is_none() && !self.is_recording_incomplete
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

/// What is kept of a run that may go on without end is bounded by what it is at.
pub fn of_run(header: &Header) -> History {
    let history = History::new(header);
    if history.is_standing() { history } else { History::with_past(header) }
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
