//! The live display: who uses which resource now, for what and how far it is; and one plain line per event.

mod line;
mod rows;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use crate::model::{
    Binding, Change, Command, CommandId, ControllerId, ControllerMessage, End, FromController, Grant, Mode, NodeEntry,
    NodeId, ObjectId, Record, ResourceId, RobotSpec, Tally, ToController, Whereabouts,
};

/// A running fold of records for the live display.
#[derive(Debug, Clone, Default)]
pub struct Progress {
    tally: Tally,
    controllers: Vec<Option<ControllerId>>,
    presence: BTreeMap<ControllerId, Presence>,
    commands: BTreeMap<(ControllerId, CommandId), UnderWay>,
    running: BTreeMap<NodeId, Vec<Binding>>,
    holding: BTreeMap<ResourceId, ObjectId>,
    done: BTreeSet<NodeId>,
    behaviors: usize,
}

/// Whether a controller is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Presence {
    Attached,
    Lost,
}

/// A command that a controller was given.
#[derive(Debug, Clone, PartialEq)]
struct UnderWay {
    leaf: Option<NodeId>,
    mode: Mode,
    verb: &'static str,
    progress: f64,
    is_rejected: bool,
}

impl Progress {
    /// Nothing has happened yet; the robot says which controller moves which resource.
    pub fn new(robot: &RobotSpec) -> Self {
        let controllers = robot.resources.iter().map(|resource| resource.controller);
        Self { controllers: controllers.collect(), ..Self::default() }
    }

    /// Takes the next record.
    pub fn add(&mut self, record: &Record) {
        self.tally.add(record);
        match record {
            Record::Header(header) => {
                let is_behavior = |node: &&NodeEntry| node.kind.is_behavior();
                self.behaviors = header.nodes.iter().filter(is_behavior).count();
            }
            Record::Sent { .. } | Record::Resource { .. } | Record::Ended { .. } => {}
            Record::Decided { granted, reopened, .. } => {
                if let Some(reopened) = reopened {
                    self.done.remove(&reopened.leaf);
                }
                granted.iter().for_each(|grant| self.grant(grant));
            }
            Record::Released { leaf, end, changes, .. } => {
                self.running.remove(leaf);
                self.commands.retain(|_, command| !command.is_rejected);
                if *end == End::Succeeded {
                    self.done.insert(*leaf);
                }
                changes.iter().for_each(|change| self.change(*change));
            }
            Record::World { change, .. } => self.change(*change),
            Record::Controller { controller, message, .. } => self.controller(*controller, message),
        }
    }

    /// The fold of the same records for summary and diagram.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    fn grant(&mut self, grant: &Grant) {
        self.running.insert(grant.leaf, grant.bindings.clone());
        let Some(header) = &self.tally.header else {
            return;
        };
        let skipped = grant.skips.iter().flat_map(|skip| skip.from.0..skip.to.0);
        let behaviors = skipped.map(NodeId).filter(|node| {
            let entry = header.nodes.get(node.index());
            entry.is_some_and(|entry| entry.kind.is_behavior())
        });
        self.done.extend(behaviors);
    }

    fn change(&mut self, change: Change) {
        let Change::Object(object, at) = change else {
            return;
        };
        self.holding.retain(|_, held| *held != object);
        if let Whereabouts::In(resource) = at {
            self.holding.insert(resource, object);
        }
    }

    fn controller(&mut self, controller: ControllerId, message: &ControllerMessage) {
        match message {
            ControllerMessage::Attached => {
                self.presence.insert(controller, Presence::Attached);
            }
            ControllerMessage::Lost => {
                self.presence.insert(controller, Presence::Lost);
                self.commands.retain(|(owner, _), _| *owner != controller);
            }
            ControllerMessage::Told { leaf, message } => match message {
                ToController::Goal { id, mode, command } => {
                    let under_way =
                        UnderWay { leaf: *leaf, mode: *mode, verb: verb(command), progress: 0.0, is_rejected: false };
                    self.commands.insert((controller, *id), under_way);
                }
                ToController::Configure { .. } | ToController::Cancel { .. } => {}
            },
            ControllerMessage::Heard { message } => self.heard(controller, message),
            ControllerMessage::Joined { .. } | ControllerMessage::Refused { .. } => {}
        }
    }

    fn heard(&mut self, controller: ControllerId, message: &FromController) {
        match message {
            FromController::Feedback { id, progress, .. } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    command.progress = progress.clamp(0.0, 1.0);
                }
            }
            FromController::Result { id, .. } => {
                self.commands.remove(&(controller, *id));
            }
            FromController::Rejected { id, .. } => {
                if let Some(command) = self.commands.get_mut(&(controller, *id)) {
                    command.is_rejected = true;
                }
            }
            FromController::Configured { .. } | FromController::Accepted { .. } => {}
        }
    }

    /// Behaviors that are done, by running or by being skipped.
    fn done(&self) -> usize {
        let skipped = self.tally.skipped.iter();
        self.done.len() + skipped.filter(|(leaf, _)| !self.done.contains(leaf)).count()
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
