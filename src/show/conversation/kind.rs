//! The kinds of records as a person names them.

use ambidex_model::{ControllerMessage, FromController, Message, Record, ToController};

/// What kind of record it is.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, strum::EnumString, strum::IntoStaticStr, strum::VariantArray,
)]
#[strum(serialize_all = "snake_case")]
pub enum Kind {
    /// What the ids stand for.
    Header,
    /// Down the tree: the state of resources and world.
    Activation,
    /// Up the tree: what is asked for.
    Answer,
    /// Down the tree: what came of it.
    Verdict,
    /// Up the tree: a behavior ended.
    Release,
    /// To root from outside the tree.
    Told,
    /// Root took over where a driving base is.
    Observed,
    /// Root took up what it was told.
    Turn,
    /// The mission began, or went on.
    Began,
    /// What root decided.
    Decided,
    /// Root told behaviors to end.
    Stopped,
    /// Root applied the end of a behavior.
    Released,
    /// The world changed from outside.
    World,
    /// A change of the world from outside was refused.
    Denied,
    /// Behaviors that waited after a failure ask again.
    Woke,
    /// A controller went, is awaited no more, or came back.
    Served,
    /// Nothing can go on without a controller that is away.
    Awaited,
    /// A behavior can never run, and has failed for that.
    Infeasible,
    /// A task node took too long.
    TimedOut,
    /// A way is left, or something is tried again.
    Reopened,
    /// Others did what was still to be done.
    Overtaken,
    /// The mission is to end.
    Ending,
    /// An OR is to leave its way.
    Leaving,
    /// A cleanup begins.
    Cleaning,
    /// A cleanup ended without the end of a behavior.
    Cleaned,
    /// A task, or another part of the tree, came.
    Added,
    /// A part of the tree was taken out.
    Removed,
    /// A task is paused, goes on, or takes a step.
    Granting,
    /// A task is given up.
    Canceled,
    /// A task is over.
    TaskEnded,
    /// Nothing of some tasks can go on.
    Stalled,
    /// An object came into the room.
    ObjectAdded,
    /// An object left the room.
    ObjectRemoved,
    /// Work that was asked for is not taken.
    Declined,
    /// A log goes on where another was put aside.
    Checkpoint,
    /// A resource is held otherwise.
    Resource,
    /// A controller is there.
    Attached,
    /// To a controller: its limits.
    Configure,
    /// To a controller: do this.
    Goal,
    /// A behavior shares a goal that lasts.
    Joined,
    /// To a controller: stop doing it.
    Stop,
    /// From a controller: ready.
    Configured,
    /// From a controller: taken.
    Accepted,
    /// From a controller: not taken.
    Rejected,
    /// From a controller: under way.
    Feedback,
    /// From a controller: ended.
    Result,
    /// What came from a controller was not used.
    Refused,
    /// A controller is gone.
    Lost,
    /// How well a controller is came to be different.
    Diagnosed,
    /// The mission is over.
    Ended,
}

impl Kind {
    /// Whether it is shown only when it is asked for: what comes often and says little, or what other records say again.
    pub fn is_minor(self) -> bool {
        matches!(self, Self::Feedback | Self::Diagnosed | Self::Told | Self::Observed | Self::Turn | Self::Began)
    }

    /// The word for it on a command line.
    pub fn word(self) -> &'static str {
        self.into()
    }

    /// The kind of a record.
    pub fn of(record: &Record) -> Self {
        match record {
            Record::Header(_) => Self::Header,
            Record::Sent { message, .. } => match message {
                Message::Activation => Self::Activation,
                Message::Answer { .. } => Self::Answer,
                Message::Verdict { .. } => Self::Verdict,
                Message::Release { .. } => Self::Release,
            },
            Record::Told { .. } => Self::Told,
            Record::Observed { .. } => Self::Observed,
            Record::Turn { .. } => Self::Turn,
            Record::Began { .. } => Self::Began,
            Record::Decided { .. } => Self::Decided,
            Record::Stopped { .. } => Self::Stopped,
            Record::Released { .. } => Self::Released,
            Record::World { .. } => Self::World,
            Record::Denied { .. } => Self::Denied,
            Record::Woke { .. } => Self::Woke,
            Record::Served { .. } => Self::Served,
            Record::Awaited { .. } => Self::Awaited,
            Record::Infeasible { .. } => Self::Infeasible,
            Record::TimedOut { .. } => Self::TimedOut,
            Record::Reopened { .. } => Self::Reopened,
            Record::Overtaken { .. } => Self::Overtaken,
            Record::Ending { .. } => Self::Ending,
            Record::Leaving { .. } => Self::Leaving,
            Record::Cleaning { .. } => Self::Cleaning,
            Record::Cleaned { .. } => Self::Cleaned,
            Record::Added { .. } => Self::Added,
            Record::Removed { .. } => Self::Removed,
            Record::Granting { .. } => Self::Granting,
            Record::Canceled { .. } => Self::Canceled,
            Record::TaskEnded { .. } => Self::TaskEnded,
            Record::Stalled { .. } => Self::Stalled,
            Record::ObjectAdded { .. } => Self::ObjectAdded,
            Record::ObjectRemoved { .. } => Self::ObjectRemoved,
            Record::Declined { .. } => Self::Declined,
            Record::Checkpoint { .. } => Self::Checkpoint,
            Record::Resource { .. } => Self::Resource,
            Record::Controller { message, .. } => Self::of_controller(message),
            Record::Ended { .. } => Self::Ended,
        }
    }

    fn of_controller(message: &ControllerMessage) -> Self {
        match message {
            ControllerMessage::Attached => Self::Attached,
            ControllerMessage::Told { message, .. } => match message {
                ToController::Configure { .. } => Self::Configure,
                ToController::Goal { .. } => Self::Goal,
                ToController::Cancel { .. } => Self::Stop,
            },
            ControllerMessage::Joined { .. } => Self::Joined,
            ControllerMessage::Heard { message } => match message {
                FromController::Configured { .. } => Self::Configured,
                FromController::Accepted { .. } => Self::Accepted,
                FromController::Rejected { .. } => Self::Rejected,
                FromController::Feedback { .. } => Self::Feedback,
                FromController::Result { .. } => Self::Result,
            },
            ControllerMessage::Refused { .. } | ControllerMessage::Misreported { .. } => Self::Refused,
            ControllerMessage::Lost { .. } => Self::Lost,
            ControllerMessage::Diagnosed { .. } => Self::Diagnosed,
        }
    }
}
