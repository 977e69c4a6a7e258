//! What a behavior needs of the robot, and what becomes of it afterwards (III-B).

use serde::{Deserialize, Serialize};

use super::{ChannelId, ObjectId, ResourceId, TypeId};

/// How a resource is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Access {
    /// By one owner alone.
    Exclusive,
    /// Together with all others of the same channel.
    Shared(ChannelId),
}

impl Access {
    /// The channel of a shared access.
    pub fn channel(self) -> Option<ChannelId> {
        match self {
            Self::Exclusive => None,
            Self::Shared(channel) => Some(channel),
        }
    }

    /// Whether two owners can use one resource in these two ways at once.
    pub fn joins(self, other: Self) -> bool {
        self != Self::Exclusive && self == other
    }
}

/// Which resource a claim is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Selector {
    /// This resource.
    Named(ResourceId),
    /// Any resource of a type that holds no object and, where an object is given, reaches it.
    AnyEmpty {
        /// The type of which any will do.
        of: TypeId,
        /// The object that it must reach.
        reaches: Option<ObjectId>,
    },
    /// This resource, while it holds no object and, where an object is given, reaches it.
    Empty {
        /// The one that will do.
        resource: ResourceId,
        /// The object that it must reach.
        reaches: Option<ObjectId>,
    },
    /// Any resource of a type, whatever it holds.
    Any(TypeId),
    /// Any resource of a type, or only this one, that holds the object.
    Holding {
        /// What it must hold.
        object: ObjectId,
        /// The type of which any that holds it will do.
        of: TypeId,
        /// The only one that will do, if one is named.
        resource: Option<ResourceId>,
    },
}

/// What becomes of a lease when its behavior succeeds; after any other end see `semantics` 6.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Retention {
    /// Given back.
    Release,
    /// Kept for what the behavior was done for; lapses when that cannot come.
    Intention(Access),
    /// Kept because the world is so: a gripper with an object in it.
    Physical(Access),
}

/// One claim of a behavior.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Claim {
    /// Which resource.
    pub selector: Selector,
    /// How it is used.
    pub access: Access,
    /// What becomes of it on success.
    pub keep: Retention,
}

impl Claim {
    /// Whether the lease can be kept as the claim says while others share the resource: access may only widen.
    pub fn is_sound(&self) -> bool {
        match self.keep {
            Retention::Release => true,
            Retention::Intention(kept) | Retention::Physical(kept) => {
                self.access == Access::Exclusive || kept == self.access
            }
        }
    }
}
