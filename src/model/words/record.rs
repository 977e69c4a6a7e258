//! What a run leaves behind: typed records, one per line of the journal.

use serde::{Deserialize, Serialize};

use super::{
    Blocked, Change, Consequences, ControllerId, ControllerMessage, Deadline, End, FactId, Grant, Granting, Header,
    Hindrance, Message, MissionEnd, NodeEntry, NodeId, NodeRange, ObjectId, Objection, Origin, PlaceId, Reason,
    Reopened, Resource, ResourceId, Service, StopCause, TaskEntry, Time, Told, Urged, WorldState,
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
        skips: Vec<NodeRange>,
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
    /// Nothing can go on without a controller that is away, or before others set or clear facts, or before what came to stand
    /// in the way is gone.
    Awaited {
        /// Robot time since when.
        at: Time,
        /// Until when it is awaited; none for as long as it is inhibited, for facts, and for what stands in the way.
        until: Option<Time>,
        /// The facts.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        facts: Vec<FactId>,
        /// Places to which no path leads past what came to stand in the room. Where there are neither, it is a controller.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        places: Vec<PlaceId>,
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
    /// A part was added to the tree: a task that was submitted, or by an edit.
    Added {
        /// Robot time of the adding.
        at: Time,
        /// Its top, and the first of its ids, which follow each other.
        top: NodeId,
        /// Below which node.
        under: NodeId,
        /// Behind how many of its children.
        behind: u32,
        /// What it consists of, parents counted from its top.
        nodes: Vec<NodeEntry>,
        /// What its nodes are called.
        names: Vec<String>,
        /// Channels that the run did not have; their ids go on behind its own.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        channels: Vec<String>,
        /// Of a task: what it is called, and how urgent it is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        task: Option<TaskEntry>,
    },
    /// A part was taken out of the tree by an edit.
    Removed {
        /// Robot time of the removing.
        at: Time,
        /// Its top.
        node: NodeId,
    },
    /// How a task is granted what it asks for is different.
    Granting {
        /// Robot time since when.
        at: Time,
        /// The task; none for all together.
        task: Option<NodeId>,
        /// How.
        granting: Granting,
    },
    /// A task is given up: what runs of it is stopped, what it began is cleaned up, and nothing else of it begins.
    Canceled {
        /// Robot time at which root took it up.
        at: Time,
        /// The task.
        task: NodeId,
        /// Until when cleanups may take.
        until: Time,
    },
    /// A task is over and gone. Full grippers that it left are everybody's.
    TaskEnded {
        /// Robot time of the end.
        at: Time,
        /// The task.
        task: NodeId,
        /// Done, or why not.
        end: MissionEnd,
    },
    /// Nothing of some tasks runs and nothing of them can, while nothing becomes different.
    Stalled {
        /// Robot time at which root saw it.
        at: Time,
        /// All of which that is so now, in their order; none where it is so of none any more.
        tasks: Vec<NodeId>,
        /// Why none of their behaviors runs, of those tasks of which it was not so before.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        blocked: Vec<Blocked>,
    },
    /// An object came into the room.
    ObjectAdded {
        /// Robot time at which root took it up.
        at: Time,
        /// Its id, the next one.
        object: ObjectId,
        /// What it is called.
        name: String,
        /// Where it lies.
        place: PlaceId,
    },
    /// An object left the room.
    ObjectRemoved {
        /// Robot time at which root took it up.
        at: Time,
        /// Which.
        object: ObjectId,
    },
    /// Work that was asked for is not taken.
    Declined {
        /// Robot time at which root decided it.
        at: Time,
        /// Which of all that was asked for, counted from 1.
        number: u64,
        /// Why not.
        why: Hindrance,
    },
    /// What the run was when its log was put aside: all that stands behind it follows from this.
    Checkpoint {
        /// Robot time of the saving.
        at: Time,
        /// When the run had begun, robot time.
        begun: Time,
        /// All of it, as text of its own ([`Saved`](crate::state::Saved) in JSON).
        saved: String,
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
            | Record::Checkpoint { at, .. }
            | Record::Added { at, .. }
            | Record::Removed { at, .. }
            | Record::Granting { at, .. }
            | Record::Canceled { at, .. }
            | Record::TaskEnded { at, .. }
            | Record::Stalled { at, .. }
            | Record::ObjectAdded { at, .. }
            | Record::ObjectRemoved { at, .. }
            | Record::Declined { at, .. }
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
            Self::Added { .. } | Self::Removed { .. } | Self::Granting { .. } | Self::Canceled { .. } => true,
            Self::TaskEnded { .. } | Self::Stalled { .. } | Self::Declined { .. } => true,
            Self::ObjectAdded { .. } | Self::ObjectRemoved { .. } => true,
            Self::Header(_) | Self::Told { .. } | Self::Observed { .. } | Self::Turn { .. } => false,
            Self::Sent { .. } | Self::Controller { .. } | Self::Checkpoint { .. } => false,
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
