//! What a mission is: robot, world and tree, checked and with every name interned.

use std::sync::Arc;
use std::time::Duration;

use nalgebra::{Point3, Vector3};

use super::{
    Call, Claim, ControllerId, ControllerSpec, FactId, Location, Mode, Names, ObjectId, PlaceId, Pose, ResourceId,
    Retention, Selector, Source, TreeSpec, TypeId, WorldState,
};

/// A mission that can be run.
#[derive(Debug, Clone, PartialEq)]
pub struct MissionSpec {
    /// As reports and logs call the mission.
    pub name: String,
    /// Body, resources and controllers.
    pub robot: RobotSpec,
    /// The fixed part of the world.
    pub world: WorldSpec,
    /// The changing part at the start.
    pub start: WorldState,
    /// The tree with its behaviors bound.
    pub tree: TreeSpec,
    /// What everything is called.
    pub names: Names,
    /// The files that it was made of; none where it was made otherwise.
    pub source: Option<Source>,
}

/// The robot as a set of resources and the controllers that move them.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotSpec {
    /// As the robot file calls it.
    pub name: String,
    /// Resources by id.
    pub resources: Vec<ResourceSpec>,
    /// Controllers by id.
    pub controllers: Vec<ControllerSpec>,
    /// Radius of the smallest upright cylinder around base and tucked arms, meters.
    pub radius_m: f64,
}

/// The fixed part of a resource.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResourceSpec {
    /// What it can be claimed as.
    pub ty: TypeId,
    /// Who moves it; none for one that only counts.
    pub controller: Option<ControllerId>,
}

/// The fixed part of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldSpec {
    /// Places by id.
    pub places: Vec<PlaceSpec>,
    /// Where on a surface each object lies, by object: offset in the frame of the place's stand, meters.
    pub object_offsets: Vec<Vector3<f64>>,
    /// What the base must not drive into.
    pub obstacles: Vec<Obstacle>,
    /// Facts that others may set and clear, by fact.
    pub outside: Vec<bool>,
}

impl WorldSpec {
    /// Whether others than behaviors may set and clear a fact.
    pub fn is_outside(&self, fact: FactId) -> bool {
        self.outside.get(fact.index()).copied().unwrap_or(false)
    }
}

/// A place: where the robot stands, and where things lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceSpec {
    /// Where the base stands, map frame.
    pub stand: Pose,
    /// The middle of the surface in the frame of the stand, meters.
    pub surface: Point3<f64>,
}

/// An upright box, map frame, meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstacle {
    /// Its lower corner.
    pub min: Point3<f64>,
    /// Its upper corner.
    pub max: Point3<f64>,
}

/// A behavior: its kind with every parameter filled in.
#[derive(Debug, Clone, PartialEq)]
pub struct BehaviorSpec {
    /// The name of its kind.
    pub kind: String,
    /// What it needs.
    pub claims: Vec<Claim>,
    /// How efficient it looks to run it now.
    pub potential: Potential,
    /// When its goal is met.
    pub satisfied: Condition,
    /// When it can run.
    pub precondition: Condition,
    /// What of the precondition must last while it runs.
    pub lasting: Condition,
    /// Whether what is more urgent may interrupt it.
    pub is_interruptible: bool,
    /// What is so when it succeeded, beyond what its controllers report.
    pub effects: Vec<EffectTerm>,
    /// What controllers do while it runs.
    pub commands: Vec<CommandTerm>,
    /// Objects that it changes.
    pub changes: Vec<ObjectId>,
    /// How long it runs at least, robot time: all of it for one that no controller ends.
    pub takes: Duration,
    /// How long it may run, robot time.
    pub timeout: Duration,
    /// How often it asks again after it failed.
    pub retries: u32,
    /// How long it waits before it asks again after it failed once, robot time; twice as long after each further time.
    pub backoff: Duration,
    /// The same behavior wherever an object lies that it follows; none where it follows none.
    pub elsewhere: Option<Arc<Elsewhere>>,
}

/// A behavior that is about the place where an object lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Elsewhere {
    /// The object.
    pub object: ObjectId,
    /// The behavior for each place, by place.
    pub at: Vec<BehaviorSpec>,
}

impl BehaviorSpec {
    /// The behavior as the world is: for the place where the object lies that it follows, else for the one at the start.
    pub fn as_in(&self, world_state: &WorldState) -> &Self {
        self.at(self.place_in(world_state))
    }

    /// The place that it is about as the world is; none where it follows no object, or that lies nowhere.
    pub fn place_in(&self, world_state: &WorldState) -> Option<PlaceId> {
        let followed = self.elsewhere.as_ref()?;
        match world_state.objects[followed.object.index()] {
            Location::At(place) => Some(place),
            Location::In(_) | Location::Unknown => None,
        }
    }

    /// The behavior for a place that it is about.
    pub fn at(&self, place: Option<PlaceId>) -> &Self {
        let found = self.elsewhere.as_ref().zip(place).and_then(|(followed, place)| followed.at.get(place.index()));
        found.unwrap_or(self)
    }

    /// How long a behavior waits that wants to be tried again after so many failures, robot time.
    pub fn wait(&self, failures: u32) -> Duration {
        doubled(self.backoff, failures)
    }

    /// Whether it keeps a base for an intention: what it reaches is there to be used, and is no goal in itself.
    pub fn is_drive(&self) -> bool {
        self.claims.iter().any(|claim| matches!(claim.keep, Retention::Intention(_)))
    }
}

pub(super) fn doubled(backoff: Duration, failures: u32) -> Duration {
    let times = 1u32.checked_shl(failures.saturating_sub(1)).unwrap_or(u32::MAX);
    backoff.saturating_mul(times).min(MOST_BACKOFF)
}

/// However often it failed, nothing waits longer than a day.
const MOST_BACKOFF: Duration = Duration::from_secs(24 * 60 * 60);

/// Activation potential as data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Potential {
    /// Always the same.
    Constant(f64),
    /// A value times the available resources of a type.
    Scaled {
        /// The value of each.
        value: f64,
        /// The type whose available resources count.
        by: TypeId,
    },
    /// Equation (1): `n / max(distance, floor)`, meters in the plane.
    Nearness {
        /// Where it would go, map frame.
        to: Pose,
        /// Distance below which it does not grow, meters.
        floor_m: f64,
        /// Type whose available resources are counted; without it n = 1.
        scale_by: Option<TypeId>,
    },
}

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
        /// The stand, map frame.
        stand: Pose,
        /// The distance, meters.
        tolerance_m: f64,
    },
    /// A free path leads to a stand.
    Path {
        /// The place that the stand belongs to.
        place: PlaceId,
        /// The stand, map frame.
        stand: Pose,
    },
    /// The object is in a gripper of the behavior's own line.
    Held(ObjectId),
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
    /// The object is in the resource of that claim.
    Taken(ObjectId, usize),
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
    /// Take an object where it is.
    Grasp(ObjectId),
    /// Set an object down at a place.
    Put(ObjectId, PlaceId),
    /// Look at the surface of a place.
    LookAt(PlaceId),
    /// Something of its own.
    Call(Call),
}

impl RobotSpec {
    /// Resources that a controller moves, in resource order.
    pub fn moved_by(&self, controller: ControllerId) -> impl Iterator<Item = ResourceId> + '_ {
        let ids = (0..self.resources.len()).map(ResourceId::from);
        ids.filter(move |id| self.resources[id.index()].controller == Some(controller))
    }

    /// The resources that could ever serve a claim, in resource order; `holders` are those that could hold an object
    /// that is wanted held.
    pub fn could_serve(&self, selector: Selector, holders: &[ResourceId]) -> Vec<ResourceId> {
        match selector {
            Selector::Named(resource) | Selector::Empty { resource, .. } => vec![resource],
            Selector::Any(of) | Selector::AnyEmpty { of, .. } => self.of_type(of).collect(),
            Selector::Holding(_) => holders.to_vec(),
        }
    }

    /// Resources of a type, in resource order.
    pub fn of_type(&self, ty: TypeId) -> impl Iterator<Item = ResourceId> + '_ {
        (0..self.resources.len()).map(ResourceId::from).filter(move |id| self.resources[id.index()].ty == ty)
    }
}
