//! What a run is asked to work on, as plain values: what comes over HTTP is read into these, and the command line
//! writes them.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::answer::Refusal;
use super::number;
use ambidex_model::Source;

/// What is asked about the work of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Work {
    /// There is one more task.
    Submit(Submission),
    /// A task is to end.
    Cancel(NameOrId),
    /// Nothing more of a task is granted; of all tasks where none is named.
    Pause(Option<NameOrId>),
    /// What was paused goes on.
    Resume(Option<NameOrId>),
    /// What is paused is granted one step, and pauses again.
    Step(Option<NameOrId>),
    /// The tree of a task is to be different.
    Edit(NameOrId, Edit),
    /// The world has one more object.
    AddObject {
        /// What it is called; no other object is.
        object: String,
        /// The place where it lies.
        place: String,
    },
    /// The world has an object no more.
    RemoveObject {
        /// The object.
        object: String,
    },
    /// Everything is to end.
    Stop,
}

/// A task for a running robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Submission {
    /// What it is to be called; none calls it as its file does. Digits alone are no name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schema(min_length = 1, max_length = 64, pattern = "[^0-9]"))]
    pub name: Option<String>,
    /// How urgent it is: the greater, the more; none is as its file says.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "number::priority")]
    #[cfg_attr(feature = "schema", schema(minimum = -1000, maximum = 1000))]
    pub priority: Option<i32>,
    /// Whether it begins paused.
    #[serde(default)]
    pub pause: bool,
    /// The task file with all that it includes, as whoever submits it has read them.
    pub source: Source,
}

/// How the tree of a task is to be different.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Edit {
    /// A node has one more child.
    Add {
        /// The node.
        under: NameOrId,
        /// A file with the child as its task, and all that it includes.
        source: Source,
        /// So many children stand before it; none puts it last.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "number::optional")]
        at: Option<u32>,
    },
    /// A node is there no more, nor is what is below it.
    Remove {
        /// The node.
        node: NameOrId,
    },
    /// Another node takes the place of one.
    Replace {
        /// The node whose place is taken.
        node: NameOrId,
        /// A file with the other one as its task, and all that it includes.
        source: Source,
    },
}

/// A task or a node: its name, or the number that `list` and `show` tell.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(untagged)]
pub enum NameOrId {
    /// Its number.
    #[serde(deserialize_with = "number::whole")]
    Id(u32),
    /// Its name.
    Name(String),
}

impl NameOrId {
    /// Whether it stands for what has this number and this name.
    pub fn is(&self, id: u32, name: &str) -> bool {
        match self {
            Self::Id(wanted) => *wanted == id,
            Self::Name(wanted) => wanted == name,
        }
    }

    /// That there is no such task, where tasks have these names.
    pub fn is_no_task<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Refusal {
        Refusal::no_such("task", &self.to_string(), names)
    }
}

impl From<String> for NameOrId {
    fn from(text: String) -> Self {
        text.parse().map_or(Self::Name(text), Self::Id)
    }
}

impl FromStr for NameOrId {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self::from(text.to_owned()))
    }
}

impl fmt::Display for NameOrId {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id(id) => write!(out, "{id}"),
            Self::Name(name) => out.write_str(name),
        }
    }
}
