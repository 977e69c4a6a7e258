//! What runtime and controllers tell each other, whatever carries it.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::{
    Change, Command, CommandId, ControllerKind, Inhibition, Mode, ObjectId, PlaceId, Pose, Rejection, ResourceId, Time,
};

/// From the runtime to a controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ToController<O = ObjectId, P = PlaceId, R = ResourceId> {
    /// The first message of an attachment.
    Configure {
        /// Counted by the daemon; what belongs to another is stale.
        generation: u32,
        /// Robot seconds per wall second.
        speed: f64,
        /// What it moves, and within which limits.
        limits: ControllerKind,
        /// Where a simulated controller starts; a real one answers with its own state.
        start: ControllerState<O>,
    },
    /// Do this.
    Goal {
        /// Names the command in every answer.
        id: CommandId,
        /// Whether it ends by itself or lasts until it is canceled.
        mode: Mode,
        /// What to do.
        command: Command<O, P, R>,
    },
    /// Stop doing it.
    Cancel {
        /// The command to be stopped.
        id: CommandId,
    },
}

/// From a controller to the runtime.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FromController<O = ObjectId> {
    /// Ready, and this is how things are.
    Configured {
        /// The attachment that is answered.
        generation: u32,
        /// Its state, which wins over the daemon's.
        state: ControllerState<O>,
    },
    /// The command was begun.
    Accepted {
        /// The command that was taken.
        id: CommandId,
        /// By the controller's own clock.
        at: Time,
    },
    /// Not taken.
    Rejected {
        /// The command that was not taken.
        id: CommandId,
        /// What is wrong with it.
        why: Rejection,
    },
    /// Under way.
    Feedback {
        /// The command under way.
        id: CommandId,
        /// From 0 to 1.
        progress: f64,
        /// At the moment of the feedback.
        state: ControllerState<O>,
    },
    /// The command is over.
    Result {
        /// The command that ended.
        id: CommandId,
        /// As told, given up, or canceled.
        end: PartEnd,
        /// When it began, by the controller's own clock.
        began: Time,
        /// When it ended, by the controller's own clock.
        ended: Time,
        /// At the moment of the end.
        state: ControllerState<O>,
    },
}

impl<O: Copy> FromController<O> {
    /// The command that it is about; none for a configuration.
    pub fn id(&self) -> Option<CommandId> {
        match *self {
            Self::Configured { .. } => None,
            Self::Accepted { id, .. }
            | Self::Rejected { id, .. }
            | Self::Feedback { id, .. }
            | Self::Result { id, .. } => Some(id),
        }
    }

    /// How the controller says that it is.
    pub fn state(&self) -> Option<ControllerState<O>> {
        match *self {
            Self::Configured { state, .. } | Self::Feedback { state, .. } | Self::Result { state, .. } => Some(state),
            Self::Accepted { .. } | Self::Rejected { .. } => None,
        }
    }

    /// Whether it is the last word on its command.
    pub fn is_last(&self) -> bool {
        match self {
            Self::Rejected { .. } | Self::Result { .. } => true,
            Self::Configured { .. } | Self::Accepted { .. } | Self::Feedback { .. } => false,
        }
    }
}

/// How a controller's part ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PartEnd {
    /// As told.
    Succeeded,
    /// The controller gave up.
    Aborted,
    /// It was told to stop.
    Canceled,
    /// The controller came to be inhibited.
    Inhibited(Inhibition),
}

/// State of a controller as it publishes it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerState<O = ObjectId> {
    /// A base: map frame.
    Base {
        /// Where it is.
        pose: Pose,
        /// x and y in meters per second, map frame; z is the turning speed, radians per second.
        velocity: Vector3<f64>,
    },
    /// An arm: gripper in the base frame.
    Arm {
        /// Where the gripper is, meters.
        gripper: Point3<f64>,
        /// Its velocity, meters per second.
        velocity: Vector3<f64>,
        /// What it holds.
        holds: Option<O>,
    },
    /// A head: pan to the left and tilt downwards, radians.
    Head {
        /// Pan and tilt.
        angles: [f64; 2],
        /// Their velocities, radians per second.
        velocity: [f64; 2],
    },
    /// A device of another kind, of which no motion is known.
    Device,
}

impl<O: Copy> ControllerState<O> {
    /// The object that it says to hold.
    pub fn holds(&self) -> Option<O> {
        match *self {
            Self::Arm { holds, .. } => holds,
            Self::Base { .. } | Self::Head { .. } | Self::Device => None,
        }
    }

    /// The same without its motion.
    #[must_use]
    pub fn at_rest(self) -> Self {
        match self {
            Self::Base { pose, .. } => Self::Base { pose, velocity: Vector3::zeros() },
            Self::Arm { gripper, holds, .. } => Self::Arm { gripper, velocity: Vector3::zeros(), holds },
            Self::Head { angles, .. } => Self::Head { angles, velocity: [0.0; 2] },
            Self::Device => Self::Device,
        }
    }
}

impl ControllerState {
    /// What the state says of the world, for the resources that the controller moves.
    pub fn changes(&self, resources: impl IntoIterator<Item = ResourceId>) -> Vec<Change> {
        match *self {
            Self::Base { pose, .. } => vec![Change::Base(pose)],
            Self::Arm { holds, .. } => {
                let change = |resource| match holds {
                    Some(object) => Change::Taken(object, resource),
                    None => Change::Emptied(resource),
                };
                resources.into_iter().map(change).collect()
            }
            Self::Head { .. } | Self::Device => Vec::new(),
        }
    }
}
