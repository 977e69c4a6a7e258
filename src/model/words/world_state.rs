//! The state of the world as root keeps it, and how it changes.

use serde::{Deserialize, Serialize};

use super::{FactId, ObjectId, PlaceId, Pose, ResourceId};

/// Where an object is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Location {
    /// At a place.
    At(PlaceId),
    /// In a gripper.
    In(ResourceId),
    /// Nobody knows, as after a behavior that lost it.
    Unknown,
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
    /// The gripper is empty now; what was in it is nobody knows where.
    Emptied(ResourceId),
    /// The fact holds or not.
    Fact(FactId, bool),
}

impl WorldState {
    /// What the resource holds.
    pub fn held_by(&self, resource: ResourceId) -> Option<ObjectId> {
        self.objects.iter().position(|&at| at == Location::In(resource)).map(ObjectId::from)
    }

    /// Applies a change; true if anything is different now.
    pub fn apply(&mut self, change: Change) -> bool {
        match change {
            Change::Base(pose) => std::mem::replace(&mut self.base, pose) != pose,
            Change::Object(object, at) => {
                // A gripper holds one object: what was in it before is nobody knows where.
                if let Location::In(gripper) = at
                    && let Some(before) = self.held_by(gripper).filter(|before| *before != object)
                {
                    self.objects[before.index()] = Location::Unknown;
                }
                std::mem::replace(&mut self.objects[object.index()], at) != at
            }
            Change::Emptied(resource) => match self.held_by(resource) {
                Some(object) => self.apply(Change::Object(object, Location::Unknown)),
                None => false,
            },
            Change::Fact(fact, holds) => std::mem::replace(&mut self.facts[fact.index()], holds) != holds,
        }
    }
}
