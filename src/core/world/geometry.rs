//! Where things are relative to the robot, and what it reaches.

use nalgebra::Point3;

use ambidex_model::{ControllerKind, Location, ObjectId, PlaceId, ResourceId, RobotSpec, WorldSpec, WorldState};

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
    /// A resource that is no arm reaches at no cost whatever lies somewhere.
    pub fn reach_m(&self, world_state: &WorldState, resource: ResourceId, object: ObjectId) -> Option<f64> {
        let object = world_state.base.to_local(self.object(world_state, object)?);
        let controller = self.robot.resources[resource.index()].controller;
        match controller.map(|id| self.robot.controllers[id.index()].kind) {
            Some(ControllerKind::Arm(arm)) => {
                let distance_m = (object - arm.shoulder).norm();
                (distance_m <= arm.reach_m).then_some(distance_m)
            }
            Some(ControllerKind::Base(_) | ControllerKind::Head(_) | ControllerKind::Device) | None => Some(0.0),
        }
    }
}
