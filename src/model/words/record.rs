//! What a run leaves behind: typed records, one per line of the journal.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{
    Blocked, Change, CommandId, Consequences, ControllerId, Deadline, End, FactId, FromController, Grant, Header, Loss,
    Misreport, NodeId, NodeRange, Objection, Origin, Outcome, Reason, Rejection, Reopened, Report, Request, Resource,
    ResourceId, Service, StopCause, Time, ToController, Urged, WorldState,
};

/// One line of the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "record", rename_all = "snake_case")]
pub enum Record {
    /// The first line: what the ids stand for.
    Header(Box<Header>),
    /// Something from outside the tree reached root: with the turns, all that its decisions depend on.
    Told {
        /// Robot time of the coming.
        at: Time,
        /// What it was.
        input: Told,
    },
    /// Where the base is while it drives, as root took it over before a turn; no round comes of it.
    Observed {
        /// Robot time of the taking over.
        at: Time,
        /// Where it is.
        change: Change,
    },
    /// Root took up what it was told since the last turn, in that order, and decided: what stands behind this line
    /// follows from the lines before it.
    Turn {
        /// Robot time of the turn.
        at: Time,
    },
    /// The mission began, or goes on after its runtime was gone: this is how things are.
    Began {
        /// Robot time of the beginning.
        at: Time,
        /// Robot pose, objects, facts.
        world_state: Box<WorldState>,
    },
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
        /// Task nodes whose time begins with what is granted.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        deadlines: Vec<Deadline>,
        /// All nodes that are as urgent as who waits for what they hold; none where that is as before.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        urged: Option<Vec<Urged>>,
        /// All tasks that have waited for so long that it is their turn; none where that is as before.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        overdue: Option<Vec<NodeId>>,
    },
    /// A behavior can never run as things are: it has failed for good without having run.
    Infeasible {
        /// Robot time at which root saw it.
        at: Time,
        /// The behavior.
        leaf: NodeId,
        /// What nothing makes so any more, or what the robot lacks.
        reason: Reason,
        /// What fails with it.
        consequences: Consequences,
    },
    /// A task node took longer than it may.
    TimedOut {
        /// Robot time at which root saw it.
        at: Time,
        /// The node.
        node: NodeId,
        /// What fails with it.
        consequences: Consequences,
    },
    /// Something is tried again or otherwise, without a round that decided it.
    Reopened {
        /// Robot time at which root did it.
        at: Time,
        /// What, and why.
        reopened: Reopened,
    },
    /// A THEN goes on behind a child whose goal others have reached.
    Overtaken {
        /// Robot time at which root saw it.
        at: Time,
        /// The behavior that cannot run, and need not.
        leaf: NodeId,
        /// Children of the THEN that count as done now; the last one is what others did.
        skip: NodeRange,
        /// That last one.
        goal: NodeId,
        /// What is complete with it.
        consequences: Consequences,
    },
    /// Root told behaviors to end.
    Stopped {
        /// Robot time of the telling.
        at: Time,
        /// Whom, in tree order.
        leaves: Vec<NodeId>,
        /// Why.
        #[serde(default, skip_serializing_if = "StopCause::is_end")]
        cause: StopCause,
    },
    /// The mission is to end: what runs is stopped, cleanups run, and nothing else begins.
    Ending {
        /// Robot time at which root took it up.
        at: Time,
        /// How it will have ended.
        end: MissionEnd,
        /// Until when cleanups may take.
        until: Time,
    },
    /// An OR is to leave its way, once what is to be cleaned up in it is.
    Leaving {
        /// Robot time at which root saw it.
        at: Time,
        /// The way.
        way: NodeId,
    },
    /// A cleanup begins: nothing else runs below its node any more.
    Cleaning {
        /// Robot time at which root began it.
        at: Time,
        /// The node with body and cleanup.
        node: NodeId,
    },
    /// A cleanup ended without the end of a behavior: there was nothing to be done, or it could not be granted.
    Cleaned {
        /// Robot time at which root saw it.
        at: Time,
        /// The node with body and cleanup.
        node: NodeId,
        /// Whether there was nothing left to be done.
        is_done: bool,
        /// What follows.
        consequences: Consequences,
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
        /// Until when the behavior waits before it asks again; none where it does not.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        waits_until: Option<Time>,
        /// What would not do it, for reach or kind: it is no candidate before there is progress.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        unfit: Vec<ResourceId>,
    },
    /// Nodes that waited after a failure ask again.
    Woke {
        /// Robot time at which root applied it.
        at: Time,
        /// Which, in tree order.
        leaves: Vec<NodeId>,
    },
    /// A controller went, is not awaited any more, or came back.
    Served {
        /// Robot time at which root applied it.
        at: Time,
        /// Which controller.
        controller: ControllerId,
        /// What it moves, in resource order.
        resources: Vec<ResourceId>,
        /// What these are now.
        service: Service,
    },
    /// Nothing can go on without a controller that is away, or before others set or clear facts.
    Awaited {
        /// Robot time since when.
        at: Time,
        /// Until when it is awaited; none for as long as it is inhibited, and for facts.
        until: Option<Time>,
        /// The facts; none where it is a controller.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        facts: Vec<FactId>,
    },
    /// The world changed from outside.
    World {
        /// Robot time at which root applied it.
        at: Time,
        /// What is different, and was not before.
        change: Change,
        /// Who says so.
        origin: Origin,
    },
    /// What somebody outside said of the world is not taken.
    Denied {
        /// Robot time at which root decided it.
        at: Time,
        /// What would be different.
        change: Change,
        /// Who said so.
        origin: Origin,
        /// Why not.
        why: Objection,
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

/// The moment of a record, to be read or to be changed; none of the header.
macro_rules! moment {
    ($record:expr) => {
        match $record {
            Record::Header(_) => None,
            Record::Told { at, .. }
            | Record::Observed { at, .. }
            | Record::Turn { at }
            | Record::Began { at, .. }
            | Record::Stopped { at, .. }
            | Record::Sent { at, .. }
            | Record::Decided { at, .. }
            | Record::Released { at, .. }
            | Record::World { at, .. }
            | Record::Denied { at, .. }
            | Record::Woke { at, .. }
            | Record::Served { at, .. }
            | Record::Awaited { at, .. }
            | Record::Infeasible { at, .. }
            | Record::TimedOut { at, .. }
            | Record::Reopened { at, .. }
            | Record::Overtaken { at, .. }
            | Record::Ending { at, .. }
            | Record::Cleaning { at, .. }
            | Record::Leaving { at, .. }
            | Record::Cleaned { at, .. }
            | Record::Resource { at, .. }
            | Record::Controller { at, .. }
            | Record::Ended { at, .. } => Some(at),
        }
    };
}

impl Record {
    /// When; the header stands at the beginning of the run.
    pub fn at(&self) -> Time {
        moment!(self).copied().unwrap_or_default()
    }

    /// Puts another moment in the place of its own.
    pub fn set_at(&mut self, moment: Time) {
        if let Some(at) = moment!(self) {
            *at = moment;
        }
    }

    /// Whether it follows from what root was told and from its turns, so that it can be computed again.
    pub fn follows(&self) -> bool {
        match self {
            Self::Began { .. } | Self::Decided { .. } | Self::Stopped { .. } | Self::Released { .. } => true,
            Self::World { .. } | Self::Denied { .. } | Self::Resource { .. } | Self::Ended { .. } => true,
            Self::Woke { .. } | Self::Served { .. } | Self::Awaited { .. } => true,
            Self::Infeasible { .. } | Self::TimedOut { .. } | Self::Reopened { .. } | Self::Overtaken { .. } => true,
            Self::Ending { .. } | Self::Cleaning { .. } | Self::Cleaned { .. } | Self::Leaving { .. } => true,
            Self::Header(_) | Self::Told { .. } | Self::Observed { .. } | Self::Turn { .. } => false,
            Self::Sent { .. } | Self::Controller { .. } => false,
        }
    }

    /// With a decision, why everything else does not run.
    pub fn refusals(&self) -> &[Blocked] {
        if let Self::Decided { refused, .. } = self { refused } else { &[] }
    }

    /// Leaves out of a decision why everything else does not run; that can be computed again.
    pub fn forget_refusals(&mut self) {
        if let Self::Decided { refused, .. } = self {
            refused.clear();
        }
    }
}

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
}

impl ControllerMessage {
    /// The behavior for which the controller was told something.
    pub fn leaf(&self) -> Option<NodeId> {
        match self {
            Self::Told { leaf, .. } => *leaf,
            Self::Joined { leaf, .. } => Some(*leaf),
            Self::Attached | Self::Heard { .. } | Self::Refused { .. } => None,
            Self::Misreported { .. } | Self::Lost { .. } => None,
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
