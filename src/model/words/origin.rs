//! Who says that the world is different, what that may not change, and what came of it.

use serde::{Deserialize, Serialize};

use super::{Change, ControllerId, Holders, Names};

/// Who says that the world is different, when no behavior made it so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// Somebody at a terminal, by `ambidex world`.
    Operator,
    /// A controller: of what it moves, or what the robot file lets it report.
    Controller(ControllerId),
    /// A file of what goes wrong on purpose.
    Script,
    /// An object was let go on purpose.
    Dropped,
    /// It was found so when the mission went on after its runtime was gone.
    Resumed,
}

impl Origin {
    /// Whether it may change only what is open to others.
    pub fn is_bound(self) -> bool {
        match self {
            Self::Operator | Self::Controller(_) => true,
            Self::Script | Self::Dropped | Self::Resumed => false,
        }
    }

    /// How a change came about, as a part of a sentence.
    pub fn phrase(self, change: &Change, names: &Names) -> String {
        let by_operator = match change {
            Change::Fact(_, true) => "set by an operator",
            Change::Fact(_, false) => "cleared by an operator",
            Change::Object(..) | Change::Laid(..) => "moved by an operator",
            Change::Taken(..) | Change::Base(_) | Change::Emptied(_) => "said by an operator",
            Change::Blocked(_) | Change::Cleared(_) => "said by an operator",
        };
        match self {
            Self::Operator => by_operator.into(),
            Self::Controller(id) => format!("reported by {}", names.controller(id)),
            Self::Script => "done on purpose".into(),
            Self::Dropped => "dropped on purpose".into(),
            Self::Resumed => "found so when the mission went on".into(),
        }
    }
}

/// Most obstacles that come to stand in a room: each search of a path is held against all of them.
pub const OBSTACLES_MAX: usize = 1_000;

/// Why what somebody says of the world is not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Objection {
    /// The mission does not say that others may set and clear the fact.
    NotOutside,
    /// The object is in a gripper: it moves only by the word of who moves that.
    Held {
        /// What holds it.
        by: Holders,
    },
    /// Only who moves it says so: where the base is, and what is in a gripper.
    NotTheirs,
    /// The mission has not begun, or has not gone on yet.
    NotBegun,
    /// The mission is over.
    Over,
    /// So much stands in the room already that no more is taken up.
    Full,
}

impl Objection {
    /// As a sentence about the change that it is made to, without its end.
    pub fn sentence(self, change: &Change, names: &Names) -> String {
        match (self, change) {
            (Self::NotOutside, Change::Fact(fact, _)) => {
                format!("\"{}\" is not declared `outside`, so only behaviors change it", names.fact(*fact))
            }
            (Self::NotOutside, _) => "only behaviors change it".into(),
            (Self::Held { by }, Change::Object(object, _) | Change::Laid(object, ..)) => {
                format!("{} is held by {}", names.thing(*object), holders(by, names))
            }
            (Self::Held { by }, _) => format!("it is held by {}", holders(by, names)),
            (Self::NotTheirs, _) => "only the controller that moves it says so".into(),
            (Self::NotBegun, _) => "the mission has not begun yet".into(),
            (Self::Over, _) => "the mission is over".into(),
            (Self::Full, _) => format!("at most {OBSTACLES_MAX} things come to stand in the room"),
        }
    }
}

/// What came of a change that somebody outside asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Uptake {
    /// The world is different now.
    Changed,
    /// It was so already.
    Same,
    /// Nothing changed.
    Refused(Objection),
}

fn holders(by: Holders, names: &Names) -> String {
    by.as_slice().iter().map(|holder| names.resource(*holder)).collect::<Vec<_>>().join(" and ")
}
