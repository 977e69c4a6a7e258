//! What the records tell of the controllers: who is there, what each was told to do, and what it said last.

use std::collections::BTreeMap;

use ambidex_model::{
    Command, CommandId, ControllerId, ControllerMessage, Diagnostics, FromController, Misreport, Mode, NodeId, PartEnd,
    Rejection, Report, Time, ToController,
};

type Key = (ControllerId, CommandId);

/// Every controller that was ever there, and what each does.
#[derive(Debug, Clone, Default)]
pub struct Controllers {
    views: BTreeMap<ControllerId, ControllerView>,
    commands: BTreeMap<Key, ActiveCommand>,
    /// What the last record ended.
    ended: Option<(Key, ActiveCommand)>,
    speed: Option<f64>,
    /// Why what each said last of all that is not used was not, whether it was ever there or not.
    refused: BTreeMap<ControllerId, Rejection>,
    /// How well each was said to be last, and since when.
    diagnoses: BTreeMap<ControllerId, (Time, Diagnostics)>,
}

/// How far a controller's attachment is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// It is there and was not heard of yet.
    Attached,
    /// It answered its configuration.
    Configured,
    /// It is gone.
    Lost,
}

/// What went wrong with a controller last, until it takes a goal again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LastError {
    /// It would not take the goal of these behaviors.
    Rejected {
        /// For whom the goal was; nobody where that is not known.
        leaves: Vec<NodeId>,
        /// Why it would not.
        why: Rejection,
    },
    /// It gave up the goal of these behaviors.
    Aborted {
        /// For whom the goal was.
        leaves: Vec<NodeId>,
    },
    /// What it said was not used.
    Refused(Rejection),
    /// What it said of the world was not heard.
    Misreported {
        /// What it said.
        report: Report,
        /// Why it was not.
        why: Misreport,
    },
}

/// A controller that was ever there.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerView {
    /// How far its attachment is.
    pub presence: Presence,
    /// What went wrong last.
    pub error: Option<LastError>,
    /// Since when it has been silent, or lost.
    pub since: Time,
}

/// A command that a controller was given and has not ended.
#[derive(Debug, Clone, PartialEq)]
pub struct ActiveCommand {
    /// The behaviors that it is for, the first of them first; the last one stays when it has ended.
    pub leaves: Vec<NodeId>,
    /// Whether any of them still runs.
    pub is_held: bool,
    /// Whether it ends its behavior or lasts as long.
    pub mode: Mode,
    /// What it does: `driving`, `grasping`.
    pub verb: &'static str,
    /// How far it is, from 0 to 1.
    pub progress: f64,
    /// Whether it was told to stop.
    pub is_canceled: bool,
}

impl ActiveCommand {
    /// The behaviors that need it, the first of them first.
    pub fn holders(&self) -> &[NodeId] {
        if self.is_held { &self.leaves } else { &[] }
    }
}

impl Controllers {
    /// A controller; none that was never there.
    pub fn view(&self, controller: ControllerId) -> Option<&ControllerView> {
        self.views.get(&controller)
    }

    /// Why something that a controller said was not used, the last time.
    pub fn refusal(&self, controller: ControllerId) -> Option<Rejection> {
        self.refused.get(&controller).copied()
    }

    /// How well a controller was when that came to be different last, and when it did; none that was not diagnosed.
    pub fn diagnostics(&self, controller: ControllerId) -> Option<(Time, &Diagnostics)> {
        self.diagnoses.get(&controller).map(|(at, diagnostics)| (*at, diagnostics))
    }

    /// Robot seconds per wall second, once a controller was told.
    pub fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// A command that has not ended, or that the last record ended.
    pub fn command(&self, controller: ControllerId, id: CommandId) -> Option<&ActiveCommand> {
        let key = (controller, id);
        let ended = self.ended.as_ref().filter(|(ended, _)| *ended == key).map(|(_, command)| command);
        self.commands.get(&key).or(ended)
    }

    /// What a controller does, the oldest first.
    pub fn commands(&self, controller: ControllerId) -> impl DoubleEndedIterator<Item = &ActiveCommand> {
        let (first, last) =
            (CommandId { generation: 0, number: 0 }, CommandId { generation: u32::MAX, number: u32::MAX });
        self.commands.range((controller, first)..=(controller, last)).map(|(_, command)| command)
    }

    /// How far a running behavior is: the least of the commands that end it.
    pub fn progress(&self, leaf: NodeId) -> Option<f64> {
        let commands = self.commands.values().filter(|command| command.mode == Mode::Achieve);
        commands.filter(|command| command.holders().contains(&leaf)).map(|command| command.progress).reduce(f64::min)
    }

    /// The next record is not about what the last one ended.
    pub(super) fn forget_ended(&mut self) {
        self.ended = None;
    }

    /// The runtime was gone: nobody is attached to the one that goes on, and nothing that was under way is.
    pub(super) fn begin_anew(&mut self) {
        self.views.clear();
        self.commands.clear();
    }

    /// Takes the next message.
    pub(super) fn apply(&mut self, at: Time, controller: ControllerId, message: &ControllerMessage) {
        match message {
            ControllerMessage::Attached => self.is_now(at, controller, Presence::Attached),
            ControllerMessage::Lost { .. } => {
                self.is_now(at, controller, Presence::Lost);
                self.commands.retain(|(owner, _), _| *owner != controller);
            }
            ControllerMessage::Told { leaf, message } => self.told(at, controller, *leaf, message),
            ControllerMessage::Joined { leaf, id } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    if !std::mem::replace(&mut command.is_held, true) {
                        command.leaves.clear();
                    }
                    command.leaves.push(*leaf);
                }
            }
            ControllerMessage::Heard { message } => self.heard(at, controller, message),
            ControllerMessage::Refused { why, .. } => {
                self.refused.insert(controller, *why);
                self.fail(controller, Some(LastError::Refused(*why)));
            }
            ControllerMessage::Misreported { report, why } => {
                self.fail(controller, Some(LastError::Misreported { report: *report, why: *why }));
            }
            ControllerMessage::Diagnosed { level, message, values } => {
                let diagnostics = Diagnostics { controller, level: *level, message: *message, values: **values };
                self.diagnoses.insert(controller, (at, diagnostics));
            }
        }
    }

    /// Takes the end of a behavior: nobody works for it any more.
    pub(super) fn release(&mut self, leaf: NodeId) {
        for command in self.commands.values_mut() {
            match command.leaves.as_slice() {
                [only] => command.is_held &= *only != leaf,
                _ => command.leaves.retain(|holder| *holder != leaf),
            }
        }
    }

    fn is_now(&mut self, at: Time, controller: ControllerId, presence: Presence) {
        self.views.insert(controller, ControllerView { presence, error: None, since: at });
    }

    fn fail(&mut self, controller: ControllerId, error: Option<LastError>) {
        if let Some(view) = self.views.get_mut(&controller) {
            view.error = error;
        }
    }

    fn told(&mut self, at: Time, controller: ControllerId, leaf: Option<NodeId>, message: &ToController) {
        match message {
            ToController::Configure { speed, .. } => self.speed = Some(*speed),
            ToController::Goal { id, mode, command } => {
                let was_idle = self.commands(controller).next().is_none();
                if let Some(view) = self.views.get_mut(&controller).filter(|_| was_idle) {
                    view.since = at;
                }
                let leaves: Vec<NodeId> = leaf.into_iter().collect();
                let (is_held, mode, verb) = (!leaves.is_empty(), *mode, verb(command));
                let command = ActiveCommand { leaves, is_held, mode, verb, progress: 0.0, is_canceled: false };
                self.commands.insert((controller, *id), command);
            }
            ToController::Cancel { id } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    command.is_canceled = true;
                }
            }
        }
    }

    fn heard(&mut self, at: Time, controller: ControllerId, message: &FromController) {
        if let Some(view) = self.views.get_mut(&controller) {
            view.since = at;
        }
        match message {
            FromController::Configured { .. } => self.is_now(at, controller, Presence::Configured),
            FromController::Accepted { .. } => self.fail(controller, None),
            FromController::Rejected { id, why } => {
                if let Some(leaves) = self.end(controller, *id) {
                    self.fail(controller, Some(LastError::Rejected { leaves, why: *why }));
                }
            }
            FromController::Feedback { id, progress, .. } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    command.progress = progress.clamp(0.0, 1.0);
                }
            }
            FromController::Result { id, end, .. } => match (self.end(controller, *id), end) {
                (Some(leaves), PartEnd::Aborted) => self.fail(controller, Some(LastError::Aborted { leaves })),
                (Some(_), PartEnd::Succeeded | PartEnd::Canceled | PartEnd::Inhibited(_)) | (None, _) => {}
            },
        }
    }

    /// A command is over; for whom it was.
    fn end(&mut self, controller: ControllerId, id: CommandId) -> Option<Vec<NodeId>> {
        let key = (controller, id);
        let command = self.commands.remove(&key)?;
        let leaves = command.holders().to_vec();
        self.ended = Some((key, command));
        Some(leaves)
    }
}

fn verb(command: &Command) -> &'static str {
    match command {
        Command::Drive { .. } => "driving",
        Command::Stand => "standing",
        Command::Grasp { .. } => "grasping",
        Command::Put { .. } => "putting",
        Command::Look { .. } => "looking",
        Command::Call(_) => "busy with a call",
    }
}
