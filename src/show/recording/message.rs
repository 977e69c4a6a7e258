//! The messages of a recording, and the topics that they have.

use ambidex_model::Time;
use serde::Serialize;
use serde_json::Value;
use strum::VariantArray;

use super::clock::WallClock;
use super::foxglove::Stamp;
use super::schema;

/// What a message is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, VariantArray)]
pub enum Topic {
    /// The structure of the task tree.
    Tree,
    /// What the nodes of the tree are.
    State,
    /// Who holds which resource.
    Resources,
    /// Messages between nodes.
    NodeMessages,
    /// Messages to and from controllers.
    ControllerMessages,
    /// Where the base is.
    Pose,
    /// Where base, grippers and head are.
    Transforms,
    /// Things that can be seen.
    Scene,
    /// What a run says in words.
    Log,
    /// Messages that are missing.
    Dropped,
}

impl Topic {
    /// As viewers list it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tree => "/tree",
            Self::State => "/state",
            Self::Resources => "/resources",
            Self::NodeMessages => "/messages/nodes",
            Self::ControllerMessages => "/messages/controllers",
            Self::Pose => "/pose",
            Self::Transforms => "/tf",
            Self::Scene => "/scene",
            Self::Log => "/log",
            Self::Dropped => "/dropped",
        }
    }

    /// By what name viewers know its schema.
    pub fn schema_name(self) -> &'static str {
        match self {
            Self::Tree => "ambidex.Tree",
            Self::State => "ambidex.State",
            Self::Resources => "ambidex.Resources",
            Self::NodeMessages | Self::ControllerMessages => "ambidex.Message",
            Self::Pose => "foxglove.PoseInFrame",
            Self::Transforms => "foxglove.FrameTransforms",
            Self::Scene => "foxglove.SceneUpdate",
            Self::Log => "foxglove.Log",
            Self::Dropped => "ambidex.Dropped",
        }
    }

    /// What each of its messages looks like, as JSON Schema.
    pub fn schema(self) -> Value {
        match self {
            Self::Tree => schema::tree(),
            Self::State => schema::state(),
            Self::Resources => schema::resources(),
            Self::NodeMessages | Self::ControllerMessages => schema::message(),
            Self::Pose => schema::pose_in_frame(),
            Self::Transforms => schema::frame_transforms(),
            Self::Scene => schema::scene_update(),
            Self::Log => schema::log(),
            Self::Dropped => schema::dropped(),
        }
    }
}

/// One message of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// What it is about.
    pub topic: Topic,
    /// When it was on the wall clock, nanoseconds since 1970.
    pub log_time_ns: u64,
    /// When it was in robot time, nanoseconds.
    pub publish_time_ns: u64,
    /// An object of JSON.
    pub body: String,
}

/// Messages of one moment.
#[derive(Debug)]
pub(super) struct Moment {
    log_time_ns: u64,
    publish_time_ns: u64,
    messages: Vec<Message>,
}

impl Moment {
    /// Nothing is said yet.
    pub(super) fn new(clock: WallClock, at: Time) -> Self {
        let publish_time_ns = at.0.saturating_mul(1_000);
        Self { log_time_ns: clock.at_ns(at), publish_time_ns, messages: Vec::new() }
    }

    /// What messages of Foxglove's schemas are stamped with: the time by which their viewer goes.
    pub(super) fn stamp(&self) -> Stamp {
        self.log_time_ns.into()
    }

    /// Says something.
    pub(super) fn say(&mut self, topic: Topic, message: &impl Serialize) {
        self.say_json(topic, serde_json::to_string(message).expect("a message is plain"));
    }

    /// Says something that is JSON already.
    pub(super) fn say_json(&mut self, topic: Topic, body: String) {
        let (log_time_ns, publish_time_ns) = (self.log_time_ns, self.publish_time_ns);
        self.messages.push(Message { topic, log_time_ns, publish_time_ns, body });
    }

    /// All that was said.
    pub(super) fn into_messages(self) -> Vec<Message> {
        self.messages
    }
}
