//! What of the bodies of one robot keeps two behaviors apart.

use serde::{Deserialize, Serialize};

/// What two behaviors would be in each other's way with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clash {
    /// A rule of its own keeps them apart.
    #[default]
    Rule,
    /// They want the base in different places, or one of them wants it still.
    Base,
    /// Their arms would touch.
    Arms,
    /// They would put something down in the same spot.
    Spot,
}

impl Clash {
    /// As a sentence about the behavior that waits for another one.
    pub fn sentence(self, with: &str) -> String {
        match self {
            Self::Rule => format!("it would be in the way of {with}"),
            Self::Base => format!("{with} needs the robot elsewhere: its body is at one place at a time"),
            Self::Arms => format!("its arm would cross the one of {with}"),
            Self::Spot => format!("{with} puts something down in the same spot"),
        }
    }
}
