//! `ambidex run` and `ambidex daemon`: a mission over controller processes.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use ambidex::dispatch::Script;
use ambidex::files::{self, Disk, Loaded};
use ambidex::link::{Instance, survive_truncation};
use ambidex::model::{ControllerId, Loss, MissionEnd, MissionSpec, Record, Rejection, Time};
use ambidex::replay::Resumed;
use ambidex::runtime::control::ControlSocket;
use ambidex::runtime::{self, Clock, Ended, Options, Sink};
use ambidex::tree::Settings;
use miette::{IntoDiagnostic, Result};
use tokio::sync::{mpsc, oneshot, watch};

use crate::args::{DaemonArgs, LiveArgs, Messages, MissionArgs, OnStall, RunArgs};
use crate::children::Children;
use crate::diagnostics::{report_all, say_all};
use crate::exit::Exit;
use crate::keeping::Keeper;
use crate::observer::Observer;
use crate::purpose::{self, Doing, Purpose};
use crate::resume::{Resume, RobotFile, resume};
use crate::terminal::{Patience, QUIET, Terminal};
use crate::{descriptors, robot, signals};

/// How long controllers may take to come to rest in the end.
const GRACE: Duration = Duration::from_secs(3);
/// How long children may take to end after that; what hangs is killed.
const CHILD_GRACE: Duration = Duration::from_secs(1);

/// How long the last words may wait for a reader.
const TALK_GRACE: Duration = Duration::from_secs(1);

/// Runs a mission with child processes.
pub fn run(args: &RunArgs) -> Result<Exit> {
    let instance = args.instance.clone().unwrap_or_else(Instance::fresh);
    go(&args.common, &args.live, &instance, Some(args.attach_timeout), &Processes::Own { fail: args.fail.as_deref() })
}

/// Runs a mission with controllers that others started.
pub fn daemon(args: &DaemonArgs) -> Result<Exit> {
    go(&args.common, &args.live, &args.instance, args.attach_timeout, &Processes::Others { fail: args.fail.as_deref() })
}

/// Loads the files of a mission and says what is surely not meant in them.
pub fn load(mission: &Path, args: &MissionArgs) -> Result<Loaded> {
    let loaded =
        files::load_mission(&Disk, mission, args.robot.as_deref(), &args.set).map_err(|error| report_all(&error))?;
    if !args.quiet {
        say_all(&loaded.warnings);
    }
    Ok(loaded)
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
        let resumed = resume(log, live.mission.as_deref(), args)?;
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
    let mission = live.mission.as_deref().expect("a mission or a log is required");
    let Loaded { mission, robot_path, .. } = load(mission, args)?;
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

fn go(
    args: &MissionArgs,
    live: &LiveArgs,
    instance: &Instance,
    attach_timeout: Option<Duration>,
    processes: &Processes<'_>,
) -> Result<Exit> {
    let has_children = matches!(processes, Processes::Own { .. });
    let mut job = job(args, live, has_children)?;
    let failures = match processes {
        Processes::Own { fail } => purpose::load(*fail, &job.mission)?,
        Processes::Others { fail } => purpose::load_for_daemon(*fail, &job.mission)?,
    };
    descriptors::ensure(job.mission.robot.controllers.len())?;
    survive_truncation().into_diagnostic()?;
    let terminal = Terminal::start(args.log_format, QUIET, Patience::Drops);
    let ended = job.resumed.take_if(|resume| resume.resumed.end.is_some());
    if let Some((resume, end)) = ended.and_then(|resume| resume.resumed.end.map(|end| (resume, end))) {
        return Ok(ended_before(resume, end, args, &terminal));
    }
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().into_diagnostic()?;
    let _entered = runtime.enter();
    // Before anything is begun that a signal would have to end.
    let (to_run, control) = mpsc::unbounded_channel();
    let signals = signals::cancel_on_signals(to_run.clone()).into_diagnostic()?;
    let from = job.resumed.as_ref().map_or(Time::ZERO, |resumed| resumed.resumed.at);
    let clock = Clock::resume(from, live.speed);
    let (node, links) = robot::links(&job.mission, instance, &clock).into_diagnostic()?;
    let socket = ControlSocket::open(&node).into_diagnostic()?;
    drop(node);
    let (mut observer, resumed) = observer(&mut job, args, instance, &terminal)?;
    observer.purpose = Purpose::of_run(&failures);
    observer.say_what_it_waits_for();
    let observer = Arc::new(Mutex::new(observer));
    let start = || Children::start(&job.mission.robot, &job.robot_path, instance, args.log_format, &terminal);
    let children = has_children.then(start).transpose()?.map(|children| Arc::new(Mutex::new(children)));
    let (to_keeper, begun) = watch::channel(None);
    let script = Script::new(failures.flaws.clone());
    let keep = |children| Keeper { children, begun: begun.clone(), run: to_run.clone(), terminal: terminal.clone() };
    let keeper = children.clone().map(keep);
    keeper.iter().for_each(Keeper::keep_all);
    let (run, terminal_of_deeds) = (to_run.clone(), terminal.clone());
    let (names, is_quiet) = (job.mission.names.clone(), args.quiet);
    runtime.spawn(Doing { failures, names, clock, begun, run, terminal: terminal_of_deeds, keeper, is_quiet }.done());
    let options = Options {
        settings: job.settings.clone(),
        clock,
        attach_timeout,
        grace: GRACE,
        journal: Some(Box::new(Watcher { observer: Arc::clone(&observer), begun: to_keeper })),
        resumed,
        script,
    };
    let ended = runtime.block_on(async {
        tokio::spawn(signals);
        let (over, is_over) = oneshot::channel();
        let serving = tokio::spawn(socket.serve(Arc::clone(&job.mission), to_run, is_over));
        let ended = runtime::run(Arc::clone(&job.mission), links, options, control).await;
        drop(over);
        drop(serving.await);
        ended
    });
    if let Some(children) = children {
        lock(&children).end(CHILD_GRACE);
        sweep(&terminal);
    }
    Ok(tell_end(&ended, &observer, &job.mission, &terminal))
}

/// Who follows the run, and where the log of an earlier one leaves it.
fn observer(
    job: &mut Job,
    args: &MissionArgs,
    instance: &Instance,
    terminal: &Terminal,
) -> Result<(Observer, Option<Resumed>)> {
    if let Some(Resume { resumed, file, history, .. }) = job.resumed.take() {
        return Ok((Observer::resume(file, history, args, terminal), Some(resumed)));
    }
    Ok((Observer::new(&job.mission, args, instance.name(), terminal, true).into_diagnostic()?, None))
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Nothing of the log goes on: it is completed where it lacks the last words, and told once more.
fn ended_before(resume: Resume, end: MissionEnd, args: &MissionArgs, terminal: &Terminal) -> Exit {
    let mut observer = Observer::resume(resume.file, resume.history, args, terminal);
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
    }

    fn rest(&mut self) -> Option<Duration> {
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
