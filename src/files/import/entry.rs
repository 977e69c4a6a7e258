//! A node of a task file, in whatever form it was written, with every name still as written.

use super::notes::Note;
use crate::document::SourceSpan;
use crate::fault::Faults;
use crate::reader::{Item, Name};
use crate::task::{AND, OR, THEN};

/// The `parent` of the topmost node.
pub(super) const NO_PARENT: &str = "NONE";

/// What a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    And,
    Then,
    Or,
    Behavior,
}

impl Kind {
    /// How missions write it; none for a behavior, which is written by its kind.
    pub(super) fn word(self) -> Option<&'static str> {
        match self {
            Self::And => Some(AND),
            Self::Then => Some(THEN),
            Self::Or => Some(OR),
            Self::Behavior => None,
        }
    }
}

/// What a node hangs from.
#[derive(Debug)]
pub(super) enum Parent {
    /// Nothing: it is the topmost.
    None(SourceSpan),
    Node(Name),
}

/// A node as written; a part that is wrong is none and has its fault.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) name: Name,
    pub(super) kind: Option<Kind>,
    pub(super) parent: Option<Parent>,
    /// A behavior always has one.
    pub(super) plugin: Option<Name>,
    pub(super) robot: Option<(String, SourceSpan)>,
    pub(super) potential: Option<f64>,
    /// All parameters but the potential, each key once.
    pub(super) params: Vec<Param>,
    /// What is not of the form.
    pub(super) notes: Vec<Note>,
    /// The nodes below it, where the form tells them.
    pub(super) children: Vec<Name>,
    /// Whether it is the root, which a mission has of itself.
    pub(super) is_root: bool,
}

/// A parameter of a node.
#[derive(Debug, Clone)]
pub(super) struct Param {
    pub(super) key: String,
    pub(super) value: String,
    pub(super) span: SourceSpan,
}

impl Entry {
    /// A node of which only the name is known.
    pub(super) fn named(name: Name) -> Self {
        Self {
            name,
            kind: None,
            parent: None,
            plugin: None,
            robot: None,
            potential: None,
            params: Vec::new(),
            notes: Vec::new(),
            children: Vec::new(),
            is_root: false,
        }
    }
}

/// What a node hangs from; a fault where that is no name.
pub(super) fn parent(item: Item<'_>, faults: &mut Faults) -> Option<Parent> {
    let name = item.name("the name of a node, or NONE for the topmost", faults)?;
    Some(if name.value == NO_PARENT { Parent::None(name.span) } else { Parent::Node(name) })
}

/// The robot that a node is for.
pub(super) fn robot(item: Item<'_>, faults: &mut Faults) -> Option<(String, SourceSpan)> {
    if item.text().is_none() {
        item.wrong("the number or the name of a robot", faults);
    }
    Some((item.text()?.to_owned(), item.span))
}
