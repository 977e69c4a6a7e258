//! What reaches root, what nodes and controllers say, and how a mission ends, as records have it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{
    Blocked, Change, CommandId, ControllerId, Diagnosis, End, FromController, Level, Loss, Misreport, NodeId, Origin,
    Outcome, Rejection, Report, Request, ToController, Vitals, Work,
};

/// What reaches root from outside the tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Told {
    /// Begin the mission, or go on with it.
    Begin {
        /// What controllers say of the world, which wins over what is known of it.
        changes: Vec<Change>,
    },
    /// Its runtime was gone, and another goes on. Nothing begins before it is told to.
    Resumed,
    /// The world is different, and nobody in the tree did it.
    World {
        /// What is different.
        change: Change,
        /// Who says so.
        origin: Origin,
    },
    /// The goal of a behavior ended.
    Ended {
        /// The behavior.
        leaf: NodeId,
        /// How, and what its controllers said of the world then.
        outcome: Outcome,
    },
    /// A controller is away, or came back.
    Service {
        /// Which controller.
        controller: ControllerId,
        /// How it came to be away; none where it came back.
        outage: Option<Loss>,
        /// What it says of the world, now that it is back.
        changes: Vec<Change>,
    },
    /// A moment came for which root waited.
    Woke,
    /// Somebody asks for work.
    Work {
        /// For what.
        work: Work,
    },
    /// End the mission in order: nothing is granted any more, what runs is canceled first.
    End {
        /// Why.
        end: MissionEnd,
    },
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
    /// Down, to where something starts or is to end.
    Verdict {
        /// Granted below this edge.
        granted: Vec<NodeId>,
        /// Told to end below this edge.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        stopped: Vec<NodeId>,
    },
    /// Up: a behavior ended.
    Release {
        /// The behavior that ended.
        leaf: NodeId,
        /// Success, failure with its fault, or cancel.
        end: End,
    },
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
    /// What it says of the world was not heard.
    Misreported {
        /// What it said.
        report: Report,
        /// Why not.
        why: Misreport,
    },
    /// It is gone.
    Lost {
        /// How that was seen.
        why: Loss,
    },
    /// How well it is by the diagnosis of each second, where that differs from the second before. Nothing follows from it.
    Diagnosed {
        /// How well it is.
        level: Level,
        /// Why it is said to be so.
        message: Diagnosis,
        /// What was counted up to then.
        values: Box<Vitals>,
    },
}

impl ControllerMessage {
    /// The behavior for which the controller was told something.
    pub fn leaf(&self) -> Option<NodeId> {
        match self {
            Self::Told { leaf, .. } => *leaf,
            Self::Joined { leaf, .. } => Some(*leaf),
            Self::Attached | Self::Heard { .. } | Self::Refused { .. } => None,
            Self::Misreported { .. } | Self::Lost { .. } | Self::Diagnosed { .. } => None,
        }
    }
}

/// How a mission ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionEnd {
    /// The task is complete.
    Done,
    /// The task failed, first at this node: a leaf, or one that took too long.
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
