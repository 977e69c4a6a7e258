//! `ambidex run` and `ambidex daemon`: a mission over controller processes.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use ambidex::files::{self, Disk, Loaded};
use ambidex::link::Instance;
use ambidex::model::{MissionEnd, Record};
use ambidex::runtime::{self, Clock, Control, Ended, Options, Sink};
use ambidex::tree::Settings;
use miette::{IntoDiagnostic, Result};
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::mpsc;

use crate::args::{DaemonArgs, LiveArgs, MissionArgs, OnStall, RunArgs};
use crate::children::Children;
use crate::diagnostics::{report_all, say_all};
use crate::exit::Exit;
use crate::observer::{Observer, REDRAW};
use crate::robot;
use crate::terminal::{QUIET, Terminal};

/// How long controllers may take to come to rest in the end.
const GRACE: Duration = Duration::from_secs(3);
/// How long children may take to end after that; what hangs is killed.
const CHILD_GRACE: Duration = Duration::from_secs(1);

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
    let terminal = Terminal::start(args.log_format, QUIET);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().into_diagnostic()?;
    let _entered = runtime.enter();
    // Before anything is begun that a signal would have to end.
    let (to_run, control) = mpsc::unbounded_channel();
    let signals = cancel_on_signals(to_run).into_diagnostic()?;
    let clock = Clock::start(live.speed);
    let links = robot::links(&loaded.mission, instance, &clock).into_diagnostic()?;
    let observer = Observer::new(&loaded.mission, args, instance.name(), &terminal, true).into_diagnostic()?;
    observer.say_what_it_waits_for();
    let observer = Arc::new(Mutex::new(observer));
    let robot = &loaded.mission.robot;
    let start = || Children::start(robot, &loaded.robot_path, instance, args.log_format, &terminal);
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
    };
    let mission = loaded.mission;
    let ended = runtime.block_on(async {
        tokio::spawn(signals);
        tokio::spawn(refresh(Arc::clone(&observer)));
        runtime::run(Arc::clone(&mission), links, options, control).await
    });
    if let Some(children) = children {
        children.end(CHILD_GRACE);
        if let Err(error) = ambidex::link::sweep() {
            terminal.say(&format!("warning: shared memory was not swept: {error}"));
        }
    }
    let mut observer = observer.lock().unwrap_or_else(PoisonError::into_inner);
    observer.finish().into_diagnostic()?;
    if let Some(complaint) = complaint(&ended, &mission) {
        terminal.say(&complaint);
    }
    Ok(Exit::from(&ended))
}

/// Hands the records of a run to whoever looks at it.
struct Watcher(Arc<Mutex<Observer>>);

impl Sink for Watcher {
    fn take(&mut self, record: &Record) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take(record);
    }

    fn rest(&mut self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).rest();
    }
}

/// Draws what came since the live display was drawn last.
async fn refresh(observer: Arc<Mutex<Observer>>) {
    let mut tick = tokio::time::interval(REDRAW);
    loop {
        tick.tick().await;
        observer.lock().unwrap_or_else(PoisonError::into_inner).refresh();
    }
}

/// What went wrong outside the task.
fn complaint(ended: &Ended, mission: &ambidex::model::MissionSpec) -> Option<String> {
    let names = &mission.names;
    match ended {
        Ended::NotAttached(missing) => {
            let missing: Vec<_> = missing.iter().map(|id| names.controller(*id)).collect();
            Some(format!("error: not attached in time: {}", missing.join(", ")))
        }
        Ended::Mission(MissionEnd::ControllerLost(id)) => {
            Some(format!("error: the controller {} is gone", names.controller(*id)))
        }
        Ended::Mission(MissionEnd::NodeLost(id)) => {
            Some(format!("error: the task of node \"{}\" is gone; this is a defect", names.node(*id)))
        }
        Ended::Mission(MissionEnd::TaskLost) => {
            Some("error: a task of the runtime is gone; this is a defect".to_owned())
        }
        Ended::Mission(
            MissionEnd::Done
            | MissionEnd::Failed(_)
            | MissionEnd::Stalled
            | MissionEnd::Canceled
            | MissionEnd::NotAttached,
        ) => None,
    }
}

/// The first Ctrl-C or SIGTERM cancels the mission, the second ends the process at once.
fn cancel_on_signals(run: mpsc::UnboundedSender<Control>) -> std::io::Result<impl Future<Output = ()>> {
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    Ok(async move {
        for control in [Some(Control::Cancel), None] {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
            match control {
                Some(control) => drop(run.send(control)),
                // Children die with this process; shared memory is swept at the next start.
                None => std::process::exit(Exit::Canceled as i32),
            }
        }
    })
}
