//! What an end means for the nodes above, and what is not done any more.

use serde::{Deserialize, Serialize};

use super::{Blocked, Fault, NodeId, Reason, ResourceId, Time};

/// What the end of a behavior means for the nodes above.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Consequences {
    /// What it completes; none where it did not succeed.
    pub completed: Option<Completion>,
    /// The topmost node that fails now, if any does.
    pub failed: Option<NodeId>,
    /// The node that fails once nothing below it runs any more, or nothing is left there to be finished.
    #[serde(default)]
    pub failing: Option<Failing>,
    /// The node whose cleanup is over with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cleaned: Option<NodeId>,
}

/// Why what runs is told to end.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopCause {
    /// A node above fails, is left or canceled.
    #[default]
    Ends,
    /// What its kind wants to last is not so any more.
    Broken(Reason),
    /// A more urgent behavior waits for what it uses.
    Preempted {
        /// That one.
        by: NodeId,
    },
}

impl StopCause {
    /// Whether what is told so to end will ask again.
    pub fn interrupts(&self) -> bool {
        match self {
            Self::Ends => false,
            Self::Broken(_) | Self::Preempted { .. } => true,
        }
    }

    /// Whether it is the one that goes without saying.
    pub fn is_end(&self) -> bool {
        *self == Self::Ends
    }
}

/// A node that is as urgent as who waits for what it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Urged {
    /// The node, with all below it.
    pub node: NodeId,
    /// How urgent it is at least.
    pub priority: i32,
}

/// A node that cannot be complete any more and waits for what is below it to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failing {
    /// The node.
    pub node: NodeId,
    /// Its child that failed; itself where it took too long.
    pub child: NodeId,
    /// The node that it began with: a leaf, or one that took too long.
    pub cause: NodeId,
    /// How that failed; none where it never could run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<Fault>,
    /// Whether its other children finish what they can, since nothing above can choose or try again. Then all above
    /// it do the same.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub finishes: bool,
}

/// What a success completes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Completion {
    /// The topmost node that is complete now.
    pub node: NodeId,
    /// The THEN above it that goes on, if its parent is one.
    pub heir: Option<NodeId>,
}

/// The moment at which a task node has taken too long.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Deadline {
    /// The node.
    pub node: NodeId,
    /// Robot time.
    pub until: Time,
}

/// What was done, begun or chosen and is not any more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reopened {
    /// The behavior that is done again; the way that an OR leaves; the node that is tried or done again; the behavior for
    /// which others give something up.
    pub node: NodeId,
    /// The THEN for which it was done, which is not reopened itself; the OR; the node itself that is tried or done again; root.
    pub up_to: NodeId,
    /// Why.
    pub cause: Cause,
    /// ORs above the behavior of which nothing is done, runs or is held any more: they choose again.
    #[serde(default)]
    pub undecided: Vec<NodeId>,
    /// Leases for an intention that end with it, since they were kept below that THEN; whoever kept them is not done either.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ended: Vec<Kept>,
    /// Nodes that begin anew where something is tried again, in tree order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reset: Vec<NodeId>,
}

/// A lease for an intention.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Kept {
    /// The resource.
    pub resource: ResourceId,
    /// The node that holds it.
    pub holder: NodeId,
    /// The behavior that kept it.
    pub behavior: NodeId,
}

/// Why something is done again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// A lease that was kept for an intention lapsed; the behavior does not ask again before there is progress.
    Lapse {
        /// The resource.
        resource: ResourceId,
        /// For whom it was kept, and what that one lacks.
        heir: Box<Blocked>,
    },
    /// A later behavior needs what it made so, and that is not so any more.
    Redo {
        /// The behavior that needs it.
        leaf: NodeId,
    },
    /// Nothing goes on in the way that an OR had chosen, and there is another one.
    Leave,
    /// A task node failed and has attempts left.
    Retry {
        /// How the last attempt failed.
        fault: Fault,
        /// Since when it waits: the moment of the turn in which it failed.
        since: Time,
        /// Until when it waits before it asks again.
        until: Time,
    },
    /// A node that is done more than once was complete.
    Repeat {
        /// Since when it waits: the moment of the turn in which it was complete.
        since: Time,
        /// When it begins again; none at once.
        until: Option<Time>,
    },
    /// What was kept for intentions is given up for a more urgent behavior; nothing is done again for that.
    Yield,
}

impl Reopened {
    /// A node alone: no OR chooses again with it, no lease ends, and nothing below it begins anew.
    pub fn new(node: NodeId, up_to: NodeId, cause: Cause) -> Self {
        Self { node, up_to, cause, undecided: Vec::new(), ended: Vec::new(), reset: Vec::new() }
    }

    /// The resource whose lease lapsed, if one did.
    pub fn lapsed(&self) -> Option<ResourceId> {
        match self.cause {
            Cause::Lapse { resource, .. } => Some(resource),
            Cause::Redo { .. } | Cause::Leave | Cause::Retry { .. } => None,
            Cause::Repeat { .. } | Cause::Yield => None,
        }
    }

    /// For whom it was done and what that one lacks, if that is known.
    pub fn lacks(&self) -> Option<&Blocked> {
        match &self.cause {
            Cause::Lapse { heir, .. } => Some(heir),
            Cause::Redo { .. } | Cause::Leave | Cause::Retry { .. } => None,
            Cause::Repeat { .. } | Cause::Yield => None,
        }
    }
}
