//! What may stand in the files, as data: what the reader refuses by, and what schema and reference are made from.

use crate::quantity::Quantity;

/// A map whose keys are known.
#[derive(Debug)]
pub(crate) struct Shape {
    /// What faults call it: "a place".
    pub(crate) what: &'static str,
    /// What it is for.
    pub(crate) doc: &'static str,
    /// Its keys in the order in which they are explained.
    pub(crate) fields: Vec<Field>,
    /// Keys of which exactly one must be there; empty where there is no such choice.
    pub(crate) one_of: Vec<&'static str>,
    /// What stands under a key that is not in `fields`; none where such a key is a fault.
    pub(crate) others: Option<Others>,
}

/// What the writer of a file may add to a map under keys of their own.
#[derive(Debug)]
pub(crate) struct Others {
    /// What stands under any of them.
    pub(crate) form: Form,
    /// Those that every file can use.
    pub(crate) known: Vec<Field>,
}

/// A key of a map.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub(crate) key: &'static str,
    pub(crate) doc: &'static str,
    pub(crate) is_required: bool,
    pub(crate) form: Form,
}

/// What a value looks like.
#[derive(Debug, Clone)]
pub(crate) enum Form {
    /// A word, a number or quoted text.
    Word,
    /// One of these words.
    Words(&'static [&'static str]),
    /// `true` or `false`.
    Flag,
    /// A whole number up to that.
    Count(u32),
    /// A whole number no farther from 0 than that.
    Whole(i32),
    /// A number, with a unit if it has one.
    Quantity(&'static Quantity),
    /// As many numbers of one dimension: at least, at most.
    Vector(usize, usize, &'static Quantity),
    /// A list that is not empty.
    List(Box<Self>),
    /// A map from names that the writer chooses.
    Each(Box<Self>),
    /// A map whose keys are known; a function, since maps can hold others like themselves.
    Map(fn() -> &'static Shape),
    /// Any of these ways to write it.
    Either(Vec<Self>),
    /// A word, number, list of numbers, or a map of such by parameter.
    Arguments,
}

impl Shape {
    /// A shape without keys.
    pub(crate) fn new(what: &'static str, doc: &'static str) -> Self {
        Self { what, doc, fields: Vec::new(), one_of: Vec::new(), others: None }
    }

    /// Adds keys of which exactly one must be there.
    pub(crate) fn add_choice(&mut self, choice: Vec<Field>) {
        self.one_of.extend(choice.iter().map(|field| field.key));
        self.fields.extend(choice);
    }

    /// Whether a key may stand here.
    pub(crate) fn allows(&self, key: &str) -> bool {
        self.others.is_some() || self.keys().any(|known| known == key)
    }

    /// All keys but those that the writer chooses, in the order of description.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'static str> {
        self.fields.iter().map(|field| field.key)
    }
}
