//! Where things are relative to the robot, and what it reaches.

use nalgebra::Point3;

use ambidex_model::{
    Approach, Location, MissionSpec, ObjectId, PlaceId, Pose, ResourceId, RobotSpec, WorldSpec, WorldState,
};

/// The robot's body in the fixed part of the world.
#[derive(Debug, Clone, Copy)]
pub struct Geometry<'a> {
    /// Its body: shoulders, reach, radius.
    pub robot: &'a RobotSpec,
    /// Places and surfaces; what of it is free to drive is [`super::FreeSpace`]'s.
    pub world: &'a WorldSpec,
}

impl<'a> Geometry<'a> {
    /// Of a mission.
    pub fn of(mission: &'a MissionSpec) -> Self {
        Self { robot: &mission.robot, world: &mission.world }
    }

    /// How far the resource reaches out for the object, meters; none where it cannot.
    ///
    /// What is held is where it is carried. A resource that is no arm reaches at no cost whatever is somewhere.
    pub fn reach_m(&self, world_state: &WorldState, resource: ResourceId, object: ObjectId) -> Option<f64> {
        if let Location::At(place) = world_state.objects[object.index()] {
            let at = self.world.object(world_state, object)?;
            return self.reach_from(&world_state.base, resource, at, self.world.approach(object, place), 0.0);
        }
        let holders = world_state.objects[object.index()].holders().iter().filter(|holder| **holder != resource);
        let spots = holders.filter_map(|holder| self.robot.carried_at(*holder));
        let reached = spots.filter_map(|spot| self.robot.reach_m(resource, spot, Approach::ANY, 0.0));
        reached.min_by(f64::total_cmp)
    }

    /// How far the resource reaches out from a stand for a point of the map to which a hand comes as it may, or so much nearer,
    /// meters; none where it cannot.
    pub fn reach_from(
        &self,
        stand: &Pose,
        resource: ResourceId,
        at: Point3<f64>,
        approach: Approach<'_>,
        slack_m: f64,
    ) -> Option<f64> {
        self.robot.reach_m(resource, stand.to_local(at), approach.in_frame_of(stand), slack_m)
    }

    /// Whether the resource reaches from a stand some spot of a place where an object may be put down.
    pub fn puts_from(
        &self,
        stand: &Pose,
        resource: ResourceId,
        (object, place): (ObjectId, PlaceId),
        slack_m: f64,
    ) -> bool {
        let approach = self.world.approach(object, place).to_put();
        let mut spots = self.world.spots(object, place);
        spots.any(|at| self.reach_from(stand, resource, at, approach, slack_m).is_some())
    }
}
