//! Whether a resource can be used: by its controller being there.

use serde::{Deserialize, Serialize};

use super::{Loss, Time};

/// What a resource's controller lets it be.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Service {
    /// It can be granted.
    #[default]
    Available,
    /// Its controller is away, and awaited.
    Unavailable {
        /// How it came to be away.
        why: Loss,
        /// Robot time since when.
        since: Time,
    },
    /// Its controller is away, and awaited no more; it may come back all the same.
    Gone {
        /// How it came to be away.
        why: Loss,
        /// Robot time since when.
        since: Time,
    },
}

impl Service {
    /// Whether it can be granted.
    pub fn is_available(&self) -> bool {
        self.outage().is_none()
    }

    /// Why it cannot be granted.
    pub fn outage(&self) -> Option<Loss> {
        match *self {
            Self::Available => None,
            Self::Unavailable { why, .. } | Self::Gone { why, .. } => Some(why),
        }
    }

    /// Whether the mission waits for it to come back, and not without limit.
    pub fn is_awaited_for_a_time(&self) -> bool {
        self.is_awaited() && self.outage().is_some_and(|why| !why.is_inhibition())
    }

    /// Whether the mission still waits for it to come back.
    pub fn is_awaited(&self) -> bool {
        matches!(self, Self::Unavailable { .. })
    }
}
