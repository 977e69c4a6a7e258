//! What a mission is: robot, world and tree, checked and with every name interned.

use nalgebra::{Point3, Vector3};

use super::{
    ArmSpec, ControllerId, ControllerKind, ControllerSpec, FactId, HeldBy, Hold, Names, Pose, ResourceId, Selector,
    Source, TreeSpec, TypeId, WorldState,
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResourceSpec {
    /// What it can be claimed as.
    pub ty: TypeId,
    /// Who moves it; none for one that only counts.
    pub controller: Option<ControllerId>,
    /// Where what it holds is, base frame, meters; none where nothing tells, or where its controller does.
    pub at: Option<Point3<f64>>,
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

impl RobotSpec {
    /// Resources that a controller moves, in resource order.
    pub fn moved_by(&self, controller: ControllerId) -> impl Iterator<Item = ResourceId> + '_ {
        let ids = (0..self.resources.len()).map(ResourceId::from);
        ids.filter(move |id| self.resources[id.index()].controller == Some(controller))
    }

    /// The resources that could ever serve a claim, in resource order.
    pub fn could_serve(&self, selector: Selector) -> Vec<ResourceId> {
        match selector {
            Selector::Named(resource)
            | Selector::Empty { resource, .. }
            | Selector::Holding { resource: Some(resource), .. } => vec![resource],
            Selector::Any(of) | Selector::AnyEmpty { of, .. } | Selector::Holding { of, resource: None, .. } => {
                self.of_type(of).collect()
            }
        }
    }

    /// Whether a resource is one of those that count as holders.
    pub fn counts(&self, by: HeldBy, resource: ResourceId) -> bool {
        match by {
            HeldBy::Any => true,
            HeldBy::Type(of) => self.resources[resource.index()].ty == of,
            HeldBy::Resource(only) => only == resource,
        }
    }

    /// Whether nothing holds an object but what counts.
    pub fn is_held_alone(&self, hold: Hold, world_state: &WorldState) -> bool {
        world_state.objects[hold.object.index()].holders().iter().all(|holder| self.counts(hold.by, *holder))
    }

    /// The arm that moves a resource.
    pub fn arm(&self, resource: ResourceId) -> Option<&ArmSpec> {
        match &self.controllers[self.resources[resource.index()].controller?.index()].kind {
            ControllerKind::Arm(arm) => Some(arm),
            ControllerKind::Base(_) | ControllerKind::Head(_) | ControllerKind::Device => None,
        }
    }

    /// Where what a resource holds is, base frame, meters: where an arm carries it, or where a slot is.
    pub fn carried_at(&self, resource: ResourceId) -> Option<Point3<f64>> {
        self.arm(resource).map(|arm| arm.tuck).or(self.resources[resource.index()].at)
    }

    /// Resources of a type, in resource order.
    pub fn of_type(&self, ty: TypeId) -> impl Iterator<Item = ResourceId> + '_ {
        (0..self.resources.len()).map(ResourceId::from).filter(move |id| self.resources[id.index()].ty == ty)
    }
}
