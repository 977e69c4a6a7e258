//! A status at one moment, with names instead of ids: what `--json` prints and what text is drawn from.

use serde::{Deserialize, Serialize};

use ambidex_model::{LeaseKind, Level, Mode, Vitals};
use ambidex_record::{LeafState, MissionOutcome};

use crate::tasks::TaskSummary;

/// Whether the process that writes the journal lives. No record tells it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum Daemon {
    /// It lives.
    Running {
        /// Its process id; none where only its hold on the journal tells of it.
        pid: Option<u32>,
    },
    /// There is none.
    Gone,
}

/// How far a mission is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Not every controller is there yet.
    Waiting,
    /// It runs.
    Running,
    /// It ended.
    Ended,
    /// It did not end, but its daemon did.
    Gone,
}

/// What a mission is at.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Snapshot {
    /// The mission's name.
    pub mission: String,
    /// The robot's name.
    pub robot: String,
    /// How requests are chosen.
    pub allocator: String,
    /// Whether the daemon lives.
    pub daemon: Daemon,
    /// How far it is.
    pub phase: Phase,
    /// The report's `outcome`; none before the end.
    pub outcome: Option<MissionOutcome>,
    /// At what it ended, as a sentence.
    pub why: Option<String>,
    /// Robot time of the last record, seconds.
    pub time_s: f64,
    /// Robot seconds from the first grant to the last release.
    pub makespan_s: f64,
    /// How many rounds were decided.
    pub rounds: u32,
    /// Steps so far: grants between two releases count once.
    pub step: usize,
    /// Messages between nodes so far.
    pub messages: u64,
    /// Behaviors that are done or skipped.
    pub done: usize,
    /// How many behaviors the task has.
    pub of: usize,
    /// Every task, in the order in which they came.
    pub tasks: Vec<TaskSummary>,
    /// Every node in tree order.
    pub nodes: Vec<NodeRow>,
    /// Every resource in resource order.
    pub resources: Vec<ResourceRow>,
    /// Every controller, in the order of the robot file.
    pub controllers: Vec<ControllerRow>,
    /// Base, objects and facts.
    pub world: WorldRow,
}

/// A node of the tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct NodeRow {
    /// Its id: its place in tree order.
    pub id: u32,
    /// What the mission calls it.
    pub name: String,
    /// `root`, `and`, `or`, `then`, or the kind of a behavior.
    pub kind: String,
    /// The id of its parent; none for the root.
    pub parent: Option<u32>,
    /// What it is now; of an inner node derived from what is below it.
    pub state: LeafState,
    /// Behaviors at or below it that are done or skipped.
    pub done: usize,
    /// Behaviors at or below it.
    pub of: usize,
    /// The potential of its last answer; of a running behavior that of its last request.
    pub potential: Option<f64>,
    /// How far a running behavior is, from 0 to 1.
    pub progress: Option<f64>,
    /// Why a behavior does not run, or at what it failed.
    pub reason: Option<String>,
}

/// A resource with the five properties of III-B.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ResourceRow {
    /// What the robot file calls it.
    pub name: String,
    /// `gripper`, `head`, `base`, or any other word.
    #[serde(rename = "type")]
    pub ty: String,
    /// How many leases there are of it.
    pub owners: usize,
    /// The intention with which it is shared; none of one that is free or used exclusively.
    pub channel: Option<String>,
    /// Whether it is in use.
    pub locked: bool,
    /// Why nobody can be granted it, and since when; none of one that is there.
    pub unavailable: Option<Outage>,
    /// Its leases, by holder.
    pub holders: Vec<HolderRow>,
    /// The object in it.
    pub holds: Option<String>,
    /// The controller that moves it; none of one that only counts.
    pub controller: Option<String>,
}

/// How a controller came to be away.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Outage {
    /// Of its controller: "its process ended".
    pub why: String,
    /// Robot time since the mission began, seconds.
    pub since_s: f64,
    /// Whether the mission still waits for it.
    pub awaited: bool,
}

/// An owner of a resource.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct HolderRow {
    /// The node that holds it.
    pub node: String,
    /// The behavior that got it.
    pub behavior: String,
    /// Because it runs, for what it was done for, or because the world is so.
    pub kind: LeaseKind,
}

/// A controller.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ControllerRow {
    /// What the robot file calls it.
    pub name: String,
    /// How well it is.
    pub health: Level,
    /// Why it is said to be so.
    pub why: String,
    /// The commands that it has not ended, the oldest first.
    pub goals: Vec<GoalRow>,
    /// What the diagnosis of each second says; none before the first.
    pub diagnostics: Option<DiagnosticsRow>,
}

/// How well a controller is by the diagnosis of each second.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct DiagnosticsRow {
    /// How well it is.
    pub level: Level,
    /// Why it is said to be so.
    pub message: String,
    /// Whether it is of the last second, as its daemon told; else of when that came to be different last, as the log has
    /// it.
    pub live: bool,
    /// What was counted.
    #[cfg_attr(feature = "schema", schema(value_type = Object))]
    pub values: Vitals,
}

/// A command under way.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct GoalRow {
    /// The behaviors that it serves.
    pub behaviors: Vec<String>,
    /// `driving`, `grasping`, or `stopping` once it was told to end.
    pub verb: &'static str,
    /// Whether it ends its behavior or lasts as long.
    pub mode: Mode,
    /// How far it is, from 0 to 1.
    pub progress: f64,
}

/// The world as root knows it; the base as its controller says.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct WorldRow {
    /// Position of the base in the map frame, meters, and its heading, radians; none before anything was told.
    pub base: Option<[f64; 3]>,
    /// Every object, in the order of the mission.
    pub objects: Vec<ObjectRow>,
    /// Every fact, in the order of the mission.
    pub facts: Vec<FactRow>,
}

/// Where an object is; neither place nor resources where nobody knows.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct ObjectRow {
    /// What the mission calls it.
    pub name: String,
    /// The place where it lies.
    pub at: Option<String>,
    /// The resources that hold it.
    #[serde(rename = "in")]
    pub held_by: Vec<String>,
    /// How it came to be so, where that was no behavior: `moved by an operator`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub how: Option<String>,
}

/// A fact.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct FactRow {
    /// What the mission calls it.
    pub name: String,
    /// Whether it is so now.
    pub holds: bool,
    /// How it came to be so, where that was no behavior: `set by an operator`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub how: Option<String>,
}
