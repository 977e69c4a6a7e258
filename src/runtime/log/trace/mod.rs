//! Tracing events, all made here, from records and from the diagnoses of each second. Fields are evaluated only where a subscriber wants the event.

mod controller;
mod mission;
mod tasks;
mod tree;

#[cfg(test)]
mod tests;

use ambidex_model::{Diagnostics, Names, Record, Time};

/// Target of messages between nodes.
const TREE: &str = "ambidex::tree";
/// Target of messages between the runtime and controllers.
const CONTROLLER: &str = "ambidex::controller";
/// Target of how well controllers are.
const DIAGNOSTICS: &str = "ambidex::diagnostics";
/// Target of what becomes of a mission: rounds, ends of goals, changes of the world.
const MISSION: &str = "ambidex::mission";

/// Makes the tracing event of a record; times are robot seconds in the field `at_s`.
///
/// ERROR: broken. WARN: refused, rejected, lost, failed. INFO: granted rounds, ends of goals and of the mission,
/// attachments. DEBUG: a leaf's own answer, other decisions. TRACE: every other message.
pub fn emit(record: &Record, names: &Names) {
    match record {
        Record::Header(header) => mission::started(header),
        Record::Sent { at, round, from, to, message } => {
            let edge = tree::Edge { at_s: at.seconds(), round: *round, from: *from, to: *to };
            tree::sent(&edge, message, names);
        }
        Record::Decided { at, round, granted, refused, reopened, .. } => {
            mission::decided(at.seconds(), *round, granted, refused.len(), names);
            if let Some(reopened) = reopened {
                mission::reopened(at.seconds(), Some(*round), reopened, names);
            }
        }
        Record::Released { at, leaf, end, consequences, changes, .. } => {
            mission::released(at.seconds(), *leaf, *end, *consequences, changes, names)
        }
        // What they say comes again in what root does of it.
        Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => {}
        Record::Stopped { at, leaves, cause } => mission::stopped(at.seconds(), leaves, cause, names),
        Record::Ending { at, end, .. } => mission::ending(at.seconds(), *end),
        Record::Leaving { at, way } => mission::leaving(at.seconds(), *way, names),
        Record::Cleaning { at, node } => mission::cleaning(at.seconds(), *node, names),
        Record::Cleaned { at, node, is_done, .. } => mission::cleaned(at.seconds(), *node, *is_done, names),
        Record::World { at, change, origin } => mission::changed(at.seconds(), change, *origin, names),
        Record::Denied { at, change, origin, why } => mission::denied(at.seconds(), change, *origin, *why, names),
        Record::Resource { at, resource, state } => mission::used(at.seconds(), *resource, state, names),
        Record::Woke { at, leaves } => mission::woke(at.seconds(), leaves, names),
        Record::Served { at, controller, service, .. } => mission::served(at.seconds(), *controller, *service, names),
        Record::Awaited { at, until, facts, places } if facts.is_empty() && places.is_empty() => {
            mission::awaited(at.seconds(), until.map(Time::seconds));
        }
        Record::Awaited { at, facts, places, .. } => mission::expected(at.seconds(), facts, places, names),
        Record::Infeasible { at, leaf, reason, .. } => mission::infeasible(at.seconds(), *leaf, reason, names),
        Record::TimedOut { at, node, .. } => mission::timed_out(at.seconds(), *node, names),
        Record::Reopened { at, reopened } => mission::reopened(at.seconds(), None, reopened, names),
        Record::Overtaken { at, leaf, goal, .. } => mission::overtaken(at.seconds(), *leaf, *goal, names),
        Record::Added { at, top, names: added, task, .. } => {
            let name = task.as_ref().map(|task| task.name.as_str()).or(added.first().map(String::as_str));
            tasks::added(at.seconds(), top.0, name.unwrap_or("?"), task.is_some());
        }
        Record::Checkpoint { .. } => {}
        Record::Removed { at, node } => tasks::removed(at.seconds(), *node, names),
        Record::Granting { at, task, granting } => tasks::granting(at.seconds(), *task, *granting, names),
        Record::Canceled { at, task, .. } => tasks::canceled(at.seconds(), *task, names),
        Record::TaskEnded { at, task, end } => tasks::ended(at.seconds(), *task, *end, names),
        Record::Stalled { at, tasks, .. } => tasks::stalled(at.seconds(), tasks, names),
        Record::ObjectAdded { at, name, place, .. } => tasks::object_added(at.seconds(), name, *place, names),
        Record::ObjectRemoved { at, object } => tasks::object_removed(at.seconds(), *object, names),
        Record::Declined { at, number, why } => tasks::declined(at.seconds(), *number, *why, names),
        Record::Controller { at, controller, message } => {
            controller::said(at.seconds(), names.controller(*controller), message, names)
        }
        Record::Ended { at, end } => mission::ended(at.seconds(), *end, names),
    }
}

/// Makes the tracing event of a diagnosis. INFO: the level is another one. DEBUG: any other second.
pub(crate) fn diagnosed(at: Time, diagnostics: &Diagnostics, is_change: bool, names: &Names) {
    controller::diagnosed(at.seconds(), diagnostics, is_change, names.controller(diagnostics.controller));
}
