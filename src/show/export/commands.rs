//! Commands of controllers, from the telling to the last word on them.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

use ambidex_model::{
    Command, CommandId, ControllerId, ControllerMessage, FromController, Loss, Mode, NodeId, PartEnd, Record,
    Rejection, Time, ToController,
};
use ambidex_record::{History, format};

/// A command that a controller was told.
#[derive(Debug, Clone)]
pub(super) struct CommandSpan {
    /// Who was told.
    pub(super) controller: ControllerId,
    /// Its identity.
    pub(super) id: CommandId,
    /// The behaviors that it is for, the first of them first.
    pub(super) leaves: Vec<NodeId>,
    /// Whether it ends its behavior or lasts as long.
    pub(super) mode: Mode,
    /// What to do.
    pub(super) command: Command,
    /// Commands of one controller at the same time have different tracks; the lowest free one is taken.
    pub(super) track: usize,
    /// When it was told.
    pub(super) told: Time,
    /// When it was taken.
    pub(super) accepted: Option<Time>,
    /// When it was told to stop.
    pub(super) canceled: Option<Time>,
    /// How long it took by the controller's own clock, seconds.
    pub(super) took_s: Option<f64>,
    /// When and how it ended; none where it goes on when the log ends.
    pub(super) ended: Option<(Time, CommandEnd)>,
}

/// The last word on a command.
#[derive(Debug, Clone, Copy)]
pub(super) enum CommandEnd {
    /// Its controller says so.
    Ended(PartEnd),
    /// Its controller did not take it.
    Rejected(Rejection),
    /// Its controller was gone.
    Lost(Loss),
}

impl CommandEnd {
    /// The word for it.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Ended(end) => format::part_end(end),
            Self::Rejected(_) => "rejected",
            Self::Lost(_) => "lost",
        }
    }
}

impl Display for CommandEnd {
    /// Why; nothing where there is nothing to say.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ended(PartEnd::Inhibited(why)) => why.fmt(f),
            Self::Ended(PartEnd::Succeeded | PartEnd::Aborted | PartEnd::Canceled) => Ok(()),
            Self::Rejected(why) => why.fmt(f),
            Self::Lost(why) => why.fmt(f),
        }
    }
}

/// What becomes of commands with a record.
#[derive(Debug)]
pub(super) enum Step {
    /// One was told.
    Begun(CommandSpan),
    /// A further behavior shares one.
    Joined(CommandSpan, NodeId),
    /// One ended.
    Ended(CommandSpan),
}

/// The commands that are under way.
#[derive(Debug, Default)]
pub(super) struct Commands {
    open: BTreeMap<(ControllerId, CommandId), CommandSpan>,
}

impl Commands {
    /// Takes the next record, which the history has not taken yet.
    pub(super) fn take(&mut self, before: &History, record: &Record) -> Vec<Step> {
        let Record::Controller { controller, message, .. } = record else { return Vec::new() };
        let now = before.moment(record.at());
        match message {
            ControllerMessage::Told { leaf, message } => self.told(now, *controller, *leaf, message),
            ControllerMessage::Joined { leaf, id } => {
                let Some(span) = self.open.get_mut(&(*controller, *id)) else { return Vec::new() };
                span.leaves.push(*leaf);
                vec![Step::Joined(span.clone(), *leaf)]
            }
            ControllerMessage::Heard { message } => self.heard(now, *controller, message),
            ControllerMessage::Lost { why } => {
                let lost = self.open.extract_if(.., |(of, _), _| of == controller);
                lost.map(|(_, span)| ended(span, now, CommandEnd::Lost(*why))).collect()
            }
            ControllerMessage::Attached | ControllerMessage::Refused { .. } => Vec::new(),
            ControllerMessage::Misreported { .. } | ControllerMessage::Diagnosed { .. } => Vec::new(),
        }
    }

    /// What goes on.
    pub(super) fn into_open(self) -> impl Iterator<Item = CommandSpan> {
        self.open.into_values()
    }

    fn told(&mut self, now: Time, to: ControllerId, leaf: Option<NodeId>, message: &ToController) -> Vec<Step> {
        match message {
            ToController::Configure { .. } => Vec::new(),
            ToController::Goal { id, mode, command } => {
                let span = CommandSpan {
                    controller: to,
                    id: *id,
                    leaves: leaf.into_iter().collect(),
                    mode: *mode,
                    command: command.clone(),
                    track: self.free_track(to),
                    told: now,
                    accepted: None,
                    canceled: None,
                    took_s: None,
                    ended: None,
                };
                self.open.insert((to, *id), span.clone());
                vec![Step::Begun(span)]
            }
            ToController::Cancel { id } => {
                if let Some(span) = self.open.get_mut(&(to, *id)) {
                    span.canceled.get_or_insert(now);
                }
                Vec::new()
            }
        }
    }

    fn free_track(&self, of: ControllerId) -> usize {
        let taken = || self.open.values().filter(|span| span.controller == of).map(|span| span.track);
        (0..).find(|track| taken().all(|other| other != *track)).unwrap_or_default()
    }

    fn heard(&mut self, now: Time, from: ControllerId, message: &FromController) -> Vec<Step> {
        match message {
            FromController::Configured { .. } | FromController::Feedback { .. } => Vec::new(),
            FromController::Accepted { id, .. } => {
                if let Some(span) = self.open.get_mut(&(from, *id)) {
                    span.accepted.get_or_insert(now);
                }
                Vec::new()
            }
            FromController::Rejected { id, why } => self.end(now, from, *id, CommandEnd::Rejected(*why), None),
            FromController::Result { id, end, began, ended, .. } => {
                let took_s = ended.since(*began).as_secs_f64();
                self.end(now, from, *id, CommandEnd::Ended(*end), Some(took_s))
            }
        }
    }

    fn end(&mut self, now: Time, of: ControllerId, id: CommandId, how: CommandEnd, took_s: Option<f64>) -> Vec<Step> {
        let span = self.open.remove(&(of, id));
        span.map(|span| ended(CommandSpan { took_s, ..span }, now, how)).into_iter().collect()
    }
}

fn ended(span: CommandSpan, now: Time, how: CommandEnd) -> Step {
    Step::Ended(CommandSpan { ended: Some((now, how)), ..span })
}
