//! What a mission is: robot, world and tree, checked and with every name interned.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::{
    Claim, CommandTerm, Condition, ControllerId, EffectTerm, FactId, HeldBy, Hold, Location, Names, NodeId, ObjectId,
    PlaceId, Pose, ResourceId, Retention, Selector, Source, TypeId, WorldState,
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

/// A controller process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ControllerSpec {
    /// What its process is started with.
    pub name: String,
    /// What it moves, and its limits.
    pub kind: ControllerKind,
    /// How long it may take to end what it was told to end, wall time; past that it counts as hung.
    pub cancel_grace: Duration,
}

/// What a controller moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// An arm with a gripper.
    Arm(ArmSpec),
    /// A base that drives in the plane.
    Base(BaseSpec),
    /// A head that pans and tilts.
    Head(HeadSpec),
    /// A device of another kind, which does what its robot file says that it offers.
    Device,
}

/// An arm with a gripper.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ArmSpec {
    /// The shoulder in the base frame, meters.
    pub shoulder: Point3<f64>,
    /// Where the gripper is carried, base frame, meters.
    pub tuck: Point3<f64>,
    /// How far the gripper reaches from the shoulder, meters.
    pub reach_m: f64,
    /// Top speed of the gripper, meters per second.
    pub speed: f64,
    /// Top acceleration of the gripper, meters per second squared.
    pub acceleration: f64,
    /// Time to close or open the gripper, seconds.
    pub grip_s: f64,
    /// How far it lifts what it took, meters.
    pub lift_m: f64,
}

/// A base that drives in the plane in any direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BaseSpec {
    /// Top speed, meters per second.
    pub speed: f64,
    /// Top acceleration, meters per second squared.
    pub acceleration: f64,
    /// Top turning speed, radians per second.
    pub turn_speed: f64,
    /// Top turning acceleration, radians per second squared.
    pub turn_acceleration: f64,
}

/// A head that pans and tilts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeadSpec {
    /// The crossing of its axes in the base frame, meters.
    pub neck: Point3<f64>,
    /// Top speed of each axis, radians per second.
    pub speed: f64,
    /// Top acceleration of each axis, radians per second squared.
    pub acceleration: f64,
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

/// The shape of a tree in preorder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    parents: Vec<NodeId>,
    ends: Vec<NodeId>,
}

impl Topology {
    /// From each node's parent in preorder; the root is its own parent.
    ///
    /// # Panics
    /// When the parents are not those of a tree in preorder.
    pub fn new(parents: Vec<NodeId>) -> Self {
        let mut ends: Vec<NodeId> = (1..=parents.len()).map(NodeId::from).collect();
        for node in (1..parents.len()).rev() {
            let parent = parents[node].index();
            assert!(parent < node && ends[parent].index() > 0, "not in preorder: {parents:?}");
            ends[parent] = ends[parent].max(ends[node]);
        }
        for node in 1..parents.len() {
            let (parent, before) = (parents[node], NodeId::from(node - 1));
            assert!(parent <= before && before < ends[parent.index()], "not in preorder: {parents:?}");
        }
        Self { parents, ends }
    }

    /// How many nodes there are; at least root.
    pub fn count(&self) -> usize {
        self.parents.len()
    }

    /// A node and those above it, root last.
    pub fn path(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        std::iter::successors(Some(node), |node| (node.0 > 0).then(|| self.parent(*node)))
    }

    /// The parent of a node; the root's is itself.
    pub fn parent(&self, node: NodeId) -> NodeId {
        self.parents[node.index()]
    }

    /// The first node in preorder behind a node's subtree.
    pub fn end(&self, node: NodeId) -> NodeId {
        self.ends[node.index()]
    }

    /// Whether `node` is `top` or below it.
    pub fn is_within(&self, node: NodeId, top: NodeId) -> bool {
        top <= node && node < self.end(top)
    }

    /// The children of a node in order.
    pub fn children(&self, node: NodeId) -> impl Iterator<Item = NodeId> + '_ {
        let end = self.end(node);
        let mut next = NodeId(node.0 + 1);
        std::iter::from_fn(move || {
            let child = (next < end).then_some(next)?;
            next = self.end(child);
            Some(child)
        })
    }
}

/// A task tree.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeSpec {
    /// What each node is, by id; node 0 is the root and has one child.
    pub nodes: Vec<NodeKind>,
    /// Parents and extents of the nodes.
    pub topology: Topology,
    /// Task nodes that may be tried again, or may take only so long.
    pub limits: BTreeMap<NodeId, Limits>,
}

/// How long a task node may take, and how often it is tried.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Limits {
    /// How long an attempt may take from the first grant below, robot time; none without end.
    pub timeout: Option<Duration>,
    /// How often it is tried again after it failed.
    pub retries: u32,
    /// How long it waits before that, robot time; twice as long after each further time.
    pub backoff: Duration,
}

impl Limits {
    /// How long it waits after so many failures, robot time.
    pub fn wait(&self, failures: u32) -> Duration {
        doubled(self.backoff, failures)
    }
}

impl TreeSpec {
    /// How long a task node may take, and how often it is tried.
    pub fn limits(&self, node: NodeId) -> Limits {
        self.limits.get(&node).copied().unwrap_or_default()
    }

    /// The behavior of a leaf.
    pub fn behavior(&self, node: NodeId) -> Option<&BehaviorSpec> {
        match &self.nodes[node.index()] {
            NodeKind::Behavior(spec) => Some(spec),
            NodeKind::Root | NodeKind::And | NodeKind::Or | NodeKind::Then => None,
        }
    }

    /// The behavior of a leaf as the world is.
    pub fn behavior_in(&self, node: NodeId, world_state: &WorldState) -> Option<&BehaviorSpec> {
        self.behavior(node).map(|spec| spec.as_in(world_state))
    }

    /// All ORs in tree order.
    pub fn ors(&self) -> impl Iterator<Item = NodeId> + '_ {
        (0..self.nodes.len()).map(NodeId::from).filter(|node| self.nodes[node.index()] == NodeKind::Or)
    }

    /// All leaves in tree order.
    pub fn leaves(&self) -> impl Iterator<Item = NodeId> + '_ {
        (0..self.nodes.len()).map(NodeId::from).filter(|&node| self.behavior(node).is_some())
    }
}

/// What a node is (III-A).
#[derive(Debug, Clone, PartialEq)]
pub enum NodeKind {
    /// Keeps resources and world, and grants.
    Root,
    /// All children, in any order.
    And,
    /// One child.
    Or,
    /// All children, in order.
    Then,
    /// A low-level behavior.
    Behavior(Box<BehaviorSpec>),
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

fn doubled(backoff: Duration, failures: u32) -> Duration {
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
