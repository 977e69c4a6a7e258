//! Where things are relative to the robot, and what it reaches.

use nalgebra::Point3;

use ambidex_model::{Location, ObjectId, PlaceId, ResourceId, RobotSpec, WorldSpec, WorldState};

/// The robot's body in the fixed part of the world.
#[derive(Debug, Clone, Copy)]
pub struct Geometry<'a> {
    /// Its body: shoulders, reach, radius.
    pub robot: &'a RobotSpec,
    /// Places and surfaces; what of it is free to drive is [`super::FreeSpace`]'s.
    pub world: &'a WorldSpec,
}

impl Geometry<'_> {
    /// Where an object lies, map frame, meters; none while it is in a gripper or nobody knows where.
    pub fn object(&self, world_state: &WorldState, object: ObjectId) -> Option<Point3<f64>> {
        match world_state.objects[object.index()] {
            Location::At(place) => Some(self.spot(object, place)),
            Location::In(_) | Location::Unknown => None,
        }
    }

    /// Where an object lies, or would lie, at a place, map frame, meters.
    pub fn spot(&self, object: ObjectId, place: PlaceId) -> Point3<f64> {
        let place = &self.world.places[place.index()];
        place.stand.to_map(place.surface + self.world.object_offsets[object.index()])
    }

    /// The middle of a place's surface, map frame, meters.
    pub fn surface(&self, place: PlaceId) -> Point3<f64> {
        let place = &self.world.places[place.index()];
        place.stand.to_map(place.surface)
    }

    /// How far the resource reaches out for the object, meters; none where it cannot.
    ///
    /// What is held is where it is carried. A resource that is no arm reaches at no cost whatever is somewhere.
    pub fn reach_m(&self, world_state: &WorldState, resource: ResourceId, object: ObjectId) -> Option<f64> {
        let lying = self.object(world_state, object).map(|at| world_state.base.to_local(at));
        let holders = world_state.objects[object.index()].holders().iter().filter(|holder| **holder != resource);
        let spots = lying.into_iter().chain(holders.filter_map(|holder| self.robot.carried_at(*holder)));
        let reached = spots.filter_map(|spot| match self.robot.arm(resource) {
            Some(arm) => Some((spot - arm.shoulder).norm()).filter(|distance_m| *distance_m <= arm.reach_m),
            None => Some(0.0),
        });
        reached.min_by(f64::total_cmp)
    }
}
