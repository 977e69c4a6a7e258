//! What a mission is: robot, world and tree, checked and with every name interned.

use nalgebra::{Point3, Vector3};

use super::{
    Approach, ArmSpec, ControllerId, ControllerKind, ControllerSpec, Distance, FactId, Fragment, HeldBy, Hold,
    Location, Names, NodeId, ObjectId, ObjectSpec, Obstacle, PlaceId, Pose, ResourceId, Selector, Shape, Source,
    SpotId, StandId, TreeSpec, TypeId, WorldState,
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
    /// What can be taken, by object.
    pub objects: Vec<ObjectSpec>,
    /// Walls and what else the base must not drive into, beside the tables of places.
    pub obstacles: Vec<Obstacle>,
    /// What the distance of equation (1) is measured along.
    pub distance: Distance,
    /// Facts that others may set and clear, by fact.
    pub outside: Vec<bool>,
}

/// How near two things may lie whose bodies are smaller, meters.
const APART_M: f64 = 0.1;
/// How far a thing may be over an edge, meters: files are written with two digits.
const SLACK_M: f64 = 0.01;
/// What is apart by as much as it must, as exactly as sums are, meters.
const EXACT_M: f64 = 1e-6;

impl MissionSpec {
    /// Adds a part to the tree as a child of a node, at some place among the others; gives the id of its top.
    pub fn graft(&mut self, under: NodeId, place: usize, fragment: &Fragment) -> NodeId {
        let top = self.tree.graft(under, place, fragment);
        self.names.nodes.add(top.index(), fragment.names.clone());
        self.names.channels.extend(fragment.channels.iter().cloned());
        if self.tree.topology.parent(top) == self.tree.topology.stem() {
            self.tree.tasks.push(top);
        }
        top
    }

    /// A part of the tree is gone.
    pub fn remove(&mut self, node: NodeId) {
        let runs: Vec<_> = self.tree.topology.below(node).collect();
        self.tree.remove(node);
        self.tree.tasks.retain(|task| *task != node);
        runs.into_iter().for_each(|run| self.names.nodes.remove(run.start.index()..run.end.index()));
    }
}

impl WorldSpec {
    /// Whatever the base must not drive into: walls and obstacles, then tables in the order of their places.
    pub fn solids(&self) -> Vec<Obstacle> {
        self.obstacles.iter().copied().chain(self.places.iter().filter_map(|place| place.table)).collect()
    }

    /// The place whose table one of the [solids](Self::solids) is.
    pub fn table_of(&self, solid: usize) -> Option<PlaceId> {
        let mut tables = self.places.iter().enumerate().filter(|(_, place)| place.table.is_some());
        let (place, _) = tables.nth(solid.checked_sub(self.obstacles.len())?)?;
        Some(PlaceId::from(place))
    }

    /// Where an object lies, or would lie, at a place by its own offset, map frame, meters.
    pub fn own_spot(&self, object: ObjectId, place: PlaceId) -> Point3<f64> {
        let (place, object) = (&self.places[place.index()], &self.objects[object.index()]);
        object.middle(place.stand.to_map(place.surface + object.offset))
    }

    /// From where a hand may come to an object that lies at a place, map frame.
    pub fn approach(&self, object: ObjectId, place: PlaceId) -> Approach<'_> {
        let (place, object) = (&self.places[place.index()], &self.objects[object.index()]);
        Approach { sides: &object.grasps, heading: place.stand.heading + object.heading }
    }

    /// Where an object lies, or would lie, in a spot of a place or by its own offset, map frame, meters.
    pub fn spot(&self, object: ObjectId, place: PlaceId, spot: Option<SpotId>) -> Point3<f64> {
        let found = spot.and_then(|spot| self.places[place.index()].spots.get(spot.index()));
        found.map_or_else(|| self.own_spot(object, place), |found| self.objects[object.index()].middle(*found))
    }

    /// Whether it is told where an object lies wherever it is put: by its own offset, where no table tells more.
    pub fn has_own_spot(&self, object: ObjectId, place: PlaceId) -> bool {
        self.places[place.index()].table.is_none() && self.objects[object.index()].is_offset_told
    }

    /// Whether it is known where on a place an object lies or is put: what nobody told is a mere guess.
    pub fn is_spot_told(&self, object: ObjectId, place: PlaceId) -> bool {
        self.places[place.index()].is_surface_told || self.objects[object.index()].is_offset_told
    }

    /// Wherever an object may be put down at a place that is empty, map frame, meters.
    pub fn spots(&self, object: ObjectId, place: PlaceId) -> impl Iterator<Item = Point3<f64>> + '_ {
        let has_own = self.has_own_spot(object, place);
        // On a surface of which nothing is told it may be where it would lie beside the others.
        let is_own = has_own || !self.places[place.index()].is_surface_told;
        let own = is_own.then(|| self.own_spot(object, place));
        let fitting = (!has_own).then(|| self.fitting(object, place).map(|(_, at)| at));
        fitting.into_iter().flatten().chain(own)
    }

    /// The spots of a place in which an object finds room, whatever else lies there, each with where its middle is then, map
    /// frame, meters.
    pub fn fitting(&self, object: ObjectId, place: PlaceId) -> impl Iterator<Item = (SpotId, Point3<f64>)> + '_ {
        let spots = &self.places[place.index()].spots;
        let middles = spots.iter().map(move |spot| self.objects[object.index()].middle(*spot));
        let all = middles.enumerate().map(|(spot, at)| (SpotId::from(spot), at));
        all.filter(move |(_, at)| self.has_room(object, place, *at))
    }

    /// Whether two objects with their middles in some points, at one place, are nearer than hands and bodies let them be.
    pub fn meet(&self, (one, at): (ObjectId, Point3<f64>), (other, there): (ObjectId, Point3<f64>)) -> bool {
        let half_m = |object: ObjectId| self.objects[object.index()].shape.map_or(0.0, |shape| shape.half_width_m());
        (at - there).xy().norm() + EXACT_M < APART_M.max(half_m(one) + half_m(other))
    }

    /// Whether the table of a place, where it has one, is under all of an object whose middle is there.
    fn has_room(&self, object: ObjectId, place: PlaceId, at: Point3<f64>) -> bool {
        let Some(table) = self.places[place.index()].table else { return true };
        match self.objects[object.index()].shape {
            Some(Shape::Box(_)) => {
                self.thing(object, place, at).corners().iter().all(|corner| table.left_m(*corner) >= -SLACK_M)
            }
            Some(Shape::Cylinder { radius_m, .. }) => table.left_m(at.xy()) >= radius_m - SLACK_M,
            None => table.left_m(at.xy()) >= -SLACK_M,
        }
    }

    /// The box around an object that lies at a place with its middle in a point, map frame; without size where it has no body.
    pub fn thing(&self, object: ObjectId, place: PlaceId, middle: Point3<f64>) -> Obstacle {
        let spec = &self.objects[object.index()];
        let size = match spec.shape {
            Some(Shape::Box(size)) => size,
            Some(Shape::Cylinder { radius_m, height_m }) => Vector3::new(2.0 * radius_m, 2.0 * radius_m, height_m),
            None => Vector3::zeros(),
        };
        Obstacle { middle, size, heading: self.places[place.index()].stand.heading + spec.heading }
    }

    /// The middle of a place's surface, map frame, meters.
    pub fn surface(&self, place: PlaceId) -> Point3<f64> {
        let place = &self.places[place.index()];
        place.stand.to_map(place.surface)
    }

    /// Where an object lies, map frame, meters; none while it is in a gripper or nobody knows where, and of one that the
    /// world does not know.
    pub fn object(&self, world_state: &WorldState, object: ObjectId) -> Option<Point3<f64>> {
        self.objects.get(object.index())?;
        match *world_state.objects.get(object.index())? {
            Location::At(place) if place.index() >= self.places.len() => None,
            Location::At(place) => Some(self.spot(object, place, world_state.spot(object))),
            Location::In(_) | Location::Unknown => None,
        }
    }

    /// Whether others than behaviors may set and clear a fact.
    pub fn is_outside(&self, fact: FactId) -> bool {
        self.outside.get(fact.index()).copied().unwrap_or(false)
    }
}

/// A place: where the robot stands, and where things lie.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceSpec {
    /// Where the base stands, map frame: the first stand, in whose frame things lie.
    pub stand: Pose,
    /// Where else it may stand for the same, map frame.
    pub others: Vec<Pose>,
    /// The middle of the surface in the frame of the stand, meters.
    pub surface: Point3<f64>,
    /// Whether somebody told where its surface is, or what its table is like.
    pub is_surface_told: bool,
    /// What things lie on, where it is known: the base must not drive into it.
    pub table: Option<Obstacle>,
    /// Where things are put down, map frame, meters; none where nothing is known of its surface, so that each thing has its
    /// own offset.
    pub spots: Vec<Point3<f64>>,
}

impl PlaceSpec {
    /// Wherever the base may stand, map frame; in the order of [`StandId`]s.
    pub fn stands(&self) -> impl ExactSizeIterator<Item = Pose> + '_ {
        (0..self.others.len() + 1).map(|stand| self.stand(StandId::from(stand)))
    }

    /// One of the stands, map frame; the first one for one that is not there.
    pub fn stand(&self, stand: StandId) -> Pose {
        let other = stand.index().checked_sub(1).and_then(|other| self.others.get(other));
        other.copied().unwrap_or(self.stand)
    }
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
        match &self.mover(resource)?.kind {
            ControllerKind::Arm(arm) => Some(arm),
            ControllerKind::Base(_) | ControllerKind::Head(_) | ControllerKind::Device => None,
        }
    }

    /// How far a hand reaches out for a point of the base frame to which it comes as it may, or for one that is so much
    /// nearer, meters; none where it cannot, 0 for whatever is no arm.
    ///
    /// A hand that comes from somewhere has its wrist there: as far from the point as the hand is long.
    pub fn reach_m(&self, hand: ResourceId, at: Point3<f64>, approach: Approach<'_>, slack_m: f64) -> Option<f64> {
        let Some(arm) = self.arm(hand) else { return Some(0.0) };
        let hand_m = self.mover(hand).map_or(0.0, |controller| controller.hand_m);
        let is_near = |point: Point3<f64>, reach_m: f64| (point - arm.shoulder).norm() <= reach_m + slack_m;
        let can = match approach.sides {
            [] => is_near(at, arm.reach_m),
            _ => approach.directions().any(|way| is_near(at + way * hand_m, arm.reach_m - hand_m)),
        };
        can.then(|| (at - arm.shoulder).norm())
    }

    /// What moves a resource.
    pub fn mover(&self, resource: ResourceId) -> Option<&ControllerSpec> {
        Some(&self.controllers[self.resources[resource.index()].controller?.index()])
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
