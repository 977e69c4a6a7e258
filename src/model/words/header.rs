//! The first line of a journal: what its ids stand for, and the files that its mission was made of.

use serde::{Deserialize, Serialize};

use super::{
    ControllerId, Granting, MissionSpec, Names, NodeId, NodeKind, Runs, Source, Topology, TypeId, WorldState,
    make_legible,
};

/// Version of the journal's form; a reader refuses any other.
pub const JOURNAL_VERSION: u32 = 10;

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
    pub nodes: Runs<NodeEntry>,
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
    /// Whether a stall waited for the world instead of ending the mission.
    #[serde(default)]
    pub waits_when_stalled: bool,
    /// How long a controller is awaited without which nothing can go on, microseconds of robot time.
    #[serde(default)]
    pub reattach_us: u64,
    /// How long cleanups may take all together once the mission is told to end, microseconds of robot time.
    #[serde(default)]
    pub cleanup_grace_us: u64,
    /// Whether messages between nodes are told, and with decisions why everything else does not run.
    #[serde(default = "yes")]
    pub has_messages: bool,
    /// The files that the mission was made of; none where it was made otherwise.
    #[serde(default)]
    pub source: Option<Source>,
}

impl Header {
    /// The header of a mission.
    pub fn new(mission: &MissionSpec, allocator: &str, waits_when_stalled: bool) -> Self {
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
            waits_when_stalled,
            reattach_us: 0,
            cleanup_grace_us: 0,
            has_messages: true,
            source: mission.source.clone(),
        }
        .legible()
    }

    /// Whether tasks come and go in this run.
    pub fn is_standing(&self) -> bool {
        self.nodes.get(1).is_some_and(|node| node.kind == EntryKind::Tasks)
    }

    /// The shape of its tree.
    ///
    /// # Panics
    /// When its nodes are no tree in preorder, as those of a header that was read always are.
    pub fn topology(&self) -> Topology {
        let topology = Topology::new(self.nodes.iter().map(|node| node.parent).collect());
        let topology = topology.with_cleanups_of(|node| self.nodes[node.index()].kind == EntryKind::Cleanup);
        topology.with_stem(NodeId(u32::from(self.is_standing())))
    }

    /// The same header, in which no name can speak to the terminal that shows it.
    #[must_use]
    pub fn legible(mut self) -> Self {
        [&mut self.mission, &mut self.robot, &mut self.allocator].into_iter().for_each(make_legible);
        for node in self.nodes.iter_mut() {
            if let EntryKind::Behavior(kind) = &mut node.kind {
                make_legible(kind);
            }
        }
        Self { names: self.names.legible(), ..self }
    }
}

fn yes() -> bool {
    true
}

/// A node in the header.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NodeEntry {
    /// Its parent; the root's is itself.
    pub parent: NodeId,
    /// What it is; a word in the journal.
    pub kind: EntryKind,
}

/// A task as a run that takes work tells of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TaskEntry {
    /// What it is called: no other that is there is called so.
    pub name: String,
    /// How urgent it is.
    pub priority: i32,
    /// How it is granted what it asks for.
    #[serde(default)]
    pub granting: Granting,
}

/// What a node in the header is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum EntryKind {
    /// `root`.
    Root,
    /// `and`.
    And,
    /// `tasks`.
    Tasks,
    /// `or`.
    Or,
    /// `then`.
    Then,
    /// `cleanup`.
    Cleanup,
    /// Any other word is the kind of a behavior.
    Behavior(String),
}

impl EntryKind {
    /// The word for it.
    pub fn word(&self) -> &str {
        match self {
            Self::Root => "root",
            Self::And => "and",
            Self::Tasks => "tasks",
            Self::Or => "or",
            Self::Then => "then",
            Self::Cleanup => "cleanup",
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
            "tasks" => Self::Tasks,
            "or" => Self::Or,
            "then" => Self::Then,
            "cleanup" => Self::Cleanup,
            _ => Self::Behavior(word),
        }
    }
}

impl From<EntryKind> for String {
    fn from(kind: EntryKind) -> Self {
        match kind {
            EntryKind::Behavior(word) => word,
            EntryKind::Root | EntryKind::Tasks | EntryKind::And => kind.word().to_owned(),
            EntryKind::Or | EntryKind::Then | EntryKind::Cleanup => kind.word().to_owned(),
        }
    }
}

impl From<&NodeKind> for EntryKind {
    fn from(kind: &NodeKind) -> Self {
        match kind {
            NodeKind::Root => Self::Root,
            NodeKind::And => Self::And,
            NodeKind::Tasks => Self::Tasks,
            NodeKind::Or => Self::Or,
            NodeKind::Then => Self::Then,
            NodeKind::Cleanup => Self::Cleanup,
            NodeKind::Behavior(behavior) => Self::Behavior(behavior.kind.clone()),
        }
    }
}
