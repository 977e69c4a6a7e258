//! What comes of what a run is asked.

use serde::{Deserialize, Serialize};

use ambidex_model::suggestion;

/// What came of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// It was done.
    Changed {
        /// What is so now, as a sentence without its end.
        said: String,
    },
    /// It was so already.
    Same {
        /// What was so already, as a sentence without its end.
        said: String,
    },
    /// There is one more task.
    Submitted {
        /// Its number.
        task: u32,
        /// Its name.
        name: String,
    },
    /// Nothing changed.
    Refused(Refusal),
}

/// Why nothing changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// For programs.
    pub why: Why,
    /// As a sentence without its end.
    pub said: String,
    /// What can be done about it.
    pub help: Option<String>,
}

/// Why a request was refused, for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// It is no request, or not one of this path.
    Malformed,
    /// There is nothing at the path, or not for that method.
    NoSuchPath,
    /// It is of another origin or meant for another host.
    Foreign,
    /// It does not carry the token of this daemon.
    Token,
    /// It is too long.
    TooLarge,
    /// It did not come to its end in time.
    TooSlow,
    /// Too much is asked within too short a time.
    TooOften,
    /// Too many ask at once.
    Busy,
    /// There is no such fact, object, place, task or node.
    NoSuchName,
    /// The task file is faulty.
    Faulty,
    /// The mission does not say that others may set and clear the fact.
    NotOutside,
    /// The object is in a gripper.
    Held,
    /// Only a controller says such a thing.
    NotTheirs,
    /// The tree, or what is in the room, does not allow it now.
    NotNow,
    /// The mission has not begun.
    NotBegun,
    /// The run has a mission of its own.
    TakesNoWork,
    /// The run has not decided in time, and may still do what was asked.
    Late,
    /// The mission is over.
    Over,
}

/// What is said of a text that others wrote: no name is longer, and nobody reads on.
pub fn beginning(text: &str) -> &str {
    const MOST: usize = 64;
    &text[..text.floor_char_boundary(MOST)]
}

impl Refusal {
    /// A refusal that needs no help.
    pub fn new(why: Why, said: impl Into<String>) -> Self {
        Self { why, said: said.into(), help: None }
    }

    /// The same with what can be done about it.
    #[must_use]
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// That nothing of a kind is called so, where they have these names.
    pub(crate) fn no_such<'a>(what: &str, wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Self {
        let wanted = beginning(wanted);
        Self::new(Why::NoSuchName, format!("there is no {what} `{wanted}`")).with_help(suggestion(wanted, what, names))
    }

    /// That a run ended before it could decide.
    pub fn over() -> Self {
        Self::new(Why::Over, "the mission is over")
    }

    /// That a run does the mission that it was begun with, and nothing else.
    pub fn takes_no_work() -> Self {
        Self::new(Why::TakesNoWork, "this run has a mission of its own and takes no further tasks")
            .with_help("`ambidex daemon --robot R --world W` does")
    }
}
