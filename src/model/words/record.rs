//! What a run leaves behind: typed records, one per line of the journal.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{
    Change, CommandId, ControllerId, End, FromController, Grant, Loss, MissionSpec, Names, NodeId, NodeKind, Reason,
    Rejection, Request, Resource, ResourceId, Time, ToController, TypeId, WorldState, make_legible,
};

/// Version of the journal's form; a reader refuses any other.
pub const JOURNAL_VERSION: u32 = 3;

/// One line of the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "record", rename_all = "snake_case")]
pub enum Record {
    /// The first line: what the ids stand for.
    Header(Box<Header>),
    /// A message between two nodes.
    Sent {
        /// Robot time of the sending.
        at: Time,
        /// The round it belongs to.
        round: u32,
        /// Who sent it.
        from: NodeId,
        /// Who gets it.
        to: NodeId,
        /// What it says.
        message: Message,
    },
    /// What root decided at the end of a round.
    Decided {
        /// Robot time of the verdict.
        at: Time,
        /// Counted from 1.
        round: u32,
        /// What starts now.
        granted: Vec<Grant>,
        /// Every other activated leaf that does not run, with its reason.
        refused: Vec<Blocked>,
        /// What is not done any more.
        reopened: Option<Reopened>,
    },
    /// Root applied the end of a behavior.
    Released {
        /// Robot time at which root applied it.
        at: Time,
        /// The behavior that ended.
        leaf: NodeId,
        /// How it ended.
        end: End,
        /// Where its leases went.
        consequences: Consequences,
        /// What is different in the world.
        changes: Vec<Change>,
    },
    /// The world changed from outside.
    World {
        /// Robot time at which root applied it.
        at: Time,
        /// What is different, and was not before.
        change: Change,
    },
    /// What a resource is like now that root moved, made or ended leases of it; nobody holds one that was never told of.
    Resource {
        /// Robot time of the change.
        at: Time,
        /// The resource whose leases changed.
        resource: ResourceId,
        /// Who holds it, how and why.
        state: Resource,
    },
    /// A message between the runtime and a controller.
    Controller {
        /// Robot time of the telling.
        at: Time,
        /// Which controller.
        controller: ControllerId,
        /// What it says.
        message: ControllerMessage,
    },
    /// The mission is over; what follows only makes the controllers safe.
    Ended {
        /// Robot time of the end.
        at: Time,
        /// Done, or why not.
        end: MissionEnd,
    },
}

impl Record {
    /// When; the header stands at the beginning of the run.
    pub fn at(&self) -> Time {
        match self {
            Self::Header(_) => Time::ZERO,
            Self::Sent { at, .. }
            | Self::Decided { at, .. }
            | Self::Released { at, .. }
            | Self::World { at, .. }
            | Self::Resource { at, .. }
            | Self::Controller { at, .. }
            | Self::Ended { at, .. } => *at,
        }
    }
}

/// What the ids of a journal stand for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// [`JOURNAL_VERSION`].
    pub version: u32,
    /// The mission's name.
    pub mission: String,
    /// The robot's name.
    pub robot: String,
    /// How requests were chosen.
    pub allocator: String,
    /// Parent and kind of each node, by id.
    pub nodes: Vec<NodeEntry>,
    /// Type of each resource, by id.
    pub resource_types: Vec<TypeId>,
    /// Who moves each resource, by id; empty in a journal that does not tell.
    #[serde(default)]
    pub movers: Vec<Option<ControllerId>>,
    /// The world as the mission has it before any controller said otherwise; none in a journal that does not tell.
    #[serde(default)]
    pub start: Option<WorldState>,
    /// What everything is called.
    pub names: Names,
}

impl Header {
    /// The header of a mission.
    pub fn new(mission: &MissionSpec, allocator: &str) -> Self {
        let nodes = mission.tree.nodes.iter().enumerate().map(|(index, node)| NodeEntry {
            parent: mission.tree.topology.parent(NodeId::from(index)),
            kind: EntryKind::from(node),
        });
        Self {
            version: JOURNAL_VERSION,
            mission: mission.name.clone(),
            robot: mission.robot.name.clone(),
            allocator: allocator.to_owned(),
            nodes: nodes.collect(),
            resource_types: mission.robot.resources.iter().map(|resource| resource.ty).collect(),
            movers: mission.robot.resources.iter().map(|resource| resource.controller).collect(),
            start: Some(mission.start.clone()),
            names: mission.names.clone(),
        }
        .legible()
    }

    /// The same header, in which no name can speak to the terminal that shows it.
    #[must_use]
    pub fn legible(mut self) -> Self {
        [&mut self.mission, &mut self.robot, &mut self.allocator].into_iter().for_each(make_legible);
        for node in &mut self.nodes {
            if let EntryKind::Behavior(kind) = &mut node.kind {
                make_legible(kind);
            }
        }
        Self { names: self.names.legible(), ..self }
    }
}

/// A node in the header.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NodeEntry {
    /// Its parent; the root's is itself.
    pub parent: NodeId,
    /// What it is; a word in the journal.
    pub kind: EntryKind,
}

/// What a node in the header is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum EntryKind {
    /// `root`.
    Root,
    /// `and`.
    And,
    /// `or`.
    Or,
    /// `then`.
    Then,
    /// Any other word is the kind of a behavior.
    Behavior(String),
}

impl EntryKind {
    /// The word for it.
    pub fn word(&self) -> &str {
        match self {
            Self::Root => "root",
            Self::And => "and",
            Self::Or => "or",
            Self::Then => "then",
            Self::Behavior(kind) => kind,
        }
    }

    /// Whether it is a leaf.
    pub fn is_behavior(&self) -> bool {
        matches!(self, Self::Behavior(_))
    }
}

impl From<String> for EntryKind {
    fn from(word: String) -> Self {
        match word.as_str() {
            "root" => Self::Root,
            "and" => Self::And,
            "or" => Self::Or,
            "then" => Self::Then,
            _ => Self::Behavior(word),
        }
    }
}

impl From<EntryKind> for String {
    fn from(kind: EntryKind) -> Self {
        match kind {
            EntryKind::Behavior(word) => word,
            EntryKind::Root | EntryKind::And | EntryKind::Or | EntryKind::Then => kind.word().to_owned(),
        }
    }
}

impl From<&NodeKind> for EntryKind {
    fn from(kind: &NodeKind) -> Self {
        match kind {
            NodeKind::Root => Self::Root,
            NodeKind::And => Self::And,
            NodeKind::Or => Self::Or,
            NodeKind::Then => Self::Then,
            NodeKind::Behavior(behavior) => Self::Behavior(behavior.kind.clone()),
        }
    }
}

/// A leaf and why it does not run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Blocked {
    /// The behavior that does not run.
    pub leaf: NodeId,
    /// What keeps it.
    pub reason: Reason,
}

/// A behavior that was done and is not any more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reopened {
    /// The THEN for which it was done.
    pub holder: NodeId,
    /// The behavior that is done again.
    pub leaf: NodeId,
    /// The lease that lapsed; none where the THEN only goes back.
    pub lapsed: Option<ResourceId>,
    /// For whom it was done and what that one lacks; none where the THEN only goes back.
    pub lacks: Option<Box<Blocked>>,
}

/// A message between two nodes, as the journal shows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Message {
    /// Down: the state of resources and world.
    Activation,
    /// Up: the one answer to an activation.
    Answer {
        /// Something below runs.
        running: bool,
        /// The goal is met.
        satisfied: bool,
        /// The potential of the node; none where nothing below asks.
        potential: Option<f64>,
        /// Behaviors below that ask, as passed on.
        asking: Vec<NodeId>,
        /// A leaf's own request.
        request: Option<Arc<Request>>,
        /// What this node says no to: a leaf of itself, a task node of those it did not pass on.
        blocked: Vec<Blocked>,
    },
    /// Down: what came of it.
    Verdict {
        /// Granted below this edge.
        granted: Vec<NodeId>,
        /// A leaf's reason.
        refused: Option<Reason>,
    },
    /// Down: what was done is not any more.
    Reopen {
        /// The behavior that is done again.
        leaf: NodeId,
    },
    /// Down: end what runs.
    Cancel,
    /// Up: a behavior ended.
    Release {
        /// The behavior that ended.
        leaf: NodeId,
        /// Success, failure with its fault, or cancel.
        end: End,
        /// What that means so far.
        consequences: Consequences,
    },
}

/// What the end of a behavior means for the nodes above, raised on its way up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Consequences {
    /// What it completes; none where it did not succeed.
    pub completed: Option<Completion>,
    /// The topmost node that fails now, if any does.
    pub failed: Option<NodeId>,
}

/// What a success completes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Completion {
    /// The topmost node that is complete now.
    pub node: NodeId,
    /// The THEN above it that goes on, if its parent is one.
    pub heir: Option<NodeId>,
}

/// A message between the runtime and one controller, or what became of one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ControllerMessage {
    /// It is there.
    Attached,
    /// The runtime told it something.
    Told {
        /// For which behavior; none for a configuration.
        leaf: Option<NodeId>,
        /// A configuration, a command, or its cancel.
        message: ToController,
    },
    /// A further behavior shares a command that lasts.
    Joined {
        /// The behavior that joins.
        leaf: NodeId,
        /// The command that it shares.
        id: CommandId,
    },
    /// It told the runtime something.
    Heard {
        /// An answer, feedback, or a result.
        message: FromController,
    },
    /// What came from it was not used.
    Refused {
        /// The command that it was about, where that can be told.
        id: Option<CommandId>,
        /// What was wrong with it.
        why: Rejection,
    },
    /// It is gone.
    Lost {
        /// How that was seen.
        why: Loss,
    },
}

impl ControllerMessage {
    /// The behavior for which the controller was told something.
    pub fn leaf(&self) -> Option<NodeId> {
        match self {
            Self::Told { leaf, .. } => *leaf,
            Self::Joined { leaf, .. } => Some(*leaf),
            Self::Attached | Self::Heard { .. } | Self::Refused { .. } | Self::Lost { .. } => None,
        }
    }
}

/// How a mission ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionEnd {
    /// The task is complete.
    Done,
    /// The task failed, first at this leaf.
    Failed(NodeId),
    /// Nothing runs and nothing can.
    Stalled,
    /// It was told to end.
    Canceled,
    /// A controller is gone.
    ControllerLost(ControllerId),
    /// Not every controller attached in time.
    NotAttached,
    /// A node's own task is gone: a defect.
    NodeLost(NodeId),
    /// Another task of the runtime is gone: a defect.
    TaskLost,
}
