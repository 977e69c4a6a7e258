//! How well a controller is, once a second, in the levels of robot diagnostics. Nothing of it goes into decisions.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use super::{ControllerId, Inhibition, Loss, Misreport, Rejection};

/// How well something is, in the words of robot diagnostics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "UPPERCASE")]
pub enum Level {
    /// As it should be.
    Ok,
    /// Something went wrong, and it serves on.
    Warn,
    /// It cannot be used.
    Error,
    /// Nothing is heard of it.
    Stale,
}

impl Level {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::Warn => "WARN",
            Self::Error => "ERROR",
            Self::Stale => "STALE",
        }
    }
}

/// A controller as it was in the last second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagnostics {
    /// Which controller.
    pub controller: ControllerId,
    /// How well it is.
    pub level: Level,
    /// Why it is said to be so.
    pub message: Diagnosis,
    /// What was counted.
    pub values: Vitals,
}

impl Diagnostics {
    /// Whether it says the same, whatever was counted.
    pub fn agrees_with(&self, other: &Self) -> bool {
        (self.controller, self.level, self.message) == (other.controller, other.level, other.message)
    }
}

/// Why a controller is at its level. Displayed as a clause about the controller, without any number that differs from
/// second to second: "its process ended".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Diagnosis {
    /// It is there and answers.
    Serves,
    /// It attached, and its configuration is not answered yet.
    Unconfigured,
    /// A sign of life came late, and not too late.
    Late,
    /// Another process speaks under its name.
    Doubled,
    /// It does not take what it is told.
    Backlog,
    /// Something went wrong, and it has taken no goal since.
    Troubled(Trouble),
    /// It is away.
    Lost(Loss),
    /// It never attached, and what came under its name is not used.
    Unheard(Rejection),
    /// It never attached.
    Absent,
}

impl Diagnosis {
    /// How bad that is.
    pub fn level(self) -> Level {
        match self {
            Self::Serves => Level::Ok,
            Self::Unconfigured | Self::Late | Self::Doubled | Self::Backlog | Self::Troubled(_) => Level::Warn,
            Self::Lost(why) => lost(why),
            Self::Unheard(_) => Level::Error,
            Self::Absent => Level::Stale,
        }
    }
}

/// How bad it is to be away: of who is silent nothing more is known.
fn lost(why: Loss) -> Level {
    match why {
        Loss::Silent => Level::Stale,
        Loss::Ended | Loss::Left { .. } | Loss::Unanswered | Loss::Broken | Loss::Hung => Level::Error,
        Loss::HoldsUnknown | Loss::Inhibited(_) => Level::Error,
    }
}

/// What went wrong with a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Trouble {
    /// It would not take a goal.
    Rejected(Rejection),
    /// It gave up a goal.
    Aborted,
    /// What it said was not used.
    Refused(Rejection),
    /// What it said of the world was not heard.
    Misreported(Misreport),
    /// It was lost.
    Lost(Loss),
}

/// What is counted of a controller. Where it says "last second", that is the time since the diagnosis before.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Vitals {
    /// How long ago it sent the newest sign of life, milliseconds of wall time; none before the first.
    pub heartbeat_age_ms: Option<u32>,
    /// The longest time without a sign of life that lies in or reaches into the last second, milliseconds of wall time;
    /// none before the first sign.
    pub worst_gap_ms: Option<u32>,
    /// Messages with its state, signs of life among them, per second of wall time.
    pub states_per_s: u32,
    /// How often it attached.
    pub attachments: u32,
    /// Its attachment as the daemon counts them, over resumed runs too; 0 before the first.
    pub generation: u32,
    /// What came from it and was not used, in all.
    pub refused: u64,
    /// Signs of life of other processes under its name, in all.
    pub foreign: u64,
    /// Most messages that waited for it at once in the last second.
    pub queued: u32,
    /// What went wrong last, though it may be over.
    pub last_fault: Option<Trouble>,
    /// Why it may not move now.
    pub inhibited: Option<Inhibition>,
    /// Whether it does what nobody wants of it any more.
    pub hung: bool,
}

impl Display for Level {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

impl Display for Diagnosis {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serves => f.write_str("it serves"),
            Self::Unconfigured => f.write_str("attached, not yet configured"),
            Self::Late => f.write_str("its signs of life come late"),
            Self::Doubled => f.write_str("another process speaks under its name"),
            Self::Backlog => f.write_str("it does not take what it is told"),
            Self::Troubled(trouble) => trouble.fmt(f),
            Self::Lost(why) => why.fmt(f),
            Self::Unheard(why) => write!(f, "what comes under its name is not used: {why}"),
            Self::Absent => f.write_str("it never attached"),
        }
    }
}

impl Display for Trouble {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rejected(why) => write!(f, "it rejected a goal: {why}"),
            Self::Aborted => f.write_str("it gave up a goal"),
            Self::Refused(why) => write!(f, "a message of it was not used: {why}"),
            Self::Misreported(why) => write!(f, "a report of it is not heard: {why}"),
            Self::Lost(why) => why.fmt(f),
        }
    }
}
