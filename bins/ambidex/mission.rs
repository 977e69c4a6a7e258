//! `ambidex run` and `ambidex daemon`: a mission over controller processes.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use ambidex::dispatch::Script;
use ambidex::files::{self, Disk, FilesError, Loaded};
use ambidex::http::{Endpoint, Feed, Hub, Server};
use ambidex::link::{Instance, survive_truncation};
use ambidex::model::state::Saved;
use ambidex::model::{ControllerId, Failures, Loss, MissionEnd, MissionSpec, Record, Rejection, Time};
use ambidex::record::History;
use ambidex::replay::Resumed;
use ambidex::runtime::{self, Clock, Control, Ended, Options, Sink};
use ambidex::show::recording::WallClock;
use ambidex::tree::Settings;
use miette::{IntoDiagnostic, Result};
use tokio::sync::{mpsc, watch};

use crate::args::{DaemonArgs, LiveArgs, Messages, MissionArgs, OnStall, RunArgs};
use crate::children::Children;
use crate::diagnostics::{report_all, say_all};
use crate::exit::Exit;
use crate::keeping::Keeper;
use crate::observer::Observer;
use crate::purpose::{self, Doing, Purpose};
use crate::reading::FileReader;
use crate::resume::{Resume, RobotFile, resume, unfinished};
use crate::service::Service;
use crate::terminal::{Patience, QUIET, Terminal};
use crate::{descriptors, recording, robot, signals};

/// How long controllers may take to come to rest in the end.
const GRACE: Duration = Duration::from_secs(3);
/// How long children may take to end after that; what hangs is killed.
const CHILD_GRACE: Duration = Duration::from_secs(1);

/// How long the last words may wait for a reader.
const TALK_GRACE: Duration = Duration::from_secs(1);

/// Runs a mission with child processes.
pub fn run(args: &RunArgs) -> Result<Exit> {
    let instance = args.instance.clone().unwrap_or_else(Instance::fresh);
    let processes = Processes::Own { fail: args.fail.as_deref() };
    let (instance, attach_timeout) = (&instance, Some(args.attach_timeout));
    go(&Setup { args: &args.common, live: &args.live, instance, attach_timeout, processes })
}

/// Runs a mission with controllers that others started.
pub fn daemon(args: &DaemonArgs) -> Result<Exit> {
    let processes = Processes::Others { fail: args.fail.as_deref() };
    let (instance, attach_timeout) = (&args.instance, args.attach_timeout);
    let unfinished = if args.or_resume { unfinished(instance, &args.common)? } else { None };
    let live = LiveArgs { resume: unfinished.or(args.live.resume.clone()), ..args.live.clone() };
    go(&Setup { args: &args.common, live: &live, instance, attach_timeout, processes })
}

/// Loads the files of a mission and says what is surely not meant in them.
pub fn load(mission: &Path, args: &MissionArgs) -> Result<Loaded> {
    told(files::load_mission(&Disk, mission, args.robot.as_deref(), &args.set), args)
}

/// What was loaded, once it is said what is surely not meant in it.
fn told(loaded: Result<Loaded, FilesError>, args: &MissionArgs) -> Result<Loaded> {
    let loaded = loaded.map_err(|error| report_all(&error))?;
    if !args.quiet {
        say_all(&loaded.warnings);
    }
    Ok(loaded)
}

/// What a run begins with, by its files.
pub fn loaded(live: &LiveArgs, args: &MissionArgs) -> Result<Loaded> {
    match (&live.mission, &live.world, &args.robot) {
        (Some(mission), ..) => load(mission, args),
        (None, Some(world), Some(robot)) => told(files::load_world(&Disk, robot, world, &args.set), args),
        (None, ..) => unreachable!("a mission, a world with a robot, or a log is required"),
    }
}

/// What is to be run, new or from where its log ends.
struct Job {
    mission: Arc<MissionSpec>,
    settings: Settings,
    /// Where controllers find the robot.
    robot_path: PathBuf,
    resumed: Option<Resume>,
    _robot_file: Option<RobotFile>,
}

fn job(args: &MissionArgs, live: &LiveArgs, has_children: bool) -> Result<Job> {
    if let Some(log) = &live.resume {
        let resumed = resume(log, live, args)?;
        let robot_file = if has_children { Some(resumed.robot_file()?) } else { None };
        let robot_path = robot_file.as_ref().map(|file| file.path().to_owned()).unwrap_or_default();
        return Ok(Job {
            mission: Arc::clone(&resumed.rerun.mission),
            settings: resumed.rerun.settings.clone(),
            robot_path,
            resumed: Some(resumed),
            _robot_file: robot_file,
        });
    }
    let Loaded { mission, robot_path, .. } = loaded(live, args)?;
    let settings = Settings {
        allocator: args.allocator.allocator(),
        waits_when_stalled: live.on_stall == OnStall::Wait,
        has_messages: Messages::are_told(args.messages, &mission),
        reattach: args.reattach_timeout.mul_f64(live.speed),
        cleanup_grace: args.cleanup_grace.mul_f64(live.speed),
        ..Settings::default()
    };
    Ok(Job { mission, settings, robot_path, resumed: None, _robot_file: None })
}

/// Whose processes the controllers are.
enum Processes<'a> {
    /// Children of this one; to which things may happen on purpose.
    Own { fail: Option<&'a Path> },
    /// Others have started them; to all else things may happen on purpose.
    Others { fail: Option<&'a Path> },
}

impl Processes<'_> {
    fn are_children(&self) -> bool {
        match self {
            Self::Own { .. } => true,
            Self::Others { .. } => false,
        }
    }
}

/// How a mission is to be run.
struct Setup<'a> {
    args: &'a MissionArgs,
    live: &'a LiveArgs,
    instance: &'a Instance,
    attach_timeout: Option<Duration>,
    processes: Processes<'a>,
}

fn go(setup: &Setup<'_>) -> Result<Exit> {
    let Setup { args, live, processes, .. } = setup;
    let mut job = job(args, live, processes.are_children())?;
    let failures = match processes {
        Processes::Own { fail } => purpose::load(*fail, &job.mission)?,
        Processes::Others { fail } => purpose::load_for_daemon(*fail, &job.mission)?,
    };
    descriptors::ensure(job.mission.robot.controllers.len())?;
    survive_truncation().into_diagnostic()?;
    let terminal = Terminal::start(args.log_format, QUIET, Patience::Drops);
    let service = Service::start();
    let ended = job.resumed.take_if(|resume| resume.resumed.end.is_some());
    if let Some((resume, end)) = ended.and_then(|resume| resume.resumed.end.map(|end| (resume, end))) {
        service.ready();
        service.finish();
        return Ok(ended_before(resume, end, args, &terminal));
    }
    let exit = carry(setup, job, failures, &terminal, &service);
    service.finish();
    exit
}

/// Runs what is to be run, to its end.
fn carry(setup: &Setup<'_>, mut job: Job, failures: Failures, terminal: &Terminal, service: &Service) -> Result<Exit> {
    let Setup { args, live, instance, .. } = setup;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().into_diagnostic()?;
    let _entered = runtime.enter();
    // Before anything is begun that a signal would have to end.
    let (to_run, control) = mpsc::unbounded_channel();
    let signals = signals::cancel_on_signals(to_run.clone()).into_diagnostic()?;
    let from = job.resumed.as_ref().map_or(Time::ZERO, |resumed| resumed.resumed.at);
    let clock = Clock::resume(from, live.speed);
    let (node, links) = robot::links(&job.mission, instance, &clock).into_diagnostic()?;
    let endpoint = Endpoint::open(&node, live.http).into_diagnostic()?;
    drop(node);
    let recorder = recording::start(args, &job.mission, wall_clock(&clock), Patience::Drops)?;
    let (mut observer, resumed) = observer(&mut job, args, instance, terminal)?;
    observer.purpose = Purpose::of_run(&failures);
    observer.recorder = recorder;
    let (diagnostics, feed) = watch::channel(Arc::default());
    let server = serve(endpoint, &job, &to_run, clock, &mut observer, feed).into_diagnostic()?;
    if resumed.is_none() {
        observer.say_what_it_waits_for();
    }
    let observer = Arc::new(Mutex::new(observer));
    let start = || Children::start(&job.mission.robot, &job.robot_path, instance, args.log_format, terminal);
    let children =
        setup.processes.are_children().then(start).transpose()?.map(|children| Arc::new(Mutex::new(children)));
    let (to_keeper, begun) = watch::channel(None);
    let script = Script::new(failures.flaws.clone());
    let keep = |children| Keeper { children, begun: begun.clone(), run: to_run.clone(), terminal: terminal.clone() };
    let keeper = children.clone().map(keep);
    keeper.iter().for_each(Keeper::keep_all);
    let (run, terminal_of_deeds) = (to_run.clone(), terminal.clone());
    let (names, is_quiet) = (job.mission.names.clone(), args.quiet);
    runtime.spawn(Doing { failures, names, clock, begun, run, terminal: terminal_of_deeds, keeper, is_quiet }.done());
    let reader = job.mission.tree.is_standing().then(|| FileReader::shared(&job.mission)).transpose()?;
    let options = Options {
        reader,
        settings: job.settings.clone(),
        clock,
        attach_timeout: setup.attach_timeout,
        grace: GRACE,
        journal: Some(Box::new(Watcher::new(&observer, to_keeper, service))),
        resumed,
        script,
        diagnostics,
    };
    let ended = runtime.block_on(async {
        tokio::spawn(signals);
        tokio::spawn(service.clone().pulse());
        service.ready();
        let ended = runtime::run(Arc::clone(&job.mission), links, options, control).await;
        service.stopping();
        ended
    });
    if let Ok(mut observer) = observer.try_lock() {
        observer.tell_others();
    }
    drop(server);
    if let Some(children) = children {
        lock(&children).end(CHILD_GRACE);
        sweep(terminal);
    }
    Ok(tell_end(&ended, &observer, &job.mission, terminal))
}

/// Begins to answer others who ask about the run.
fn serve(
    endpoint: Endpoint,
    job: &Job,
    run: &mpsc::UnboundedSender<Control>,
    clock: Clock,
    observer: &mut Observer,
    diagnostics: runtime::Feed,
) -> io::Result<Server> {
    if let Some(address) = endpoint.address() {
        observer.say(&format!("asked at http://{address}/v1/ too"));
    }
    let (feed, news) = Feed::new();
    observer.feed = Some(feed);
    let history = observer.present().unwrap_or_else(|| History::new(&job.settings.header(&job.mission)));
    Server::start(endpoint, Arc::clone(&job.mission), run.clone(), Hub::new(history, clock), news, diagnostics)
}

/// Who follows the run, and where the log of an earlier one leaves it.
fn observer(
    job: &mut Job,
    args: &MissionArgs,
    instance: &Instance,
    terminal: &Terminal,
) -> Result<(Observer, Option<Resumed>)> {
    if let Some(Resume { resumed, file, history, beginning, .. }) = job.resumed.take() {
        return Ok((Observer::resume(file, (history, beginning), args, terminal), Some(resumed)));
    }
    Ok((Observer::new(&job.mission, args, instance.name(), terminal, true).into_diagnostic()?, None))
}

/// What a recording goes by.
fn wall_clock(clock: &Clock) -> WallClock {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    WallClock::set(u64::try_from(now.as_nanos()).unwrap_or_default(), clock.now(), clock.speed())
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Nothing of the log goes on: it is completed where it lacks the last words, and told once more.
fn ended_before(resume: Resume, end: MissionEnd, args: &MissionArgs, terminal: &Terminal) -> Exit {
    let mut observer = Observer::resume(resume.file, (resume.history, resume.beginning), args, terminal);
    resume.resumed.missing.iter().for_each(|record| observer.take(record));
    // Its runtime may have been killed before it had tidied up.
    sweep(terminal);
    observer.finish();
    terminal.say("the mission of this log had ended: nothing is left to go on with");
    terminal.finish(TALK_GRACE);
    Exit::from(end)
}

/// Removes what dead processes left in shared memory.
fn sweep(terminal: &Terminal) {
    if let Err(error) = ambidex::link::sweep() {
        terminal.say(&format!("warning: shared memory was not swept: {error}"));
    }
}

/// Closes the log, tells how it ended, and what went wrong outside the task.
fn tell_end(ended: &Ended, observer: &Mutex<Observer>, mission: &MissionSpec, terminal: &Terminal) -> Exit {
    let end = Exit::from(ended);
    // The thread that writes the log has left it, unless what the log goes to takes nothing any more.
    let observer = match observer.try_lock() {
        Ok(observer) => Some(observer),
        Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    };
    let (mut is_whole, mut how, mut refused) = (false, None, Vec::new());
    if let Some(mut observer) = observer {
        if let Ended::Mission(MissionEnd::ControllerLost(id)) = ended {
            how = observer.lost(*id);
        }
        if let Ended::NotAttached(missing) = ended {
            refused = missing.iter().filter_map(|id| Some((*id, observer.refusal(*id)?))).collect();
        }
        is_whole = observer.finish();
    }
    if let Some(complaint) = complaint(ended, mission, how, &refused) {
        terminal.say(&complaint);
    }
    terminal.finish(TALK_GRACE);
    if is_whole { end } else { end.with_incomplete_log() }
}

/// Hands the records of a run to whoever looks at it.
struct Watcher {
    observer: Arc<Mutex<Observer>>,
    /// Who waits for the mission to begin.
    begun: watch::Sender<Option<Time>>,
    service: Service,
    /// What the service manager knows of the run.
    stage: Option<String>,
}

impl Watcher {
    fn new(observer: &Arc<Mutex<Observer>>, begun: watch::Sender<Option<Time>>, service: &Service) -> Self {
        Self { observer: Arc::clone(observer), begun, service: service.clone(), stage: None }
    }

    /// Tells the service manager what the run is at, where that is different.
    fn tell_stage(&mut self) {
        let stage = lock(&self.observer).stage().filter(|stage| self.stage.as_ref() != Some(stage));
        if let Some(stage) = stage {
            self.service.status(&stage);
            self.stage = Some(stage);
        }
    }
}

impl Sink for Watcher {
    fn take(&mut self, record: &Record) {
        lock(&self.observer).take(record);
        // One that is resumed has begun before.
        if let Record::Began { at, .. } | Record::Decided { at, .. } = record {
            self.begun.send_if_modified(|begun| {
                let is_first = begun.is_none();
                begun.get_or_insert(*at);
                is_first
            });
        }
        if let Record::Ending { .. } | Record::Ended { .. } = record {
            self.service.stopping();
            self.tell_stage();
        }
    }

    fn settle(&mut self) -> bool {
        lock(&self.observer).settle()
    }

    fn is_full(&self) -> bool {
        lock(&self.observer).is_full()
    }

    fn save(&mut self, at: Time, saved: &Saved) {
        lock(&self.observer).begin_anew(at, saved);
    }

    fn rest(&mut self) -> Option<Duration> {
        if self.service.is_supervised() {
            self.tell_stage();
        }
        lock(&self.observer).rest()
    }
}

/// What went wrong outside the task.
fn complaint(
    ended: &Ended,
    mission: &MissionSpec,
    how: Option<Loss>,
    refused: &[(ControllerId, Rejection)],
) -> Option<String> {
    let names = &mission.names;
    match ended {
        Ended::NotAttached(missing) => {
            let missing: Vec<_> = missing.iter().map(|id| names.controller(*id)).collect();
            let why = |(id, why): &(_, _)| format!("\n  what {} said was refused: {why}", names.controller(*id));
            let whys: String = refused.iter().map(why).collect();
            Some(format!("× not attached in time: {}{whys}", missing.join(", ")))
        }
        Ended::Mission(MissionEnd::ControllerLost(id)) => {
            let how = how.map_or(String::new(), |how| format!(": {how}"));
            Some(format!("× the controller {} is gone{how}", names.controller(*id)))
        }
        Ended::Mission(MissionEnd::NodeLost(id)) => {
            Some(format!("× the task of node \"{}\" is gone; this is a defect", names.node(*id)))
        }
        Ended::Mission(MissionEnd::TaskLost) => Some("× a task of the runtime is gone; this is a defect".to_owned()),
        Ended::Mission(
            MissionEnd::Done
            | MissionEnd::Failed(_)
            | MissionEnd::Stalled
            | MissionEnd::Canceled
            | MissionEnd::NotAttached,
        ) => None,
    }
}
