//! A journal as a conversation: who says what to whom, one line per record, for people or as JSON with names.

mod controller;
mod json;
mod kind;
mod nodes;
mod selection;
mod subjects;

#[cfg(test)]
mod tests;

use std::borrow::Cow;

use anstyle::Style;

use ambidex_model::{ControllerMessage, FromController, Header, Names, NodeId, PartEnd, Record, StopCause, Time};
use ambidex_record::History;

use crate::Palette;
use crate::text::{columns, count, ended, mission_ended, phrase};
pub use json::json;
pub use kind::Kind;
pub use selection::{Filters, Selection};

/// Widest column of names; longer names stand out of line.
const MAX_NAME: usize = 24;

/// What the runtime is called where it talks to a controller for no behavior.
const DISPATCH: &str = "dispatch";

/// The records of a journal in order, and what is needed of the earlier ones to tell the later.
#[derive(Debug, Clone)]
pub struct Conversation {
    history: History,
    selection: Selection,
    name_columns: usize,
}

/// What a record says, before it is laid out.
struct Line<'a> {
    round: Option<u32>,
    from: Cow<'a, str>,
    to: Option<Cow<'a, str>>,
    said: String,
}

impl Conversation {
    /// Nothing was said yet.
    pub fn new(header: &Header, selection: Selection) -> Self {
        let Names { nodes, resources, controllers, .. } = &header.names;
        let all = nodes.iter().chain(resources).chain(controllers);
        let longest = all.map(|name| columns(name)).chain([DISPATCH.len()]).max().unwrap_or_default();
        Self { history: History::new(header), selection, name_columns: longest.min(MAX_NAME) }
    }

    /// Takes the next record; true if it is wanted.
    pub fn take(&mut self, record: &Record) -> bool {
        self.history.apply(record);
        let round = if let Record::Sent { round, .. } = record { *round } else { self.history.rounds() };
        self.selection.has(record, round, &self.history)
    }

    /// The record that was just taken as one line, without its end; its time is since the mission began.
    pub fn line(&self, record: &Record, palette: &Palette) -> String {
        if let Record::Header(header) = record {
            return Palette::paint(palette.strong, begins(header));
        }
        let Line { round, from, to, said } = self.told(record);
        let width = self.name_columns;
        let round = round.map_or(String::new(), |round| format!("r{round}"));
        let arrow = if to.is_some() { '→' } else { ' ' };
        let head = format!("{} {round:>5}", time(self.history.now()));
        let pair = format!("{from:>width$} {arrow} {:<width$}", to.unwrap_or_default());
        let said = Palette::paint(style(record, palette), said);
        format!("{}  {pair}  {said}", Palette::paint(palette.faint, head))
    }

    /// The record as [`json`] has it.
    ///
    /// # Errors
    /// Never with a record that came out of a journal.
    pub fn json(&self, record: &Record) -> serde_json::Result<String> {
        json(record, self.history.names())
    }

    fn told(&self, record: &Record) -> Line<'_> {
        let names = self.history.names();
        let root = Cow::from(names.node(NodeId(0)));
        let line = |from, said| Line { round: None, from, to: None, said };
        match record {
            Record::Header(header) => line(root, begins(header)),
            Record::Sent { round, from, to, message, .. } => Line {
                round: Some(*round),
                from: names.node(*from).into(),
                to: Some(names.node(*to).into()),
                said: nodes::said(*from, *to, message, names),
            },
            Record::Decided { round, granted, refused, reopened, .. } => {
                let said = nodes::decided(granted, refused, reopened.as_ref(), names);
                Line { round: Some(*round), ..line(root, said) }
            }
            Record::Told { input, .. } => Line { to: Some(root), ..line("world".into(), nodes::told(input, names)) },
            Record::Observed { change, .. } => line(root, phrase::changed(change, names)),
            Record::Turn { .. } => line(root, "takes up what it was told".into()),
            Record::Began { .. } => line(root, "the mission begins".into()),
            Record::Stopped { leaves, cause: StopCause::Ends, .. } => line(root, nodes::stopping(leaves, names)),
            Record::Ending { end, .. } => line(root, format!("the mission is to end: {}", mission_ended(*end, names))),
            Record::Released { leaf, end, consequences, changes, .. } => {
                line(root, nodes::released(*leaf, *end, *consequences, changes, names))
            }
            Record::World { change, origin, .. } => line("world".into(), phrase::changed_by(change, *origin, names)),
            Record::Denied { change, origin, why, .. } => line(root, phrase::denied(change, *origin, *why, names)),
            Record::Woke { leaves, .. } => line(root, phrase::asking_again(leaves, &self.history)),
            Record::Served { controller, service, .. } => line(root, phrase::served(*controller, *service, names)),
            Record::Awaited { until, facts, places, .. } => line(root, phrase::awaited(*until, facts, places, names)),
            Record::Infeasible { .. }
            | Record::TimedOut { .. }
            | Record::Reopened { .. }
            | Record::Stopped { .. }
            | Record::Leaving { .. }
            | Record::Cleaning { .. }
            | Record::Cleaned { .. }
            | Record::Added { .. }
            | Record::Removed { .. }
            | Record::Granting { .. }
            | Record::Canceled { .. }
            | Record::TaskEnded { .. }
            | Record::Stalled { .. }
            | Record::ObjectAdded { .. }
            | Record::ObjectRemoved { .. }
            | Record::Declined { .. }
            | Record::Checkpoint { .. }
            | Record::Overtaken { .. } => line(root, phrase::turned(record, &self.history).unwrap_or_default()),
            Record::Resource { resource, state, .. } => {
                line(names.resource(*resource).into(), nodes::used(state, names))
            }
            Record::Controller { controller, message, .. } => {
                let (said, is_heard) = controller::said(message, names);
                let (one, other) = (self.spoken_for(record), names.controller(*controller).into());
                let (from, to) = if is_heard { (other, one) } else { (one, other) };
                Line { round: None, from, to: Some(to), said }
            }
            Record::Ended { end, .. } => line(root, format!("the mission is over: {}", mission_ended(*end, names))),
        }
    }

    /// Who of the runtime talks with a controller: behaviors, or dispatch itself.
    fn spoken_for(&self, record: &Record) -> Cow<'_, str> {
        let Record::Controller { controller, message, .. } = record else {
            return DISPATCH.into();
        };
        let names = self.history.names();
        if let Some(leaf) = message.leaf() {
            return names.node(leaf).into();
        }
        match subjects::behaviors(*controller, message, &self.history) {
            [] => DISPATCH.into(),
            [only] => names.node(*only).into(),
            many => many.iter().map(|leaf| names.node(*leaf)).collect::<Vec<_>>().join(" + ").into(),
        }
    }
}

/// A record as JSON with names where the journal has ids.
pub(crate) fn with_names(record: &Record, names: &Names) -> String {
    json::json(record, names).expect("a record is plain")
}

/// A moment in a column of its own.
fn time(at: Time) -> String {
    format!("{:>9.3} s", at.seconds())
}

fn begins(header: &Header) -> String {
    let Header { mission, robot, allocator, nodes, .. } = header;
    let behaviors = nodes.iter().filter(|node| node.kind.is_behavior()).count();
    format!("{mission} on {robot}, {allocator}: {} with {}", count(nodes.len(), "node"), count(behaviors, "behavior"))
}

/// Colors for what a person looks for; what only repeats is faint.
fn style(record: &Record, palette: &Palette) -> Style {
    let of_end = |end| palette.of(ended(end));
    match record {
        Record::Sent { message, .. } => nodes::style(message, palette, of_end),
        Record::Decided { granted, .. } if granted.is_empty() => palette.waiting,
        Record::Decided { .. } => palette.active,
        Record::Released { end, .. } => of_end(*end),
        Record::Controller { message, .. } => match message {
            ControllerMessage::Lost { .. } | ControllerMessage::Refused { .. } => palette.failed,
            ControllerMessage::Misreported { .. } => palette.failed,
            ControllerMessage::Diagnosed { .. } => palette.faint,
            ControllerMessage::Heard { message } => match message {
                FromController::Rejected { .. } | FromController::Result { end: PartEnd::Aborted, .. } => {
                    palette.failed
                }
                FromController::Feedback { .. } | FromController::Accepted { .. } => palette.faint,
                FromController::Configured { .. } | FromController::Result { .. } => Style::new(),
            },
            ControllerMessage::Attached | ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } => {
                Style::new()
            }
        },
        Record::Header(_) | Record::Ended { .. } => palette.strong,
        Record::Stopped { .. } | Record::Ending { .. } => palette.canceled,
        Record::Leaving { .. } | Record::Cleaning { .. } => palette.active,
        Record::Cleaned { is_done: false, .. } => palette.failed,
        Record::Cleaned { .. } => Style::new(),
        Record::Awaited { .. } | Record::Reopened { .. } | Record::Denied { .. } => palette.waiting,
        Record::Infeasible { .. } | Record::TimedOut { .. } => palette.failed,
        Record::Overtaken { .. } => palette.active,
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => palette.strong,
        Record::Canceled { .. } => palette.canceled,
        Record::TaskEnded { end, .. } => palette.of(crate::text::of_end(ambidex_record::MissionOutcome::from(*end))),
        Record::Stalled { .. } | Record::Declined { .. } => palette.waiting,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } | Record::Checkpoint { .. } => Style::new(),
        Record::Served { service, .. } if !service.is_available() => palette.failed,
        Record::Woke { .. } | Record::Served { .. } => Style::new(),
        Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } => palette.faint,
        Record::World { .. } | Record::Resource { .. } | Record::Began { .. } => Style::new(),
    }
}
