//! `ambidex controller`.

use std::collections::BTreeMap;
use std::time::Duration;

use ambidex::files::{self, Disk};
use ambidex::link::{ServeEvent, ServeOptions, Stop, Watcher, serve};
use ambidex::model::{CommandId, PartEnd};
use ambidex::motion::{self, Command, FromController, ToController};
use miette::{IntoDiagnostic, Result, miette};
use nalgebra::Point3;

use crate::args::ControllerArgs;
use crate::diagnostics::report_all;
use crate::emergency_stop::EmergencyStop;
use crate::exit::Exit;
use crate::own_record::OwnRecord;
use crate::terminal::{Patience, QUIET, TALKING, Terminal};
use crate::values::LogFormat;
use crate::{descriptors, signals};

/// How long the last words may wait for a reader.
const TALK_GRACE: Duration = Duration::from_secs(1);

/// Serves one simulated controller until it is told to stop.
pub fn controller(args: &ControllerArgs) -> Result<Exit> {
    let file = files::load_robot(&Disk, &args.robot).map_err(|error| report_all(&error))?;
    let controllers = &file.robot.controllers;
    let Some(spec) = controllers.iter().find(|spec| spec.name == args.name) else {
        let names: Vec<_> = controllers.iter().map(|spec| spec.name.as_str()).collect();
        return Err(miette!(
            "{} has no controller \"{}\"; it has {}",
            args.robot.display(),
            args.name,
            names.join(", ")
        ));
    };
    descriptors::ensure(1)?;
    let filter = if args.parent.is_some() { QUIET } else { TALKING };
    let terminal = Terminal::start(args.log_format, filter, Patience::Drops);
    let stop = Stop::on_signals().into_diagnostic()?;
    signals::end_on_the_second().into_diagnostic()?;
    let is_watched = args.parent.is_none() && args.log_format == LogFormat::Text;
    let told = is_watched.then(|| watcher(args, terminal.clone()));
    let record = args.record.as_deref().map(OwnRecord::open).transpose()?;
    let watcher = Watcher::new(all(told, record));
    let options = ServeOptions { once: args.once, parent: args.parent, stop: Some(stop), watcher: Some(watcher) };
    let body = EmergencyStop::on_signals(motion::simulated(&spec.kind)).into_diagnostic()?;
    let ended = serve(&args.instance, &args.name, body, options).into_diagnostic();
    terminal.finish(TALK_GRACE);
    ended.map(|_| Exit::Done)
}

/// Tells an event to all that want it.
fn all(
    mut told: Option<impl FnMut(ServeEvent<'_>) + Send + 'static>,
    record: Option<OwnRecord>,
) -> impl FnMut(ServeEvent<'_>) + Send + 'static {
    move |event| {
        if let Some(tell) = &mut told {
            tell(event);
        }
        if let Some(record) = &record {
            record.take(event);
        }
    }
}

/// Tells whoever started the controller by hand what it does, a line for each goal.
fn watcher(args: &ControllerArgs, terminal: Terminal) -> impl FnMut(ServeEvent<'_>) + Send + 'static {
    let ready = format!("{} serves instance {}; Ctrl-C ends it", args.name, args.instance.name());
    let mut goals: BTreeMap<CommandId, String> = BTreeMap::new();
    move |event| match event {
        ServeEvent::Ready => terminal.say(&ready),
        // Log lines tell of these two.
        ServeEvent::Attached | ServeEvent::Left => goals.clear(),
        ServeEvent::Told(ToController::Goal { id, command, .. }) => {
            goals.insert(*id, goal(command));
        }
        ServeEvent::Told(ToController::Configure { .. } | ToController::Cancel { .. }) => {}
        ServeEvent::Said(FromController::Result { id, end, began, ended, .. }) => {
            let took = (*ended - *began).as_secs_f64();
            let end = match end {
                PartEnd::Succeeded => "succeeded",
                PartEnd::Aborted => "gave up",
                PartEnd::Canceled => "canceled",
                PartEnd::Inhibited(_) => "inhibited",
            };
            if let Some(goal) = goals.remove(id) {
                terminal.say(&format!("{:>9.2} s  {goal}: {end} after {took:.2} s", ended.seconds()));
            }
        }
        ServeEvent::Said(FromController::Rejected { id, why }) => {
            if let Some(goal) = goals.remove(id) {
                terminal.say(&format!("             {goal}: rejected, {why}"));
            }
        }
        ServeEvent::Said(
            FromController::Configured { .. } | FromController::Accepted { .. } | FromController::Feedback { .. },
        ) => {}
    }
}

/// A command in words.
fn goal(command: &Command) -> String {
    let point = |at: &Point3<f64>| format!("({:.2}, {:.2}, {:.2})", at.x, at.y, at.z);
    match command {
        Command::Drive { path, .. } => match path.last() {
            Some(to) => format!("drive to ({:.2}, {:.2})", to.at.x, to.at.y),
            None => "drive nowhere".to_owned(),
        },
        Command::Stand => "stand still".to_owned(),
        Command::Grasp { object, at, .. } => format!("grasp {object} at {}", point(at)),
        Command::Put { object, at, .. } => format!("put {object} down at {}", point(at)),
        Command::Look { at, .. } => format!("look at {}", point(at)),
        Command::Call(call) => call.to_string(),
    }
}
