//! Two behaviors that would keep each other waiting for good.

use serde::{Deserialize, Serialize};

use super::{Names, NodeId, ResourceId};

/// What a grant would lead to: neither of the two could ever go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Deadlock {
    /// Who is there already.
    pub other: Standstill,
    /// Who would come to it by the grant.
    pub own: Standstill,
}

/// A behavior that could not go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Standstill {
    /// The behavior.
    pub node: NodeId,
    /// What it has, itself or from above, and would keep.
    pub holds: Option<ResourceId>,
    /// How many resources it needs that can be kept; 0 where it is done and only keeps.
    pub needs: u32,
}

impl Deadlock {
    /// As part of a sentence: "open jar holds `left_gripper` and needs 2; pour would hold `right_gripper` and needs 2".
    pub fn sentence(&self, names: &Names) -> String {
        format!("{}; {}", self.other.sentence("holds", names), self.own.sentence("would hold", names))
    }
}

impl Standstill {
    /// What it holds and needs, said so.
    pub fn sentence(&self, holds: &str, names: &Names) -> String {
        let node = names.node(self.node);
        let held = self.holds.map(|resource| format!("{holds} {}", names.resource(resource)));
        let needed = (self.needs > 0).then(|| format!("needs {}", self.needs));
        match (held, needed) {
            (Some(held), Some(needed)) => format!("{node} {held} and {needed}"),
            (Some(one), None) | (None, Some(one)) => format!("{node} {one}"),
            (None, None) => format!("{node} would take its part in it"),
        }
    }
}
