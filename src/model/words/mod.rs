//! The vocabulary: what travels between the rooms. No IO, no clock, no decisions beyond the table's own rules.

mod claim;
mod consequences;
mod deadlock;
mod failure;
mod goal;
mod header;
mod holders;
mod ids;
mod labels;
mod lineage;
mod link;
mod loss;
mod matching;
mod names;
mod pose;
mod reason;
mod record;
mod rejection;
mod request;
mod resource;
mod service;
mod source;
mod spec;
mod suggestion;
mod terms;
mod time;
mod world_state;

pub use claim::{Access, Claim, Retention, Selector};
pub use consequences::{Cause, Completion, Consequences, Deadline, Failing, Kept, Reopened};
pub use deadlock::{Deadlock, Standstill};
pub use failure::{Failures, Flaw, FlawKind, Mishap};
pub use goal::{ARGUMENTS_MAX, Call, Command, End, Fault, Goal, Mode, NO_ARGUMENTS, Outcome, Part};
pub use header::{EntryKind, Header, JOURNAL_VERSION, NodeEntry};
pub use holders::{HOLDERS_MAX, HeldBy, Hold, Holders, Misheld};
pub use ids::{ChannelId, CommandId, ControllerId, FactId, NodeId, ObjectId, PlaceId, ResourceId, TypeId};
pub use labels::{Labels, NAME_MAX, Name};
pub use lineage::{Lineage, NodeRange};
pub use link::{ControllerState, FromController, PartEnd, ToController};
pub use loss::{Inhibition, Loss};
pub use matching::match_claims;
pub use names::{Names, is_obeyed, make_legible};
pub use pose::Pose;
pub use reason::{Blocked, Reason};
pub use record::{ControllerMessage, Message, MissionEnd, Record, Told};
pub use rejection::{Refusal, Rejection};
pub use request::{Binding, Candidate, ClaimOptions, Grant, Request};
pub use resource::{Heir, Lease, LeaseKind, Resource, ResourceTable};
pub use service::Service;
pub use source::{Source, SourceFile};
pub use spec::{
    ArmSpec, BaseSpec, BehaviorSpec, ControllerKind, ControllerSpec, Elsewhere, HeadSpec, Limits, MissionSpec,
    NodeKind, Obstacle, PlaceSpec, Potential, ResourceSpec, RobotSpec, Topology, TreeSpec, WorldSpec,
};
pub use suggestion::{nearest, suggestion};
pub use terms::{CommandTerm, Condition, EffectTerm, Task};
pub use time::Time;
pub use world_state::{Change, Location, WorldState};
