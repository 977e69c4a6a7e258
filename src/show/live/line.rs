//! One plain line per event, for logs and terminals whose lines stay.

use std::collections::BTreeSet;

use ambidex_model::state::Stage;
use ambidex_model::{
    Change, ControllerId, ControllerMessage, End, FromController, Grant, Header, MissionEnd, Names, NodeId, Origin,
    Record, Reopened, ResourceId, Told,
};
use ambidex_record::History;

use crate::text::phrase;
use crate::text::{count, mission_ended};

/// The line for a record that the history took last; none for what only a log tells.
pub fn line(history: &History, record: &Record) -> Option<String> {
    said(history, record).map(|said| format!("{:>7.2} s  {said}", history.now().seconds()))
}

/// The same without its time.
pub(crate) fn said(history: &History, record: &Record) -> Option<String> {
    let names = history.names();
    let text = match record {
        Record::Header(header) => begins(history, header),
        Record::Told { input: Told::Resumed, .. } => "goes on after its runtime was gone".into(),
        Record::Sent { .. } | Record::Resource { .. } | Record::Told { .. } => return None,
        Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => return None,
        Record::Decided { granted, reopened, .. } => decided(history, granted, reopened.as_ref())?,
        Record::Released { leaf, end, .. } => released(*leaf, *end, names),
        Record::World { change, origin, .. } => changed(change, *origin, names)?,
        Record::Denied { change, origin, why, .. } => phrase::denied(change, *origin, *why, names),
        Record::Served { controller, service, .. } => phrase::served(*controller, *service, names),
        Record::Awaited { until, facts, places, .. } => phrase::awaited(*until, facts, places, names),
        Record::Infeasible { .. } | Record::TimedOut { .. } | Record::Reopened { .. } | Record::Overtaken { .. } => {
            phrase::turned(record, history)?
        }
        Record::Stopped { .. } | Record::Ending { .. } | Record::Leaving { .. } => phrase::turned(record, history)?,
        Record::Cleaning { .. } | Record::Cleaned { .. } => phrase::turned(record, history)?,
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => phrase::turned(record, history)?,
        Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => phrase::turned(record, history)?,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } => phrase::turned(record, history)?,
        Record::Declined { .. } | Record::Checkpoint { .. } => phrase::turned(record, history)?,
        Record::Woke { leaves, .. } => phrase::asking_again(leaves, history),
        Record::Controller { controller, message, .. } => of_controller(history, *controller, message)?,
        Record::Ended { end, .. } => ended(history, *end),
    };
    Some(text)
}

fn begins(history: &History, header: &Header) -> String {
    let Header { mission, robot, allocator, .. } = header;
    format!("{mission}: {} on {robot}, {allocator}", count(history.counts(NodeId(0)).of, "behavior"))
}

fn decided(history: &History, granted: &[Grant], reopened: Option<&Reopened>) -> Option<String> {
    let names = history.names();
    let mut parts = Vec::new();
    if !granted.is_empty() {
        let grants: Vec<String> = granted.iter().map(|grant| granting(grant, names)).collect();
        parts.push(format!("step {}: {}", history.step_count(), grants.join(", ")));
        parts.extend(skipped(history));
    }
    if let Some(reopened) = reopened {
        let leaf = names.node(reopened.node);
        parts.push(match reopened.lapsed() {
            Some(resource) => format!("reopened {leaf}, {} lapsed", names.resource(resource)),
            None => format!("reopened {leaf}"),
        });
    }
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// What was found done without running at this moment.
fn skipped(history: &History) -> Option<String> {
    let skipped = history.skipped();
    let now: Vec<&str> = skipped
        .iter()
        .filter(|(_, when)| *when == history.now())
        .map(|(leaf, _)| history.names().node(*leaf))
        .collect();
    (!now.is_empty()).then(|| format!("skipped {}", now.join(", ")))
}

fn of_controller(history: &History, controller: ControllerId, message: &ControllerMessage) -> Option<String> {
    let names = history.names();
    let name = names.controller(controller);
    match message {
        ControllerMessage::Attached => Some(format!("attached {name}")),
        // Of a mission that goes on root says what follows from it.
        ControllerMessage::Lost { .. } if history.state_of_run().stage() == Stage::Running => None,
        ControllerMessage::Lost { why } => Some(format!("lost {name}: {why}")),
        ControllerMessage::Refused { why, .. } => Some(format!("refused a message of {name}: {why}")),
        ControllerMessage::Misreported { report, why } => {
            Some(format!("{name} reports that {report}, which is not heard: {why}"))
        }
        ControllerMessage::Heard { message: FromController::Rejected { id, why } } => {
            let command = history.controllers().command(controller, *id);
            let goal = command.and_then(|command| command.leaves.first()).map_or("a goal", |leaf| names.node(*leaf));
            Some(format!("{name} rejected {goal}: {why}"))
        }
        ControllerMessage::Heard { .. } | ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } => None,
        ControllerMessage::Diagnosed { .. } => None,
    }
}

fn ended(history: &History, end: MissionEnd) -> String {
    let text = mission_ended(end, history.names());
    if end != MissionEnd::Done {
        return text;
    }
    let skipped = skipped(history).map_or(String::new(), |skipped| format!("; {skipped}"));
    format!("{text} in {}{skipped}", count(history.step_count(), "step"))
}

/// A behavior with all that it has, in resource order.
fn granting(grant: &Grant, names: &Names) -> String {
    let name = names.node(grant.leaf());
    let resources: BTreeSet<ResourceId> = grant.bindings.iter().map(|binding| binding.resource).collect();
    let resources: Vec<&str> = resources.into_iter().map(|resource| names.resource(resource)).collect();
    match resources.len() {
        0 => name.to_owned(),
        _ => format!("{name} ({})", resources.join(", ")),
    }
}

fn released(leaf: NodeId, end: End, names: &Names) -> String {
    let leaf = names.node(leaf);
    match end {
        End::Succeeded => format!("done {leaf}"),
        End::Canceled => format!("canceled {leaf}"),
        End::Interrupted => format!("interrupted {leaf}"),
        End::Failed(fault) => format!("failed {leaf}: {}", fault.sentence(names)),
    }
}

/// The base moves all the time, which is no news.
fn changed(change: &Change, origin: Origin, names: &Names) -> Option<String> {
    let is_base = matches!(change, Change::Base(_));
    (!is_base).then(|| phrase::changed_by(change, origin, names))
}
