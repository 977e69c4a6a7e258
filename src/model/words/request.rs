//! What travels up for resources, and what comes of it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Access, ChannelId, NodeId, NodeRange, ObjectId, PlaceId, Pose, ResourceId, Retention, SpotId, StandId};

/// A resource that would serve a claim, and what it costs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// It would serve the claim.
    pub resource: ResourceId,
    /// Distance to reach, meters; 0 where nothing is reached for.
    pub cost_m: f64,
    /// Whether the behavior failed with it before, so that any other one comes first.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub has_failed: bool,
}

/// What counts as far beyond everything that anybody reaches, meters.
const BEYOND_M: f64 = 1e6;

impl Candidate {
    /// A resource that costs nothing to use.
    pub fn at_hand(resource: ResourceId) -> Self {
        Self { resource, cost_m: 0.0, has_failed: false }
    }

    /// By what candidates are compared, meters: where it failed before, then the distance.
    pub fn weight_m(&self) -> f64 {
        if self.has_failed { BEYOND_M + self.cost_m } else { self.cost_m }
    }
}

/// A claim of a request with every resource that would serve it, in resource order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClaimOptions {
    /// How it would be used.
    pub access: Access,
    /// What becomes of it on success.
    pub keep: Retention,
    /// What would serve it; never empty.
    pub candidates: Vec<Candidate>,
    /// Hands that are free and empty and do not reach, in resource order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beyond: Vec<Beyond>,
}

/// A hand that does not reach what it would be for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beyond {
    /// It would serve the claim.
    pub resource: ResourceId,
    /// What comes later and is out of its reach; none where that is so of what is asked now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<NodeId>,
}

impl ClaimOptions {
    /// What would serve the claim, without the costs.
    pub fn resources(&self) -> Vec<ResourceId> {
        self.candidates.iter().map(|candidate| candidate.resource).collect()
    }
}

/// One behavior's request for resources (III-C).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// The behavior that asks.
    pub leaf: NodeId,
    /// How urgent it is.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub priority: i32,
    /// How often the outermost node above it that repeats has been done.
    #[serde(default, skip_serializing_if = "is_first")]
    pub iterations: u32,
    /// Activation potential: finite, greater than 0.
    pub potential: f64,
    /// Whether an intention lease is kept for it; such a request comes first among equals.
    pub heir: bool,
    /// What it needs, in the order of its kind.
    pub claims: Vec<ClaimOptions>,
    /// Objects that it changes.
    pub changes: Vec<ObjectId>,
    /// What THEN nodes skipped to come to it.
    pub skips: Vec<NodeRange>,
    /// Where the object lies that the behavior follows; none where it follows none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<PlaceId>,
    /// At which stand of the place that it is about; none where that has only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stand: Option<StandId>,
    /// In which spots of their places the objects come to lie that it puts down; of others that follows from themselves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spots: Vec<(ObjectId, SpotId)>,
    /// The distance that its potential comes of, by equation (1); none where it comes of none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance: Option<Measured>,
}

/// How far it is to where a behavior would drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Meters in the plane.
    pub meters: f64,
    /// Along what.
    pub along: Distance,
}

/// What the distance of equation (1) is measured along.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Distance {
    /// The straight line, whatever stands in it.
    #[default]
    Straight,
    /// The path that the base would drive.
    Path,
}

/// A claim bound to a resource.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Binding {
    /// What was bound to the claim.
    pub resource: ResourceId,
    /// How it is used.
    pub access: Access,
    /// What becomes of it on success.
    pub keep: Retention,
}

/// A request that root granted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Grant {
    /// What was asked for, shared with everybody who has seen the request.
    #[serde(flatten)]
    pub request: Arc<Request>,
    /// The resources, in the order of its claims; an allocator may add more behind them.
    pub bindings: Vec<Binding>,
    /// Leaves among those that it skips whose goal is met already.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub met: Vec<NodeId>,
    /// The way that the base is to drive, map frame: where it stands first, then way points, the goal last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub way: Vec<Pose>,
}

impl Request {
    /// In which spot an object comes to lie that it puts down.
    pub fn spot(&self, object: ObjectId) -> Option<SpotId> {
        self.spots.iter().find(|(put, _)| *put == object).map(|(_, spot)| *spot)
    }
}

impl Grant {
    /// The behavior that was granted.
    pub fn leaf(&self) -> NodeId {
        self.request.leaf
    }

    /// The nodes that count as done by it, of a tree of so many.
    pub fn skipped(&self, of: usize) -> impl Iterator<Item = NodeId> {
        self.request.skips.iter().flat_map(move |skip| skip.nodes(of))
    }

    /// The channel on which the behavior uses a resource.
    pub fn channel(&self, resource: ResourceId) -> Option<ChannelId> {
        self.bindings.iter().find(|binding| binding.resource == resource)?.access.channel()
    }
}

fn is_usual(priority: &i32) -> bool {
    *priority == 0
}

fn is_first(iterations: &u32) -> bool {
    *iterations == 0
}
