//! What a granted behavior asks of controllers, and how it ended.

use std::fmt::{self, Display, Formatter};
use std::time::Duration;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::{Access, Change, ControllerId, Names, NodeId, ObjectId, PlaceId, Pose, Rejection, ResourceId};

/// Longest text of the arguments of a call, bytes.
pub const ARGUMENTS_MAX: usize = 1024;

/// The arguments of a call that has none.
pub const NO_ARGUMENTS: &str = "{}";

/// What one controller is told to do. Points are in the base frame, poses in the map frame; meters and radians.
///
/// Within the daemon objects, places and resources are ids; controllers know them by [`Name`](super::Name), as
/// [`motion::Command`](crate::motion::Command).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Command<O = ObjectId, P = PlaceId, R = ResourceId> {
    /// Base: drive along the way points and stop at the last.
    Drive {
        /// Where to pass, the goal last; never empty.
        path: Vec<Pose>,
        /// The place whose stand is the goal; logs of before do not tell.
        #[serde(skip_serializing_if = "Option::is_none")]
        place: Option<P>,
    },
    /// Base, arm, head: keep still.
    Stand,
    /// Arm: reach, close the gripper, lift.
    Grasp {
        /// What to take.
        object: O,
        /// Where it is.
        at: Point3<f64>,
        /// The place where it lies, if it lies at one.
        #[serde(skip_serializing_if = "Option::is_none")]
        place: Option<P>,
        /// The gripper or slot that it is taken from, if one holds it.
        #[serde(skip_serializing_if = "Option::is_none")]
        holder: Option<R>,
    },
    /// Arm: reach, open the gripper, retreat.
    Put {
        /// What to set down.
        object: O,
        /// Where it is set down, base frame, meters.
        at: Point3<f64>,
        /// The place where it is set down, if it is at one.
        #[serde(skip_serializing_if = "Option::is_none")]
        place: Option<P>,
        /// The gripper or slot that it is let go into, if it is one.
        #[serde(skip_serializing_if = "Option::is_none")]
        holder: Option<R>,
    },
    /// Head: look at a point and keep looking.
    Look {
        /// What is looked at, base frame, meters.
        at: Point3<f64>,
        /// The place that is looked at; logs of before do not tell.
        #[serde(skip_serializing_if = "Option::is_none")]
        place: Option<P>,
    },
    /// Any: do what its robot file says that it offers.
    Call(Call),
}

/// A command that is the user's own: its robot file says who offers it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Call {
    /// What it is called.
    pub name: String,
    /// Its arguments, as an object of JSON: names of objects and places, texts, and numbers in SI units.
    pub with: String,
    /// How long it takes, as the robot file says; robot time.
    pub takes: Duration,
}

impl Display for Call {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        if self.with == NO_ARGUMENTS { Ok(()) } else { write!(f, " {}", self.with) }
    }
}

/// Whether a part ends its goal or lasts as long as it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// The goal is reached when this is.
    Achieve,
    /// Lasts while the goal does; shared by all holders of the channel; ends early only by failing.
    Maintain,
}

/// One controller's part of a goal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The resource that the controller moves.
    pub resource: ResourceId,
    /// How the behavior uses it.
    pub access: Access,
    /// Whether it ends the goal.
    pub mode: Mode,
    /// What to do.
    pub command: Command,
}

/// What a behavior wants done, one goal per grant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Goal {
    /// The behavior that was granted.
    pub leaf: NodeId,
    /// Its parts, in the order of the kind.
    pub parts: Vec<Part>,
    /// How long it takes at least, robot time.
    pub takes: Duration,
    /// How long it may take, robot time.
    pub timeout: Duration,
}

/// Why a goal did not succeed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// The controller would not take it, and why.
    Rejected(ControllerId, Rejection),
    /// What the controller said of how its goal ended cannot be used, and why.
    Refused(ControllerId, Rejection),
    /// The controller did not answer in time.
    Unanswered(ControllerId),
    /// The controller gave up.
    Aborted(ControllerId),
    /// What had to last ended early.
    NotMaintained(ControllerId),
    /// The gripper holds something else than it should: before, or after what is said to have succeeded.
    Contradicted(ResourceId),
    /// It took too long.
    TimedOut,
    /// The controller is gone.
    Lost(ControllerId),
    /// Something came to stand in its way.
    Blocked,
}

impl Fault {
    /// The fault as a sentence: "`left_arm` gave up".
    pub fn sentence(self, names: &Names) -> String {
        match self {
            Self::Rejected(controller, why) => {
                format!("{} would not take its goal: {why}", names.controller(controller))
            }
            Self::Refused(controller, why) => {
                format!("what {} said of its goal is not used: {why}", names.controller(controller))
            }
            Self::Unanswered(controller) => format!("{} did not answer in time", names.controller(controller)),
            Self::Aborted(controller) => format!("{} gave up", names.controller(controller)),
            Self::NotMaintained(controller) => {
                format!("{} ended early what had to last", names.controller(controller))
            }
            Self::Contradicted(gripper) => format!("{} does not hold what it should", names.resource(gripper)),
            Self::TimedOut => "it took too long".into(),
            Self::Lost(controller) => format!("{} was lost", names.controller(controller)),
            Self::Blocked => "something came to stand in its way".into(),
        }
    }
}

/// How a goal ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// As intended.
    Succeeded,
    /// Not as intended; the fault says what went wrong.
    Failed(Fault),
    /// By being told to.
    Canceled,
    /// By no fault of its own: its runtime was gone while it ran, or its controller came to be inhibited. Nobody knows
    /// how far it came, and it asks again at once.
    Interrupted,
}

impl End {
    /// The controller at which the goal failed.
    pub fn at_fault(self) -> Option<ControllerId> {
        match self {
            Self::Succeeded
            | Self::Canceled
            | Self::Interrupted
            | Self::Failed(Fault::TimedOut | Fault::Contradicted(_) | Fault::Blocked) => None,
            Self::Failed(
                Fault::Rejected(controller, _)
                | Fault::Refused(controller, _)
                | Fault::Unanswered(controller)
                | Fault::Aborted(controller)
                | Fault::NotMaintained(controller)
                | Fault::Lost(controller),
            ) => Some(controller),
        }
    }
}

/// How a goal ended and what its controllers said of the world then.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// How it ended.
    pub end: End,
    /// What is so now, whatever the kind promised.
    pub changes: Vec<Change>,
}
