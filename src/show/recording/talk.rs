//! What a run says in words, and how much it matters.

use ambidex_model::{ControllerMessage, End, FromController, Level as Health, MissionEnd, Record, Service, StopCause};
use ambidex_record::History;

use super::foxglove::{Level, Log};
use super::message::{Moment, Topic};
use crate::live;

/// Tells the line that `run` prints of a record, if it prints one.
pub(super) fn tell(history: &History, record: &Record, moment: &mut Moment) {
    if let Some(message) = live::said(history, record) {
        let (timestamp, name) = (moment.stamp(), history.header().mission.as_str());
        let log = Log { timestamp, level: level(record), message, name, file: "", line: 0 };
        moment.say(Topic::Log, &log);
    }
}

fn level(record: &Record) -> Level {
    match record {
        Record::Released { end: End::Failed(_), .. } => Level::Error,
        Record::Released { end: End::Canceled | End::Interrupted, .. } => Level::Warning,
        Record::Released { end: End::Succeeded, .. } => Level::Info,
        Record::Infeasible { .. } | Record::TimedOut { .. } | Record::Cleaned { is_done: false, .. } => Level::Error,
        Record::Served { service: Service::Unavailable { .. }, .. } => Level::Warning,
        Record::Served { service: Service::Gone { .. }, .. } => Level::Error,
        Record::Served { service: Service::Available, .. } => Level::Info,
        Record::Controller { message, .. } => of_controller(message),
        Record::Denied { .. } | Record::Awaited { .. } | Record::Reopened { .. } => Level::Warning,
        Record::Stopped { cause: StopCause::Broken(_) | StopCause::Preempted { .. }, .. } => Level::Warning,
        Record::Ending { .. } | Record::Leaving { .. } => Level::Warning,
        Record::Ended { end, .. } => of_end(*end),
        Record::TaskEnded { end, .. } => of_end(*end),
        Record::Stalled { tasks, .. } if tasks.is_empty() => Level::Info,
        Record::Stalled { .. } | Record::Declined { .. } | Record::Canceled { .. } => Level::Warning,
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => Level::Info,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } | Record::Checkpoint { .. } => Level::Info,
        Record::Header(_) | Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } => Level::Info,
        Record::Began { .. } | Record::Sent { .. } | Record::Decided { .. } | Record::Overtaken { .. } => Level::Info,
        Record::Stopped { cause: StopCause::Ends, .. } | Record::Cleaning { .. } => Level::Info,
        Record::Cleaned { is_done: true, .. } | Record::Woke { .. } | Record::World { .. } => Level::Info,
        Record::Resource { .. } => Level::Info,
    }
}

fn of_controller(message: &ControllerMessage) -> Level {
    match message {
        ControllerMessage::Lost { .. } => Level::Error,
        ControllerMessage::Refused { .. } | ControllerMessage::Misreported { .. } => Level::Warning,
        ControllerMessage::Diagnosed { level: Health::Ok, .. } => Level::Info,
        ControllerMessage::Diagnosed { level: Health::Warn, .. } => Level::Warning,
        ControllerMessage::Diagnosed { level: Health::Error | Health::Stale, .. } => Level::Error,
        ControllerMessage::Heard { message: FromController::Rejected { .. } } => Level::Warning,
        ControllerMessage::Heard { .. } | ControllerMessage::Attached => Level::Info,
        ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } => Level::Info,
    }
}

fn of_end(end: MissionEnd) -> Level {
    match end {
        MissionEnd::Done => Level::Info,
        MissionEnd::Canceled => Level::Warning,
        MissionEnd::Failed(_) | MissionEnd::Stalled | MissionEnd::NotAttached => Level::Error,
        MissionEnd::ControllerLost(_) => Level::Error,
        MissionEnd::NodeLost(_) | MissionEnd::TaskLost => Level::Fatal,
    }
}
