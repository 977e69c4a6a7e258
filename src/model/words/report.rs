//! What a controller says of the world beyond what it moves: a door that it sees open, a mug that it sees on the table.

use serde::{Deserialize, Serialize};

use super::Name;
use super::name::shortened;
use super::names::make_legible;

/// Something that a controller says of the world, by names of the mission. What it says last counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Report {
    /// A fact holds, or does not.
    Fact {
        /// The fact.
        fact: Name,
        /// Whether it holds.
        holds: bool,
    },
    /// An object lies somewhere.
    Object {
        /// The object.
        object: Name,
        /// The place; none where nobody knows.
        at: Option<Name>,
    },
}

impl Report {
    /// Whether a fact holds. Of a name that is longer than any in a mission only the beginning is told.
    pub fn fact(fact: &str, holds: bool) -> Self {
        Self::Fact { fact: shortened(fact), holds }
    }

    /// Where an object lies; at no place, if nobody knows.
    pub fn object(object: &str, at: Option<&str>) -> Self {
        Self::Object { object: shortened(object), at: at.map(shortened) }
    }

    /// Whether both are about the same fact or object.
    pub fn is_about_that_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Fact { fact, .. }, Self::Fact { fact: other, .. }) => fact == other,
            (Self::Object { object, .. }, Self::Object { object: other, .. }) => object == other,
            (Self::Fact { .. }, Self::Object { .. }) | (Self::Object { .. }, Self::Fact { .. }) => false,
        }
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // The names are whatever a controller says.
        let mut said = match self {
            Self::Fact { fact, holds: true } => format!("\"{fact}\" holds"),
            Self::Fact { fact, holds: false } => format!("\"{fact}\" does not hold"),
            Self::Object { object, at: Some(place) } => format!("{object} is at {place}"),
            Self::Object { object, at: None } => format!("nobody knows where {object} is"),
        };
        make_legible(&mut said);
        f.write_str(&said)
    }
}

/// What a controller may report, by name: a robot file knows no mission.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reportable {
    /// Facts.
    pub facts: Vec<String>,
    /// Objects.
    pub objects: Vec<String>,
}

impl Reportable {
    /// Whether there is nothing that it may report.
    pub fn is_empty(&self) -> bool {
        self.facts.is_empty() && self.objects.is_empty()
    }

    /// Whether it may report that.
    pub fn allows(&self, report: &Report) -> bool {
        match report {
            Report::Fact { fact, .. } => self.facts.iter().any(|allowed| allowed == fact.as_str()),
            Report::Object { object, .. } => self.objects.iter().any(|allowed| allowed == object.as_str()),
        }
    }
}

/// Why a report is not even heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Misreport {
    /// The robot file does not let the controller report it.
    #[error("its robot file does not let it report that")]
    NotAllowed,
    /// The mission has no such fact.
    #[error("the mission has no such fact")]
    NoSuchFact,
    /// The mission has no such object.
    #[error("the mission has no such object")]
    NoSuchObject,
    /// The mission has no such place.
    #[error("the mission has no such place")]
    NoSuchPlace,
}
