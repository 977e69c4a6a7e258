//! How a controller came to be away.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

/// Why a controller counts as away. Displayed as a clause about the controller: "its process ended".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// Its process ended.
    Ended,
    /// Its process is there and showed no life for as long as the dead-man allows.
    Silent,
    /// It gave this daemon up: this daemon itself had been silent for too long, or it serves another now.
    Left {
        /// How long this daemon had not run just before, milliseconds; 0 if it had run all the time.
        away_ms: u32,
    },
    /// It did not answer its configuration.
    Unanswered,
    /// The link to it broke.
    Broken,
    /// It hangs: it did not end in time what it was told to end, or was busy with it later.
    Hung,
    /// It says to hold something that the mission does not have, so that nobody knows what its gripper can be used for.
    HoldsUnknown,
    /// It lives, and may not move.
    Inhibited(Inhibition),
}

/// Why a controller that lives may not move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Inhibition {
    /// Its emergency stop is pressed, or something else that keeps people safe has tripped.
    EmergencyStop,
    /// Something in it is broken, and waits for somebody to see to it.
    Fault,
    /// Somebody operates it by hand.
    ByHand,
}

impl Loss {
    /// Whether it is the controller itself that says so, and will say when it is over: it is awaited without limit.
    pub fn is_inhibition(self) -> bool {
        match self {
            Self::Inhibited(_) => true,
            Self::Ended
            | Self::Silent
            | Self::Left { .. }
            | Self::Unanswered
            | Self::Broken
            | Self::Hung
            | Self::HoldsUnknown => false,
        }
    }
}

impl Display for Inhibition {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::EmergencyStop => "emergency stop",
            Self::Fault => "fault",
            Self::ByHand => "operated by hand",
        })
    }
}

impl Display for Loss {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ended => f.write_str("its process ended"),
            Self::Silent => f.write_str("it showed no life for 1 s"),
            Self::Left { away_ms: 0 } => f.write_str("it gave this daemon up"),
            Self::Left { away_ms } => {
                write!(f, "it gave this daemon up, which had not run for {:.1} s", f64::from(*away_ms) / 1e3)
            }
            Self::Unanswered => f.write_str("it did not answer its configuration"),
            Self::Broken => f.write_str("the link to it broke"),
            Self::Hung => f.write_str("it did not end what it was told to end"),
            Self::HoldsUnknown => f.write_str("it says to hold what the mission does not have"),
            Self::Inhibited(why) => write!(f, "it is inhibited: {why}"),
        }
    }
}
