//! The vocabulary: what travels between the rooms. No IO, no clock, no decisions beyond the table's own rules.

mod claim;
mod goal;
mod ids;
mod line;
mod link;
mod names;
mod pose;
mod reason;
mod record;
mod report;
mod request;
mod resource;
mod situation;
mod spec;
mod suggestion;
mod time;

pub use claim::{Access, Claim, Keep, Wanted};
pub use goal::{Command, End, Fault, Goal, Mode, Outcome, Part, Report};
pub use ids::{ChannelId, ControllerId, FactId, NodeId, ObjectId, PlaceId, ResourceId, TypeId};
pub use line::{Line, Span};
pub use link::{CommandId, ControllerState, FromController, PartEnd, Rejection, ToController};
pub use names::{Names, make_legible};
pub use pose::Pose;
pub use reason::Reason;
pub use record::{
    Blocked, Completion, ControllerMessage, EntryKind, Going, Header, JOURNAL_VERSION, Message, MissionEnd, NodeEntry,
    Record, Reopened,
};
pub use report::{Interval, MissionReport, Tally};
pub use request::{Binding, Candidate, Grant, Need, Request};
pub use resource::{Heir, Hold, Lease, Resource, ResourceTable};
pub use situation::{Change, Situation, Whereabouts};
pub use spec::{
    ArmSpec, BaseSpec, BehaviorSpec, CommandTerm, Condition, ControllerKind, ControllerSpec, EffectTerm, HeadSpec,
    MissionSpec, NodeKind, Obstacle, PlaceSpec, Potential, ResourceSpec, RobotSpec, Task, Topology, TreeSpec,
    WorldSpec,
};
pub use suggestion::{nearest, suggestion};
pub use time::Time;
