//! Who holds an object: a set of resources, and what a behavior wants of it.

use serde::{Deserialize, Serialize};

use super::{Names, ObjectId, ResourceId, TypeId};

/// Most resources that hold one object at once.
pub const HOLDERS_MAX: usize = 4;

/// The resources that hold an object, in their order: at least one, at most [`HOLDERS_MAX`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<ResourceId>", into = "Vec<ResourceId>")]
pub struct Holders {
    count: usize,
    /// Behind the count all are the same.
    resources: [ResourceId; HOLDERS_MAX],
}

/// What stands where nobody holds.
const NOBODY: ResourceId = ResourceId(u32::MAX);

impl Holders {
    /// One alone.
    pub fn one(resource: ResourceId) -> Self {
        let mut resources = [NOBODY; HOLDERS_MAX];
        resources[0] = resource;
        Self { count: 1, resources }
    }

    /// All of them, in resource order.
    pub fn as_slice(&self) -> &[ResourceId] {
        &self.resources[..self.count]
    }

    /// Whether a resource is one of them.
    pub fn contains(&self, resource: ResourceId) -> bool {
        self.as_slice().contains(&resource)
    }

    /// These and one more; none where there is no room for another.
    pub fn with(mut self, resource: ResourceId) -> Option<Self> {
        if !self.contains(resource) {
            *self.resources.get_mut(self.count)? = resource;
            self.count += 1;
            self.resources.sort_unstable();
        }
        Some(self)
    }

    /// These without one; none where nobody is left.
    pub fn without(self, resource: ResourceId) -> Option<Self> {
        self.as_slice().iter().copied().filter(|holder| *holder != resource).collect::<Vec<_>>().try_into().ok()
    }
}

impl TryFrom<Vec<ResourceId>> for Holders {
    type Error = &'static str;

    fn try_from(resources: Vec<ResourceId>) -> Result<Self, Self::Error> {
        let (first, others) = resources.split_first().ok_or("nobody holds it")?;
        let all = others.iter().try_fold(Self::one(*first), |holders, other| holders.with(*other));
        all.ok_or("too many hold it")
    }
}

impl From<Holders> for Vec<ResourceId> {
    fn from(holders: Holders) -> Self {
        holders.as_slice().to_vec()
    }
}

/// That an object is held by the behavior's own line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Hold {
    /// What is held.
    pub object: ObjectId,
    /// Which resources count.
    pub by: HeldBy,
    /// How many of them hold it at least.
    pub hands: u32,
    /// Whether nothing else may hold it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub alone: bool,
}

/// Which resources count as holders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeldBy {
    /// Whatever holds it.
    Any,
    /// Those of a type.
    Type(TypeId),
    /// This one.
    Resource(ResourceId),
}

impl From<ObjectId> for Hold {
    /// Held by one, whichever it is.
    fn from(object: ObjectId) -> Self {
        Self { object, by: HeldBy::Any, hands: 1, alone: false }
    }
}

/// What is wrong with who holds an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Misheld {
    /// It is not held by so many of the own line, or not by what it should be.
    NotSo {
        /// What is wanted.
        hold: Hold,
        /// How many of the own line hold it that count.
        found: u32,
    },
    /// Something else holds what is to be put down, and would not let go of it.
    Too {
        /// What is to be put down.
        object: ObjectId,
        /// What holds it too.
        by: ResourceId,
    },
    /// What is to let go of it is the last that holds it.
    Last {
        /// What would fall.
        object: ObjectId,
    },
    /// As many hold it as can.
    Full {
        /// What no more can take.
        object: ObjectId,
    },
}

impl Misheld {
    pub(super) fn sentence(&self, names: &Names) -> String {
        match *self {
            Self::NotSo { hold, found } => hold.denial(found, names),
            Self::Too { object, by } => {
                format!("{} is in {} too, which would not let go of it", names.thing(object), names.resource(by))
            }
            Self::Last { object } => format!("nothing else holds {}, which must not fall", names.thing(object)),
            Self::Full { object } => {
                format!("{} is held by {HOLDERS_MAX} already, and no more can", names.thing(object))
            }
        }
    }
}

impl Hold {
    /// That it is not so, when so many of those that count hold it: "tray is in 1 of 2 hands".
    fn denial(&self, found: u32, names: &Names) -> String {
        let (object, wanted) = (names.thing(self.object), self.hands);
        if self.alone && found >= wanted {
            return format!("{object} is held by something else too");
        }
        match self.by {
            HeldBy::Any if wanted > 1 => {
                format!("{object} is held by {found} of this branch of the task, and has to be by {wanted}")
            }
            HeldBy::Type(of) if wanted > 1 => {
                let of = names.ty(of);
                format!("{object} is held by {found} {of} of this branch of the task, and has to be by {wanted}")
            }
            HeldBy::Any => format!("{object} is not held by this branch of the task"),
            HeldBy::Type(of) => format!("{object} is in no {} of this branch of the task", names.ty(of)),
            HeldBy::Resource(resource) => {
                format!("{object} is not held by this branch of the task with {}", names.resource(resource))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holders(of: &[u32]) -> Option<Holders> {
        of.iter().copied().map(ResourceId).collect::<Vec<_>>().try_into().ok()
    }

    #[test]
    fn holders_are_a_set_that_is_never_empty() {
        let two = holders(&[3, 1]).expect("two");
        assert_eq!(two.as_slice(), [ResourceId(1), ResourceId(3)]);
        assert_eq!((Some(two), two.with(ResourceId(3))), (holders(&[1, 3, 3]), Some(two)));
        assert_eq!(two.without(ResourceId(1)), Some(Holders::one(ResourceId(3))));
        assert_eq!(two.without(ResourceId(1)).and_then(|one| one.without(ResourceId(3))), None);
        assert_eq!((holders(&[]), holders(&[1, 2, 3, 4, 5])), (None, None));
        assert_eq!(holders(&[1, 2, 3, 4]).and_then(|four| four.with(ResourceId(5))), None);
    }
}
