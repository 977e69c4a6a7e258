//! Work for a robot that works already: tasks that are submitted, held back and canceled, trees that are edited, objects that
//! come into the room (`semantics` 6, "Tasks that come and go").

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Fragment, Names, NodeId, ObjectId, PlaceId, Source};

/// What is asked of a run that takes work while it works. Tasks are named by their top nodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Work {
    /// Do this too.
    Submit(Box<Submission>),
    /// Give up a task: what runs of it is canceled, and what it began is cleaned up.
    Cancel {
        /// The task.
        task: NodeId,
    },
    /// Grant a task what it asks for, or not.
    Grant {
        /// The task; none for all together, those that come later included.
        task: Option<NodeId>,
        /// How.
        granting: Granting,
    },
    /// Add a part to a live tree.
    Add {
        /// Below which node.
        under: NodeId,
        /// Behind how many of its children; none behind all.
        behind: Option<u32>,
        /// What.
        branch: Branch,
    },
    /// Take a part out of a live tree.
    Remove {
        /// With everything below it.
        node: NodeId,
    },
    /// Put another part in the place of one.
    Replace {
        /// With everything below it.
        node: NodeId,
        /// What comes in its place.
        branch: Branch,
    },
    /// An object came into the room.
    AddObject {
        /// What it is called.
        name: String,
        /// Where it lies.
        place: PlaceId,
    },
    /// An object left the room.
    RemoveObject {
        /// Which.
        object: ObjectId,
    },
}

/// A task that is submitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Submission {
    /// What it is to be called.
    pub name: String,
    /// How urgent it is, in the place of what its file says of its top.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub priority: Option<i32>,
    /// How it is granted what it asks for.
    #[serde(default)]
    pub granting: Granting,
    /// What is to be done.
    pub branch: Branch,
}

/// A part of a tree, as it was written and as it was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Branch {
    /// The files.
    pub source: Source,
    /// What they say. A log does not tell it: it is read once more.
    #[serde(skip)]
    pub fragment: Option<Arc<Fragment>>,
}

/// Whether a task is granted what it asks for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Granting {
    /// As the rules have it.
    #[default]
    Freely,
    /// Nothing is granted; what runs goes on to its end, and what it holds it keeps.
    Paused,
    /// One set of behaviors is granted, then it is paused.
    Step,
}

impl Work {
    /// The part of a tree that comes with it.
    pub fn branch(&self) -> Option<&Branch> {
        match self {
            Self::Submit(submission) => Some(&submission.branch),
            Self::Add { branch, .. } | Self::Replace { branch, .. } => Some(branch),
            Self::Cancel { .. } | Self::Grant { .. } | Self::Remove { .. } => None,
            Self::AddObject { .. } | Self::RemoveObject { .. } => None,
        }
    }

    /// The same, to be read.
    pub fn branch_mut(&mut self) -> Option<&mut Branch> {
        match self {
            Self::Submit(submission) => Some(&mut submission.branch),
            Self::Add { branch, .. } | Self::Replace { branch, .. } => Some(branch),
            Self::Cancel { .. } | Self::Grant { .. } | Self::Remove { .. } => None,
            Self::AddObject { .. } | Self::RemoveObject { .. } => None,
        }
    }
}

/// What came of work that was asked for: the node that was added, if one was.
pub type Worked = Result<Option<NodeId>, Hindrance>;

/// Why work is not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hindrance {
    /// The run has a mission of its own.
    HasMission,
    /// It has not begun, or has not gone on yet.
    NotBegun,
    /// It is told to end, or is over.
    Over,
    /// What is to be added was not read.
    Unread,
    /// There are as many nodes as there can be.
    Full {
        /// How many there can be.
        most: u32,
    },
    /// There is no such task, or no more.
    NoTask,
    /// There is no such node, or no more.
    NoNode,
    /// The task is given up already.
    GivenUp,
    /// A task as a whole is submitted and canceled.
    IsTask,
    /// Something of it runs.
    Runs {
        /// The behavior.
        leaf: NodeId,
    },
    /// It keeps something.
    Holds {
        /// What.
        resource: super::ResourceId,
    },
    /// It is done already.
    IsDone,
    /// It is over: done, failed, or given up.
    IsOver,
    /// It has no children, and can have none: a behavior, or what is there to clean up.
    HasNoChildren,
    /// Nothing would be left of the node above.
    IsLast,
    /// A THEN is beyond that place already.
    IsPassed,
    /// There is an object of that name.
    NameTaken {
        /// It.
        object: ObjectId,
    },
    /// No object can be called so.
    Misnamed,
    /// There is no such place.
    NoPlace,
    /// There is no such object, or no more.
    NoObject,
    /// It is in a gripper.
    ObjectHeld,
    /// A behavior that is not over is about it.
    ObjectNeeded {
        /// The behavior.
        by: NodeId,
    },
}

impl Hindrance {
    /// As a sentence without its end.
    pub fn sentence(self, names: &Names) -> String {
        match self {
            Self::HasMission => "this run has a mission of its own, and takes no further tasks".into(),
            Self::NotBegun => "the run has not begun yet".into(),
            Self::Over => "the run is over, or about to be".into(),
            Self::Unread => "what is to be added could not be read".into(),
            Self::Full { most } => format!("there are {most} nodes already, and there can be no more"),
            Self::NoTask => "there is no such task, or it is over".into(),
            Self::NoNode => "there is no such node, or it is gone".into(),
            Self::GivenUp => "the task is canceled already".into(),
            Self::IsTask => "that is a whole task: those are submitted and canceled".into(),
            Self::Runs { leaf } => format!("{} runs", names.node(leaf)),
            Self::Holds { resource } => format!("it keeps {}", names.resource(resource)),
            Self::IsDone => "it is done already".into(),
            Self::IsOver => "it is over already".into(),
            Self::HasNoChildren => "only AND, OR and THEN have children that come and go".into(),
            Self::IsLast => "nothing would be left of the node above it".into(),
            Self::IsPassed => "the THEN is beyond that place already".into(),
            Self::NameTaken { object } => format!("there is an object {} already", names.object(object)),
            Self::Misnamed => "no object can be called so".into(),
            Self::NoPlace => "there is no such place".into(),
            Self::NoObject => "there is no such object, or it is gone".into(),
            Self::ObjectHeld => "it is in a gripper".into(),
            Self::ObjectNeeded { by } => format!("{} is about it", names.node(by)),
        }
    }
}
