//! One plain line per event, for logs and terminals whose lines stay.

use std::fmt::Write;

use crate::phrase::{self, fault_sentence};
use crate::text::count;
use ambidex_model::{
    Access, Change, CommandId, ControllerId, ControllerMessage, End, FromController, Grant, Header, MissionEnd, Names,
    NodeId, Record, Rejection, Reopened, Time,
};

use super::Progress;

impl Progress {
    /// The line for a record that was just added; none for what only a log tells.
    pub fn plain_line(&self, record: &Record) -> Option<String> {
        let names = &self.tally.header.as_ref()?.names;
        let (at, text) = match record {
            Record::Header(header) => (Time::ZERO, self.begins(header)),
            Record::Sent { .. } | Record::Resource { .. } => return None,
            Record::Decided { at, granted, reopened, .. } => {
                (*at, self.decided(*at, granted, reopened.as_ref(), names)?)
            }
            Record::Released { at, leaf, end, .. } => (*at, released(*leaf, *end, names)),
            Record::World { at, change } => (*at, changed(change, names)?),
            Record::Controller { at, controller, message } => (*at, self.said(*controller, message, names)?),
            Record::Ended { at, end } => (*at, self.ended(*at, *end, names)),
        };
        Some(format!("{:>7.2} s  {text}", at.seconds()))
    }

    fn begins(&self, header: &Header) -> String {
        let behaviors = count(self.behaviors, "behavior");
        let Header { mission, robot, allocator, .. } = header;
        format!("{mission}: {behaviors} on {robot}, {allocator}")
    }

    fn decided(&self, at: Time, granted: &[Grant], reopened: Option<&Reopened>, names: &Names) -> Option<String> {
        let mut parts = Vec::new();
        if !granted.is_empty() {
            let grants: Vec<String> = granted.iter().map(|grant| granting(grant, names)).collect();
            parts.push(format!("step {}: {}", self.tally.steps.len(), grants.join(", ")));
        }
        if !granted.is_empty() {
            parts.extend(self.skipped(at, names));
        }
        if let Some(reopened) = reopened {
            let leaf = names.node(reopened.leaf);
            parts.push(match reopened.lapsed {
                Some(resource) => format!("reopened {leaf}, {} lapsed", names.resource(resource)),
                None => format!("reopened {leaf}"),
            });
        }
        (!parts.is_empty()).then(|| parts.join("; "))
    }

    /// What was found done without running at this moment.
    fn skipped(&self, at: Time, names: &Names) -> Option<String> {
        let now = self.tally.skipped.iter().rev().take_while(|(_, when)| *when == at);
        let mut skipped: Vec<&str> = now.map(|(leaf, _)| names.node(*leaf)).collect();
        skipped.reverse();
        (!skipped.is_empty()).then(|| format!("skipped {}", skipped.join(", ")))
    }

    fn said(&self, controller: ControllerId, message: &ControllerMessage, names: &Names) -> Option<String> {
        let name = names.controller(controller);
        match message {
            ControllerMessage::Attached => Some(format!("attached {name}")),
            ControllerMessage::Lost { .. } => Some(format!("lost {name}")),
            ControllerMessage::Refused { why, .. } => Some(format!("refused a message of {name}: {why}")),
            ControllerMessage::Heard { message } => match message {
                FromController::Rejected { id, why } => Some(self.rejected(controller, *id, *why, names)),
                FromController::Configured { .. }
                | FromController::Accepted { .. }
                | FromController::Feedback { .. }
                | FromController::Result { .. } => None,
            },
            ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } => None,
        }
    }

    fn rejected(&self, controller: ControllerId, id: CommandId, why: Rejection, names: &Names) -> String {
        let command = self.crew.command(controller, id);
        let goal = match command.and_then(|command| command.leaves.first()) {
            Some(leaf) => names.node(*leaf),
            None => "a goal",
        };
        format!("{} rejected {goal}: {why}", names.controller(controller))
    }

    fn ended(&self, at: Time, end: MissionEnd, names: &Names) -> String {
        let mut text = phrase::mission_ended(end, names);
        if end == MissionEnd::Done {
            let _ = write!(text, " in {}", count(self.tally.steps.len(), "step"));
        }
        let skipped = (end == MissionEnd::Done).then(|| self.skipped(at, names)).flatten();
        match skipped {
            Some(skipped) => format!("{text}; {skipped}"),
            None => text,
        }
    }
}

/// A behavior with the resources that it has alone, or with all where it has none alone.
fn granting(grant: &Grant, names: &Names) -> String {
    let name = names.node(grant.leaf());
    let alone = grant.bindings.iter().filter(|binding| binding.access == Access::Exclusive);
    let mut resources: Vec<&str> = alone.map(|binding| names.resource(binding.resource)).collect();
    if resources.is_empty() {
        let all = grant.bindings.iter();
        resources = all.map(|binding| names.resource(binding.resource)).collect();
    }
    match resources.len() {
        0 => name.to_owned(),
        _ => format!("{name} ({})", resources.join(", ")),
    }
}

fn released(leaf: NodeId, end: End, names: &Names) -> String {
    let leaf = names.node(leaf);
    match end {
        End::Succeeded => format!("done {leaf}"),
        End::Canceled => format!("cancelled {leaf}"),
        End::Failed(fault) => format!("failed {leaf}: {}", fault_sentence(fault, names)),
    }
}

/// The base moves all the time, which is no news.
fn changed(change: &Change, names: &Names) -> Option<String> {
    let is_base = matches!(change, Change::Base(_));
    (!is_base).then(|| phrase::changed(change, names))
}
