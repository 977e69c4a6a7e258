//! A live journal and whose it is: finding it, reading on in it, and asking whether its daemon lives.

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use ambidex::link::{Instance, Present};
use ambidex::model::{Record, Time, nearest};
use ambidex::record::{History, JournalError, shown};
use ambidex::runtime::log::{self, Follower, News};
use ambidex::show::status::{Daemon, Snapshot};
use miette::{IntoDiagnostic, Report, Result, miette};

/// Records that are read at once, so that whoever wants to leave need not wait for the last of a million.
const AT_ONCE: usize = 10_000;
/// How often it is asked whether the daemon lives.
const ASK_EVERY: Duration = Duration::from_millis(300);
/// How long a daemon may take from its start to the first line of its log.
const BEGIN_WITHIN: Duration = Duration::from_secs(2);
const BEGIN_POLL: Duration = Duration::from_millis(10);
/// Most instances that are named where the one asked for has no journal.
const MOST_NAMED: usize = 8;

/// Which journal is read, and which instance is asked for its daemon.
#[derive(Debug, Clone)]
pub struct Source {
    path: PathBuf,
    instance: Option<Instance>,
    is_default: bool,
}

impl Source {
    /// A log by its path, else that of an instance.
    pub fn new(instance: Option<Instance>, log: Option<PathBuf>) -> Self {
        match log {
            Some(path) => Self { path, instance, is_default: false },
            None => {
                let instance = instance.unwrap_or_else(|| Instance::new("default").expect("it is a name"));
                Self { path: log::default_path(instance.name()), instance: Some(instance), is_default: true }
            }
        }
    }

    /// The instance whose daemon may write it.
    pub fn instance(&self) -> Option<Instance> {
        self.instance.clone()
    }

    /// Opens the journal and reads what is there; a daemon that just begins is given time for its first line.
    ///
    /// # Errors
    /// When there is no journal, or none that can be read.
    pub fn follow(&self) -> Result<Following> {
        match self.look()? {
            Some(following) => Ok(following),
            None if self.is_default => Err(self.nothing(None)),
            None => Err(Follower::open(&self.path).map(drop).into_diagnostic().expect_err("it is not there")),
        }
    }

    /// The same; none where there is neither a journal nor a daemon as yet.
    ///
    /// # Errors
    /// When there is a journal that cannot be read, or a daemon that writes another.
    pub fn look(&self) -> Result<Option<Following>> {
        let by = Instant::now() + BEGIN_WITHIN;
        loop {
            let writer = self.ask()?;
            let found = self.open(writer)?;
            let is_due = Instant::now() > by;
            match (found, writer) {
                (Some(following), _) if following.is_current() => return Ok(Some(following)),
                (None, Writer::None) => return Ok(None),
                (None, writer) if is_due => return Err(self.nothing(Some(writer))),
                (Some(following), writer) if writer == Writer::None || is_due => {
                    return following.into_best().map(Some);
                }
                (Some(_) | None, _) => thread::sleep(BEGIN_POLL),
            }
        }
    }

    /// What is waited for where nothing is there yet.
    pub fn awaited(&self) -> String {
        match &self.instance {
            Some(instance) if self.is_default => format!("a daemon of instance \"{}\"", instance.name()),
            Some(_) | None => shown(&self.path),
        }
    }

    /// Whether somebody writes: an instance's daemon, or whoever holds the file.
    fn ask(&self) -> Result<Writer> {
        match &self.instance {
            Some(instance) => Ok(instance.daemon().into_diagnostic()?.map_or(Writer::None, Writer::Daemon)),
            None => match File::open(&self.path).map(|file| file.try_lock_shared()) {
                Ok(Err(TryLockError::WouldBlock)) => Ok(Writer::Unnamed),
                Ok(Err(TryLockError::Error(error))) => Err(error).into_diagnostic(),
                // What cannot be opened is told by whoever reads it.
                Ok(Ok(())) | Err(_) => Ok(Writer::None),
            },
        }
    }

    /// None where there is no journal.
    fn open(&self, writer: Writer) -> Result<Option<Following>> {
        let follower = match Follower::open(&self.path) {
            Ok(follower) => follower,
            Err(JournalError::Open { source, .. }) if source.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error).into_diagnostic(),
        };
        let (source, asked) = (self.clone(), Instant::now());
        let mut following = Following { source, follower, history: None, writer, asked, is_replaced: false };
        while following.read()? {}
        Ok(Some(following))
    }

    /// What is said where an instance has no journal.
    fn nothing(&self, writer: Option<Writer>) -> Report {
        let name = self.instance.as_ref().map_or("default", Instance::name);
        if let Some(Writer::Daemon(Present { pid, .. })) = writer {
            let help = format!("{} is not there; name its log with --log FILE", shown(&self.path));
            return miette!(help = help, "the daemon of instance \"{name}\" (pid {pid}) logs elsewhere");
        }
        let known = log::instances();
        if known.is_empty() {
            let help = "`ambidex run` and `ambidex daemon` write one";
            return miette!(help = help, "instance \"{name}\" has no journal, and no other has one");
        }
        let meant = nearest(name, known.iter().map(String::as_str));
        let meant = meant.map_or(String::new(), |meant| format!("did you mean \"{meant}\"? "));
        let others: Vec<String> = known.iter().take(MOST_NAMED).map(|name| described(name)).collect();
        let more = known.len() - others.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let help = format!("{meant}--instance NAME tells of another; these have one: {}{more}", others.join(", "));
        miette!(help = help, "instance \"{name}\" has no journal")
    }
}

/// An instance and whether its daemon lives.
fn described(name: &str) -> String {
    let daemon = Instance::new(name).ok().and_then(|instance| instance.daemon().ok().flatten());
    if daemon.is_some() { format!("{name} (running)") } else { name.to_owned() }
}

/// Who writes a journal.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Writer {
    /// The daemon of its instance.
    Daemon(Present),
    /// Somebody who holds the file.
    Unnamed,
    None,
}

/// A journal that is read on, and what it tells.
#[derive(Debug)]
pub struct Following {
    source: Source,
    follower: Follower,
    history: Option<History>,
    writer: Writer,
    asked: Instant,
    is_replaced: bool,
}

impl Following {
    /// Reads on; true if there may be more at once.
    ///
    /// # Errors
    /// When the journal cannot be read.
    pub fn catch_up(&mut self) -> Result<bool> {
        // Asked before reading: what a daemon that is gone has written is all there then.
        if self.asked.elapsed() > ASK_EVERY {
            self.writer = self.source.ask()?;
            self.asked = Instant::now();
        }
        self.read()
    }

    /// What it tells now; none before its header.
    pub fn snapshot(&self) -> Option<Snapshot> {
        self.history.as_ref().map(|history| Snapshot::new(history, self.daemon(), self.now(history)))
    }

    /// Whether its daemon went before it wrote a header.
    pub fn is_abandoned(&self) -> bool {
        self.follower.header().is_none() && self.daemon() == Daemon::Gone
    }

    fn read(&mut self) -> Result<bool> {
        for _ in 0..AT_ONCE {
            match self.follower.look().into_diagnostic()? {
                News::Record(record) => match (record.as_ref(), &mut self.history) {
                    (Record::Header(header), _) => self.history = Some(History::new(header)),
                    (record, Some(history)) => history.apply(record),
                    (_, None) => {}
                },
                News::Quiet => return Ok(false),
                // A mission that ended is told to its end, whatever comes after it.
                News::Replaced if self.history.as_ref().is_some_and(|history| history.end().is_some()) => {
                    self.is_replaced = true;
                    return Ok(false);
                }
                News::Replaced => {
                    self.follower = Follower::open(self.follower.path()).into_diagnostic()?;
                    self.history = None;
                }
            }
        }
        Ok(true)
    }

    /// Whether the daemon that lives has written it.
    fn daemon(&self) -> Daemon {
        match self.writer {
            Writer::Daemon(Present { pid, since }) if !self.is_replaced && self.written() >= Some(since) => {
                Daemon::Running { pid: Some(pid) }
            }
            Writer::Unnamed if !self.is_replaced => Daemon::Running { pid: None },
            Writer::Daemon(_) | Writer::Unnamed | Writer::None => Daemon::Gone,
        }
    }

    /// Whether it is a journal, and that of the daemon that lives if one does.
    fn is_current(&self) -> bool {
        self.follower.header().is_some() && (self.writer == Writer::None || self.daemon() != Daemon::Gone)
    }

    /// The journal though it may be of an earlier daemon; none came that is better.
    fn into_best(self) -> Result<Self> {
        if self.follower.header().is_none() {
            return Err(JournalError::NoHeader { path: self.source.path }).into_diagnostic();
        }
        Ok(self)
    }

    /// When it was written last, by the clock of the files.
    fn written(&self) -> Option<SystemTime> {
        fs::metadata(self.follower.path()).and_then(|about| about.modified()).ok()
    }

    /// Robot time: that of the last record, and what went by since.
    fn now(&self, history: &History) -> Time {
        let since = self.written().and_then(|written| written.elapsed().ok()).unwrap_or_default();
        let speed = history.controllers().speed().filter(|speed| (0.0..=1e6).contains(speed));
        history.now() + since.mul_f64(speed.unwrap_or(1.0))
    }
}
