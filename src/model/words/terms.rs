//! What a behavior reads, changes and tells controllers, as data: closed terms without positions.

use super::{Call, FactId, Hold, Mode, ObjectId, PlaceId, Pose};

/// A condition over world and line as data.
#[derive(Debug, Clone, PartialEq)]
pub enum Condition {
    /// Every one of them; true if there are none.
    All(Vec<Condition>),
    /// Never met: for a behavior that is done only by running.
    Never,
    /// The base is at rest within a distance of a stand.
    At {
        /// The place that the stand belongs to.
        place: PlaceId,
        /// The stand, map frame; of several any will do.
        stands: Vec<Pose>,
        /// The distance, meters.
        tolerance_m: f64,
    },
    /// A free path leads to a stand.
    Path {
        /// The place that the stand belongs to.
        place: PlaceId,
        /// The stand, map frame; of several any will do.
        stands: Vec<Pose>,
    },
    /// The object is held by the behavior's own line, or by what nobody has.
    Held(Hold),
    /// The object is in no gripper.
    Free(ObjectId),
    /// The object lies at some place.
    Somewhere(ObjectId),
    /// The object lies at the place.
    Lies(ObjectId, PlaceId),
    /// The fact holds, or does not.
    Fact(FactId, bool),
}

/// What success changes, as data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EffectTerm {
    /// The object lies at the place.
    Lies(ObjectId, PlaceId),
    /// The resource of that claim holds the object too.
    Taken(ObjectId, usize),
    /// The resource of that claim holds the object no more; others do.
    LetGo(ObjectId, usize),
    /// The base stands here, map frame.
    Stands(Pose),
    /// The fact holds, or does not.
    Fact(FactId, bool),
}

/// What a controller does while a behavior runs, as data.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandTerm {
    /// The claim whose resource it moves.
    pub claim: usize,
    /// Whether it ends the behavior.
    pub mode: Mode,
    /// What to do.
    pub task: Task,
}

/// What a controller is to do, before positions are filled in.
#[derive(Debug, Clone, PartialEq)]
pub enum Task {
    /// Drive to a stand of a place, map frame.
    DriveTo(PlaceId, Pose),
    /// Stand still.
    Stand,
    /// Take an object where it lies.
    Grasp(ObjectId),
    /// Take an object from the resource of that claim, which holds it.
    GraspFrom(ObjectId, usize),
    /// Set an object down at a place.
    Put(ObjectId, PlaceId),
    /// Let an object go into the resource of that claim.
    PutInto(ObjectId, usize),
    /// Look at the surface of a place.
    LookAt(PlaceId),
    /// Something of its own.
    Call(Call),
}

impl EffectTerm {
    /// The place where an object lies by it.
    pub fn lays(&self, object: ObjectId) -> Option<PlaceId> {
        match *self {
            Self::Lies(laid, place) if laid == object => Some(place),
            Self::Lies(..) | Self::Taken(..) | Self::LetGo(..) | Self::Stands(_) | Self::Fact(..) => None,
        }
    }
}

impl Task {
    /// The object that the resource of its claim takes.
    pub fn grasped(&self) -> Option<ObjectId> {
        match *self {
            Self::Grasp(object) | Self::GraspFrom(object, _) => Some(object),
            Self::Put(..) | Self::PutInto(..) | Self::DriveTo(..) | Self::Stand | Self::LookAt(_) | Self::Call(_) => {
                None
            }
        }
    }

    /// Where it brings the base.
    pub fn driven_to(&self) -> Option<Pose> {
        match *self {
            Self::DriveTo(_, stand) => Some(stand),
            Self::Put(..)
            | Self::PutInto(..)
            | Self::Grasp(_)
            | Self::GraspFrom(..)
            | Self::Stand
            | Self::LookAt(_)
            | Self::Call(_) => None,
        }
    }

    /// Where it puts something down.
    pub fn put_at(&self) -> Option<PlaceId> {
        match *self {
            Self::Put(_, place) => Some(place),
            Self::PutInto(..)
            | Self::Grasp(_)
            | Self::GraspFrom(..)
            | Self::DriveTo(..)
            | Self::Stand
            | Self::LookAt(_)
            | Self::Call(_) => None,
        }
    }

    /// The object that the resource of its claim lets go.
    pub fn put(&self) -> Option<ObjectId> {
        match *self {
            Self::Put(object, _) | Self::PutInto(object, _) => Some(object),
            Self::Grasp(_)
            | Self::GraspFrom(..)
            | Self::DriveTo(..)
            | Self::Stand
            | Self::LookAt(_)
            | Self::Call(_) => None,
        }
    }
}
