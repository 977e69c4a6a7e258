//! Why something that one side of a link said is not used by the other.

use serde::{Deserialize, Serialize};

use super::{CommandId, Inhibition};

/// Why a message between runtime and controller was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Rejection {
    /// Another version of the wire.
    #[error("it speaks another version of the wire")]
    Version,
    /// From another life of the daemon or controller.
    #[error("it is from an earlier life of the daemon or the controller")]
    Stale,
    /// About nothing that is under way.
    #[error("it is about nothing that is under way")]
    Unknown,
    /// A length beyond its bound or a code that means nothing.
    #[error("a length or a code in it is out of bounds")]
    Malformed,
    /// A number that is not finite.
    #[error("a number in it is not finite")]
    NotFinite,
    /// No configuration came before it.
    #[error("no configuration came before it")]
    NotConfigured,
    /// The controller cannot do such a thing.
    #[error("this controller cannot do such a thing")]
    Unsupported,
    /// The point is farther than it reaches.
    #[error("the point is out of reach")]
    OutOfReach,
    /// It is doing something else.
    #[error("it is doing something else")]
    Busy,
    /// It names an object or a place that the other side does not know.
    #[error("a name in it is not known")]
    NoSuchName,
    /// The controller may not move now.
    #[error("the controller is inhibited: {0}")]
    Inhibited(Inhibition),
}

/// Something that came from a controller and is not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refusal {
    /// The command that it is about, where that can be told.
    pub id: Option<CommandId>,
    /// What is wrong with it.
    pub why: Rejection,
    /// Whether it would have been the last word on the command: no other will come.
    pub is_last: bool,
}
