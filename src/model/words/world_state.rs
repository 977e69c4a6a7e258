//! The state of the world as root keeps it, and how it changes.

use serde::{Deserialize, Serialize};

use super::{FactId, Holders, ObjectId, PlaceId, Pose, ResourceId};

/// Where an object is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Location {
    /// At a place.
    At(PlaceId),
    /// In grippers or slots of the robot.
    In(Holders),
    /// Nobody knows, as after a behavior that lost it.
    Unknown,
}

impl Location {
    /// Held by one resource alone.
    pub fn held(by: ResourceId) -> Self {
        Self::In(Holders::one(by))
    }

    /// What holds the object, in resource order.
    pub fn holders(&self) -> &[ResourceId] {
        match self {
            Self::In(holders) => holders.as_slice(),
            Self::At(_) | Self::Unknown => &[],
        }
    }
}

/// The changing part of the world: robot pose, objects, facts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorldState {
    /// Pose of the base in the map frame.
    pub base: Pose,
    /// Where each object is, by object.
    pub objects: Vec<Location>,
    /// Which facts hold, by fact.
    pub facts: Vec<bool>,
}

/// One change of the world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// The base is here now.
    Base(Pose),
    /// The object is here now.
    Object(ObjectId, Location),
    /// The gripper or slot holds the object too.
    Taken(ObjectId, ResourceId),
    /// The gripper is empty now; what nothing else holds is nobody knows where.
    Emptied(ResourceId),
    /// The fact holds or not.
    Fact(FactId, bool),
}

impl WorldState {
    /// What the resource holds.
    pub fn held_by(&self, resource: ResourceId) -> Option<ObjectId> {
        self.objects.iter().position(|at| at.holders().contains(&resource)).map(ObjectId::from)
    }

    /// What the resource holds and nothing else does.
    pub fn held_only_by(&self, resource: ResourceId) -> Option<ObjectId> {
        self.held_by(resource).filter(|object| self.objects[object.index()] == Location::held(resource))
    }

    /// Applies a change; true if anything is different now.
    pub fn apply(&mut self, change: Change) -> bool {
        match change {
            Change::Base(pose) => std::mem::replace(&mut self.base, pose) != pose,
            Change::Object(object, at) => {
                at.holders().iter().for_each(|holder| self.empty_of_others(*holder, object));
                std::mem::replace(&mut self.objects[object.index()], at) != at
            }
            Change::Taken(object, by) => {
                let held = match self.objects[object.index()] {
                    Location::In(holders) => holders.with(by),
                    Location::At(_) | Location::Unknown => Some(Holders::one(by)),
                };
                held.is_some_and(|holders| self.apply(Change::Object(object, Location::In(holders))))
            }
            Change::Emptied(resource) => match self.held_by(resource) {
                Some(object) => self.let_go(resource, object),
                None => false,
            },
            Change::Fact(fact, holds) => std::mem::replace(&mut self.facts[fact.index()], holds) != holds,
        }
    }
    /// A gripper holds one object: what else was in it is no more.
    fn empty_of_others(&mut self, resource: ResourceId, object: ObjectId) {
        if let Some(before) = self.held_by(resource).filter(|before| *before != object) {
            self.let_go(resource, before);
        }
    }

    fn let_go(&mut self, resource: ResourceId, object: ObjectId) -> bool {
        let at = &mut self.objects[object.index()];
        let left = match *at {
            Location::In(holders) => holders.without(resource).map_or(Location::Unknown, Location::In),
            Location::At(_) | Location::Unknown => *at,
        };
        std::mem::replace(at, left) != left
    }
}
