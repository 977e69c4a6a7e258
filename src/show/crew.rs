//! What the records tell of the controllers: who is there, what each was told to do, and what it said last.

use std::collections::BTreeMap;

use ambidex_model::{
    Command, CommandId, ControllerId, ControllerMessage, FromController, Mode, NodeId, PartEnd, Rejection, Time,
    ToController,
};

/// A running fold of the messages between the runtime and its controllers.
#[derive(Debug, Clone, Default)]
pub(super) struct Crew {
    members: BTreeMap<ControllerId, Member>,
    commands: BTreeMap<(ControllerId, CommandId), UnderWay>,
    speed: Option<f64>,
}

/// How far a controller's attachment is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Presence {
    Attached,
    Configured,
    Lost,
}

/// What went wrong with a controller last, until it takes a goal again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Trouble {
    /// It would not take the goal of these behaviors.
    Rejected { leaves: Vec<NodeId>, why: Rejection },
    /// It gave up the goal of these behaviors.
    Aborted { leaves: Vec<NodeId> },
    /// What it said was not used.
    Refused(Rejection),
}

/// A controller that was ever there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Member {
    pub(super) presence: Presence,
    pub(super) trouble: Option<Trouble>,
    /// Since when it has been silent, or lost.
    pub(super) since: Time,
}

/// A command that a controller was given.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct UnderWay {
    /// The behaviors that it serves, the first of them first.
    pub(super) leaves: Vec<NodeId>,
    pub(super) mode: Mode,
    pub(super) verb: &'static str,
    /// From 0 to 1.
    pub(super) progress: f64,
    pub(super) is_rejected: bool,
    pub(super) is_canceled: bool,
}

impl Crew {
    /// Takes the next message.
    pub(super) fn add(&mut self, at: Time, controller: ControllerId, message: &ControllerMessage) {
        match message {
            ControllerMessage::Attached => self.is_now(at, controller, Presence::Attached),
            ControllerMessage::Lost { .. } => {
                self.is_now(at, controller, Presence::Lost);
                self.commands.retain(|(owner, _), _| *owner != controller);
            }
            ControllerMessage::Told { leaf, message } => self.told(at, controller, *leaf, message),
            ControllerMessage::Joined { leaf, id } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    command.leaves.push(*leaf);
                }
            }
            ControllerMessage::Heard { message } => self.heard(at, controller, message),
            ControllerMessage::Refused { why, .. } => self.trouble(controller, Some(Trouble::Refused(*why))),
        }
    }

    /// Takes the end of a behavior: nobody works for it any more.
    pub(super) fn release(&mut self, leaf: NodeId) {
        self.commands.retain(|_, command| !command.is_rejected);
        for command in self.commands.values_mut() {
            command.leaves.retain(|holder| *holder != leaf);
        }
    }

    /// A controller; none that was never there.
    pub(super) fn member(&self, controller: ControllerId) -> Option<&Member> {
        self.members.get(&controller)
    }

    /// Robot seconds per wall second, once a controller was told.
    pub(super) fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// A command that a controller was given and has not ended.
    pub(super) fn command(&self, controller: ControllerId, id: CommandId) -> Option<&UnderWay> {
        self.commands.get(&(controller, id))
    }

    /// What a controller does, the oldest first.
    pub(super) fn commands(&self, controller: ControllerId) -> impl DoubleEndedIterator<Item = &UnderWay> {
        let (first, last) =
            (CommandId { generation: 0, number: 0 }, CommandId { generation: u32::MAX, number: u32::MAX });
        let own = self.commands.range((controller, first)..=(controller, last));
        own.map(|(_, command)| command).filter(|command| !command.is_rejected)
    }

    fn is_now(&mut self, at: Time, controller: ControllerId, presence: Presence) {
        self.members.insert(controller, Member { presence, trouble: None, since: at });
    }

    fn trouble(&mut self, controller: ControllerId, trouble: Option<Trouble>) {
        if let Some(member) = self.members.get_mut(&controller) {
            member.trouble = trouble;
        }
    }

    fn told(&mut self, at: Time, controller: ControllerId, leaf: Option<NodeId>, message: &ToController) {
        match message {
            ToController::Configure { speed, .. } => self.speed = Some(*speed),
            ToController::Goal { id, mode, command } => {
                let was_idle = self.commands(controller).next().is_none();
                if let Some(member) = self.members.get_mut(&controller).filter(|_| was_idle) {
                    member.since = at;
                }
                let under_way = UnderWay {
                    leaves: leaf.into_iter().collect(),
                    mode: *mode,
                    verb: verb(command),
                    progress: 0.0,
                    is_rejected: false,
                    is_canceled: false,
                };
                self.commands.insert((controller, *id), under_way);
            }
            ToController::Cancel { id } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    command.is_canceled = true;
                }
            }
        }
    }

    fn heard(&mut self, at: Time, controller: ControllerId, message: &FromController) {
        if let Some(member) = self.members.get_mut(&controller) {
            member.since = at;
        }
        match message {
            FromController::Configured { .. } => self.is_now(at, controller, Presence::Configured),
            FromController::Accepted { .. } => self.trouble(controller, None),
            FromController::Rejected { id, why } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    command.is_rejected = true;
                    let leaves = command.leaves.clone();
                    self.trouble(controller, Some(Trouble::Rejected { leaves, why: *why }));
                }
            }
            FromController::Feedback { id, progress, .. } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    command.progress = progress.clamp(0.0, 1.0);
                }
            }
            FromController::Result { id, end, .. } => {
                let ended = self.commands.remove(&(controller, *id));
                match (ended, end) {
                    (Some(UnderWay { leaves, .. }), PartEnd::Aborted) => {
                        self.trouble(controller, Some(Trouble::Aborted { leaves }));
                    }
                    (Some(_), PartEnd::Succeeded | PartEnd::Canceled) | (None, _) => {}
                }
            }
        }
    }
}

fn verb(command: &Command) -> &'static str {
    match command {
        Command::Drive { .. } => "driving",
        Command::Stand => "standing",
        Command::Grasp { .. } => "grasping",
        Command::Put { .. } => "putting",
        Command::Look { .. } => "looking",
    }
}
