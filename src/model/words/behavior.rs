//! A behavior with every parameter filled in.

use std::sync::Arc;
use std::time::Duration;

use super::{
    Claim, CommandTerm, Condition, EffectTerm, Location, ObjectId, PlaceId, Pose, Request, Retention, StandId, TypeId,
    WorldState,
};

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
    /// The same behavior at each stand of the place that it is about, by stand; none where that has only one.
    pub stands: Option<Arc<[BehaviorSpec]>>,
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

    /// The behavior as it was asked for.
    pub fn asked(&self, request: &Request) -> &Self {
        self.at(request.place).at_stand(request.stand)
    }

    /// The behavior for a stand of the place that it is about.
    pub fn at_stand(&self, stand: Option<StandId>) -> &Self {
        let found = self.stands.as_ref().zip(stand).and_then(|(stands, stand)| stands.get(stand.index()));
        found.unwrap_or(self)
    }

    /// The behavior for every place where an object may lie that it follows, itself last.
    pub fn anywhere(&self) -> impl Iterator<Item = &Self> {
        self.elsewhere.iter().flat_map(|followed| &followed.at).chain([self])
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
