//! `ambidex run` and `ambidex daemon`: a mission over controller processes.

use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::Duration;

use ambidex::files::{self, Disk, Loaded};
use ambidex::link::Instance;
use ambidex::model::{Loss, MissionEnd, MissionSpec, Record};
use ambidex::runtime::{self, Clock, Ended, Options, Sink};
use ambidex::tree::Settings;
use miette::{IntoDiagnostic, Result};
use tokio::sync::mpsc;

use crate::args::{DaemonArgs, LiveArgs, MissionArgs, OnStall, RunArgs};
use crate::children::Children;
use crate::diagnostics::{report_all, say_all};
use crate::exit::Exit;
use crate::observer::Observer;
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
    let loaded = load(&args.mission)?;
    let timeout = Some(args.attach_timeout);
    go(&args.mission, &args.live, &instance, timeout, loaded, true)
}

/// Runs a mission with controllers that others started.
pub fn daemon(args: &DaemonArgs) -> Result<Exit> {
    let loaded = load(&args.mission)?;
    go(&args.mission, &args.live, &args.instance, args.attach_timeout, loaded, false)
}

/// Loads the files of a mission and says what is surely not meant in them.
pub fn load(args: &MissionArgs) -> Result<Loaded> {
    let loaded = files::load_mission(&Disk, &args.mission, args.robot.as_deref(), &args.set)
        .map_err(|error| report_all(&error))?;
    if !args.quiet {
        say_all(&loaded.warnings);
    }
    Ok(loaded)
}

fn go(
    args: &MissionArgs,
    live: &LiveArgs,
    instance: &Instance,
    attach_timeout: Option<Duration>,
    loaded: Loaded,
    has_children: bool,
) -> Result<Exit> {
    descriptors::ensure(loaded.mission.robot.controllers.len())?;
    let terminal = Terminal::start(args.log_format, QUIET, Patience::Drops);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().into_diagnostic()?;
    let _entered = runtime.enter();
    // Before anything is begun that a signal would have to end.
    let (to_run, control) = mpsc::unbounded_channel();
    let signals = signals::cancel_on_signals(to_run.clone()).into_diagnostic()?;
    let clock = Clock::start(live.speed);
    let links = robot::links(&loaded.mission, instance, &clock).into_diagnostic()?;
    let observer = Observer::new(&loaded.mission, args, instance.name(), &terminal, true).into_diagnostic()?;
    observer.say_what_it_waits_for();
    let observer = Arc::new(Mutex::new(observer));
    let robot = &loaded.mission.robot;
    let start = || {
        let children = Children::start(robot, &loaded.robot_path, instance, args.log_format, &terminal)?;
        children.watch(&terminal, &to_run);
        Ok::<_, miette::Report>(children)
    };
    let children = has_children.then(start).transpose()?;
    let to_observer = Arc::clone(&observer);
    let options = Options {
        settings: Settings {
            allocator: args.allocator.allocator(),
            waits_when_stalled: live.on_stall == OnStall::Wait,
            ..Settings::default()
        },
        clock,
        attach_timeout,
        grace: GRACE,
        journal: Some(Box::new(Watcher(to_observer))),
        resumed: None,
    };
    let mission = loaded.mission;
    let ended = runtime.block_on(async {
        tokio::spawn(signals);
        runtime::run(Arc::clone(&mission), links, options, control).await
    });
    if let Some(children) = children {
        children.end(CHILD_GRACE);
        if let Err(error) = ambidex::link::sweep() {
            terminal.say(&format!("warning: shared memory was not swept: {error}"));
        }
    }
    let end = Exit::from(&ended);
    // The thread that writes the log has left it, unless what the log goes to takes nothing any more.
    let observer = match observer.try_lock() {
        Ok(observer) => Some(observer),
        Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => None,
    };
    let (mut is_whole, mut how) = (false, None);
    if let Some(mut observer) = observer {
        if let Ended::Mission(MissionEnd::ControllerLost(id)) = ended {
            how = observer.lost(id);
        }
        is_whole = observer.finish();
    }
    if let Some(complaint) = complaint(&ended, &mission, how) {
        terminal.say(&complaint);
    }
    terminal.finish(TALK_GRACE);
    Ok(if is_whole { end } else { end.with_incomplete_log() })
}

/// Hands the records of a run to whoever looks at it.
struct Watcher(Arc<Mutex<Observer>>);

impl Sink for Watcher {
    fn take(&mut self, record: &Record) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take(record);
    }

    fn rest(&mut self) -> Option<Duration> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).rest()
    }
}

/// What went wrong outside the task.
fn complaint(ended: &Ended, mission: &MissionSpec, how: Option<Loss>) -> Option<String> {
    let names = &mission.names;
    match ended {
        Ended::NotAttached(missing) => {
            let missing: Vec<_> = missing.iter().map(|id| names.controller(*id)).collect();
            Some(format!("× not attached in time: {}", missing.join(", ")))
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
