//! Whom and what a record speaks of.

use ambidex_model::{
    Blocked, Change, CommandId, Consequences, ControllerId, ControllerMessage, FromController, Message, Misheld,
    MissionEnd, NodeId, Origin, Reason, Record, Request, ResourceId, StopCause, ToController, Told,
};

use ambidex_record::History;

/// Whether a record is from, to or about a node that is wanted.
pub(super) fn of_node(record: &Record, history: &History, is_wanted: &dyn Fn(NodeId) -> bool) -> bool {
    let is = &|node: NodeId| is_wanted(node);
    let ids = history.names().nodes.len();
    match record {
        Record::Header(_) | Record::World { .. } | Record::Denied { .. } => false,
        Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => false,
        Record::Told { input, .. } => match input {
            Told::Ended { leaf, .. } => is(*leaf),
            Told::Begin { .. } | Told::Resumed | Told::World { .. } | Told::End { .. } => false,
            Told::Service { .. } | Told::Woke | Told::Work { .. } => false,
        },
        Record::Served { .. } | Record::Awaited { .. } => false,
        Record::Infeasible { leaf, consequences, .. } => is(*leaf) || consequences_of(consequences, is),
        Record::TimedOut { node, consequences, .. } => is(*node) || consequences_of(consequences, is),
        Record::Reopened { reopened, .. } => {
            is(reopened.node) || is(reopened.up_to) || reopened.reset.iter().copied().any(is)
        }
        Record::Overtaken { skips, goal, consequences, .. } => {
            skips.iter().any(|skip| skip.nodes(ids).any(is)) || is(*goal) || consequences_of(consequences, is)
        }
        Record::Ending { .. } => false,
        // What comes has its name only then.
        Record::Added { under, .. } => is(*under),
        Record::Removed { node, .. } => is(*node),
        Record::Granting { task, .. } => task.is_some_and(is),
        Record::Canceled { task, .. } | Record::TaskEnded { task, .. } => is(*task),
        Record::Stalled { tasks, .. } => tasks.iter().any(|task| is(*task)),
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } | Record::Declined { .. } => false,
        Record::Checkpoint { .. } => false,
        Record::Leaving { way: node, .. } | Record::Cleaning { node, .. } => is(*node),
        Record::Cleaned { node, consequences, .. } => is(*node) || consequences_of(consequences, is),
        Record::Stopped { leaves, cause, .. } => {
            leaves.iter().any(|leaf| is(*leaf)) || matches!(cause, StopCause::Preempted { by } if is(*by))
        }
        Record::Woke { leaves, .. } => leaves.iter().any(|leaf| is(*leaf)),
        Record::Sent { from, to, message, .. } => is(*from) || is(*to) || message_of(message, is),
        Record::Decided { granted, refused, reopened, .. } => {
            granted.iter().any(|grant| is(grant.leaf()) || grant.skipped(ids).any(is))
                || blocked_of(refused, is)
                || reopened.iter().any(|reopened| is(reopened.node) || is(reopened.up_to))
        }
        Record::Released { leaf, consequences, .. } => is(*leaf) || consequences_of(consequences, is),
        Record::Resource { state, .. } => state.leases().iter().any(|lease| is(lease.holder) || is(lease.behavior)),
        Record::Controller { controller, message, .. } => {
            message.leaf().into_iter().any(is) || behaviors(*controller, message, history).iter().copied().any(is)
        }
        Record::Ended { end, .. } => matches!(end, MissionEnd::Failed(node) | MissionEnd::NodeLost(node) if is(*node)),
    }
}

/// Whether a record speaks of a resource.
pub(super) fn of_resource(record: &Record, wanted: ResourceId) -> bool {
    let requested = |request: &Request| {
        let mut candidates = request.claims.iter().flat_map(|need| &need.candidates);
        candidates.any(|candidate| candidate.resource == wanted)
    };
    let refused = |blocked: &[Blocked]| blocked.iter().any(|one| lacks(&one.reason, wanted));
    match record {
        Record::Sent { message, .. } => match message {
            Message::Answer { request, blocked, .. } => request.as_deref().is_some_and(requested) || refused(blocked),
            Message::Activation | Message::Verdict { .. } | Message::Release { .. } => false,
        },
        Record::Decided { granted, refused: blocked, reopened, .. } => {
            granted.iter().any(|grant| grant.bindings.iter().any(|binding| binding.resource == wanted))
                || refused(blocked)
                || reopened.iter().any(|reopened| reopened.lapsed() == Some(wanted))
        }
        Record::Released { changes, .. } => changes.iter().any(|change| moves(change, wanted)),
        Record::World { change, .. } | Record::Denied { change, .. } => moves(change, wanted),
        Record::Resource { resource, .. } => *resource == wanted,
        Record::Told { input, .. } => match input {
            Told::Ended { outcome, .. } => outcome.changes.iter().any(|change| moves(change, wanted)),
            Told::World { change, .. } => moves(change, wanted),
            Told::Service { changes, .. } => changes.iter().any(|change| moves(change, wanted)),
            Told::Begin { .. } | Told::Resumed | Told::Woke | Told::Work { .. } | Told::End { .. } => false,
        },
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => false,
        Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => false,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } | Record::Declined { .. } => false,
        Record::Checkpoint { .. } => false,
        Record::Served { resources, .. } => resources.contains(&wanted),
        Record::Infeasible { reason, .. } => lacks(reason, wanted),
        Record::Reopened { reopened, .. } => reopened.ended.iter().any(|kept| kept.resource == wanted),
        Record::TimedOut { .. } | Record::Overtaken { .. } => false,
        Record::Ending { .. } | Record::Leaving { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } => false,
        Record::Woke { .. } | Record::Awaited { .. } => false,
        Record::Header(_) | Record::Controller { .. } | Record::Ended { .. } => false,
        Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } | Record::Stopped { .. } => false,
    }
}

/// Whether a record speaks of a controller.
pub(super) fn of_controller(record: &Record, wanted: ControllerId) -> bool {
    match record {
        Record::Controller { controller, .. } => *controller == wanted,
        Record::Released { end, .. } | Record::Sent { message: Message::Release { end, .. }, .. } => {
            end.at_fault() == Some(wanted)
        }
        Record::Ended { end, .. } => *end == MissionEnd::ControllerLost(wanted),
        Record::Told { input: Told::Service { controller, .. }, .. } | Record::Served { controller, .. } => {
            *controller == wanted
        }
        Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => false,
        Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => false,
        Record::ObjectAdded { .. } | Record::ObjectRemoved { .. } | Record::Declined { .. } => false,
        Record::Checkpoint { .. } => false,
        Record::Infeasible { .. } | Record::TimedOut { .. } => false,
        Record::Reopened { .. } | Record::Overtaken { .. } => false,
        Record::Ending { .. } | Record::Leaving { .. } | Record::Cleaning { .. } | Record::Cleaned { .. } => false,
        Record::Woke { .. } | Record::Awaited { .. } => false,
        Record::Told { input: Told::Ended { outcome, .. }, .. } => outcome.end.at_fault() == Some(wanted),
        Record::Told { input: Told::World { origin, .. }, .. }
        | Record::World { origin, .. }
        | Record::Denied { origin, .. } => *origin == Origin::Controller(wanted),
        Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => false,
        Record::Header(_)
        | Record::Stopped { .. }
        | Record::Sent { .. }
        | Record::Decided { .. }
        | Record::Resource { .. } => false,
    }
}

/// The behaviors for which the command is that a message is about.
pub(super) fn behaviors<'a>(of: ControllerId, message: &ControllerMessage, history: &'a History) -> &'a [NodeId] {
    let command = command(message).and_then(|id| history.controllers().command(of, id));
    command.map_or(&[], |command| &command.leaves)
}

/// The command that a message is about.
fn command(message: &ControllerMessage) -> Option<CommandId> {
    match message {
        ControllerMessage::Attached | ControllerMessage::Refused { .. } => None,
        ControllerMessage::Misreported { .. } | ControllerMessage::Lost { .. } => None,
        ControllerMessage::Diagnosed { .. } => None,
        ControllerMessage::Told { message, .. } => match message {
            ToController::Configure { .. } => None,
            ToController::Goal { id, .. } | ToController::Cancel { id } => Some(*id),
        },
        ControllerMessage::Joined { id, .. } => Some(*id),
        ControllerMessage::Heard { message } => match message {
            FromController::Configured { .. } => None,
            FromController::Accepted { id, .. }
            | FromController::Rejected { id, .. }
            | FromController::Feedback { id, .. }
            | FromController::Result { id, .. } => Some(*id),
        },
    }
}

fn message_of(message: &Message, is: &impl Fn(NodeId) -> bool) -> bool {
    match message {
        Message::Activation => false,
        Message::Answer { asking, blocked, .. } => asking.iter().any(|&leaf| is(leaf)) || blocked_of(blocked, is),
        Message::Verdict { granted, stopped, .. } => granted.iter().chain(stopped).any(|&leaf| is(leaf)),
        Message::Release { leaf, .. } => is(*leaf),
    }
}

fn blocked_of(blocked: &[Blocked], is: &impl Fn(NodeId) -> bool) -> bool {
    blocked.iter().any(|one| is(one.leaf))
}

fn consequences_of(consequences: &Consequences, is: &impl Fn(NodeId) -> bool) -> bool {
    let completed = consequences.completed.iter().any(|done| is(done.node) || done.heir.is_some_and(is));
    completed || consequences.failed.is_some_and(is)
}

fn lacks(reason: &Reason, wanted: ResourceId) -> bool {
    match reason {
        Reason::Held { resource, .. } | Reason::Outbid { resource, .. } => *resource == wanted,
        Reason::LessUrgent { resource, .. } | Reason::DoneOftener { resource, .. } => *resource == wanted,
        Reason::Reserved { resource, .. } => *resource == Some(wanted),
        Reason::Unavailable { resource, .. } | Reason::Unfit { resource } => *resource == wanted,
        Reason::Taken { by, .. } | Reason::Misheld(Misheld::Too { by, .. }) => *by == wanted,
        Reason::AlreadyDone { lacks: inner, .. } => lacks(inner, wanted),
        Reason::WouldDeadlock { deadlock } => {
            [deadlock.other, deadlock.own].iter().any(|one| one.holds == Some(wanted))
        }
        Reason::Satisfied
        | Reason::BackingOff { .. }
        | Reason::Unwanted
        | Reason::NoneFree { .. }
        | Reason::TooFew { .. }
        | Reason::Missing { .. }
        | Reason::OutOfReach { .. }
        | Reason::OutOfReachLater { .. }
        | Reason::Unreachable { .. }
        | Reason::NoSpot { .. }
        | Reason::NotHeld { .. }
        | Reason::Misheld(Misheld::NotSo { .. } | Misheld::Last { .. } | Misheld::Full { .. })
        | Reason::Elsewhere { .. }
        | Reason::Nowhere { .. }
        | Reason::NotAt { .. }
        | Reason::Driving { .. }
        | Reason::NoPath { .. }
        | Reason::InTheWay { .. }
        | Reason::PathNotFound { .. }
        | Reason::Fact { .. }
        | Reason::NothingAvailable { .. }
        | Reason::Outdone { .. }
        | Reason::SameObject { .. }
        | Reason::Clash { .. }
        | Reason::Alternative { .. }
        | Reason::WholeRobot { .. }
        | Reason::NotItsTurn { .. }
        | Reason::Ending { .. }
        | Reason::TooEarly { .. }
        | Reason::NotYet { .. }
        | Reason::GivenUp { .. }
        | Reason::OutOfTime { .. } => false,
    }
}

fn moves(change: &Change, wanted: ResourceId) -> bool {
    match change {
        Change::Object(_, at) => at.holders().contains(&wanted),
        Change::Taken(_, resource) | Change::Emptied(resource) => *resource == wanted,
        Change::Base(_) | Change::Fact(..) | Change::Laid(..) | Change::Blocked(_) | Change::Cleared(_) => false,
    }
}
