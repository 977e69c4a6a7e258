//! The state of the world as root keeps it, and how it changes.

use serde::{Deserialize, Serialize};

use super::{FactId, Holders, ObjectId, Obstacle, PlaceId, Pose, ResourceId, SpotId};

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

    /// The place where it lies.
    pub fn place(&self) -> Option<PlaceId> {
        match *self {
            Self::At(place) => Some(place),
            Self::In(_) | Self::Unknown => None,
        }
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
    /// In which spots of their places objects lie that were put there, by object.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spots: Vec<(ObjectId, SpotId)>,
    /// What has come to stand in the room, in the order in which it did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
}

/// One change of the world.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// The base is here now.
    Base(Pose),
    /// The object is here now.
    Object(ObjectId, Location),
    /// The object was put down in that spot of the place.
    Laid(ObjectId, PlaceId, SpotId),
    /// The gripper or slot holds the object too.
    Taken(ObjectId, ResourceId),
    /// The gripper is empty now; what nothing else holds is nobody knows where.
    Emptied(ResourceId),
    /// The fact holds or not.
    Fact(FactId, bool),
    /// Something stands in the room that was not there before.
    Blocked(Obstacle),
    /// Whatever came to stand there, around that point, is gone.
    Cleared(Pose),
}

impl Change {
    /// The object that is somewhere else by it, and where.
    pub fn moved(self) -> Option<(ObjectId, Option<Location>)> {
        match self {
            Self::Object(object, at) => Some((object, Some(at))),
            Self::Laid(object, place, _) => Some((object, Some(Location::At(place)))),
            Self::Taken(object, _) => Some((object, None)),
            Self::Base(_) | Self::Emptied(_) | Self::Fact(..) | Self::Blocked(_) | Self::Cleared(_) => None,
        }
    }
}

impl WorldState {
    /// With every object that lies somewhere by its own offset.
    pub fn new(base: Pose, objects: Vec<Location>, facts: Vec<bool>) -> Self {
        Self { base, objects, facts, spots: Vec::new(), obstacles: Vec::new() }
    }

    /// What the resource holds.
    pub fn held_by(&self, resource: ResourceId) -> Option<ObjectId> {
        self.objects.iter().position(|at| at.holders().contains(&resource)).map(ObjectId::from)
    }

    /// What the resource holds and nothing else does.
    pub fn held_only_by(&self, resource: ResourceId) -> Option<ObjectId> {
        self.held_by(resource).filter(|object| self.objects[object.index()] == Location::held(resource))
    }

    /// In which spot of its place an object lies that was put there.
    pub fn spot(&self, object: ObjectId) -> Option<SpotId> {
        let found = self.spots.binary_search_by_key(&object, |(object, _)| *object).ok()?;
        Some(self.spots[found].1)
    }

    /// An object lies in another spot, or in none; gives the one before.
    fn put_in(&mut self, object: ObjectId, spot: Option<SpotId>) -> Option<SpotId> {
        match (self.spots.binary_search_by_key(&object, |(object, _)| *object), spot) {
            (Ok(found), Some(spot)) => Some(std::mem::replace(&mut self.spots[found].1, spot)),
            (Ok(found), None) => Some(self.spots.remove(found).1),
            (Err(place), Some(spot)) => {
                self.spots.insert(place, (object, spot));
                None
            }
            (Err(_), None) => None,
        }
    }

    /// Applies a change; true if anything is different now.
    pub fn apply(&mut self, change: Change) -> bool {
        match change {
            Change::Base(pose) => std::mem::replace(&mut self.base, pose) != pose,
            // Where it is already, it is still where it was put there.
            Change::Object(object, at @ Location::At(_)) if self.objects[object.index()] == at => false,
            Change::Object(object, at) => {
                at.holders().iter().for_each(|holder| self.empty_of_others(*holder, object));
                self.put_in(object, None);
                std::mem::replace(&mut self.objects[object.index()], at) != at
            }
            Change::Laid(object, place, spot) => {
                let was_elsewhere =
                    std::mem::replace(&mut self.objects[object.index()], Location::At(place)) != Location::At(place);
                self.put_in(object, Some(spot)) != Some(spot) || was_elsewhere
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
            Change::Blocked(obstacle) => {
                let is_new = !self.obstacles.contains(&obstacle);
                self.obstacles.extend(is_new.then_some(obstacle));
                is_new
            }
            Change::Cleared(around) => {
                let before = self.obstacles.len();
                self.obstacles.retain(|obstacle| !obstacle.is_around(around.at));
                self.obstacles.len() < before
            }
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
