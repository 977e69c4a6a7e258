//! What may stand in the files: one description that the reader checks by and the JSON Schema is made from.

use super::quantity::Quantity;

/// A map whose keys are known.
#[derive(Debug)]
pub(super) struct Shape {
    /// What faults call it: "a place".
    pub(super) what: &'static str,
    /// What it is for.
    pub(super) doc: &'static str,
    /// Its keys.
    pub(super) fields: &'static [Field],
    /// Keys of which exactly one must be there; empty where there is no such choice.
    pub(super) one_of: &'static [&'static str],
    /// What stands under a key that is not in `fields`; none where such a key is a fault.
    pub(super) others: Option<Form>,
}

/// A key of a map.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) key: &'static str,
    pub(super) doc: &'static str,
    pub(super) is_required: bool,
    pub(super) form: Form,
}

/// What a value looks like.
#[derive(Debug, Clone, Copy)]
pub(super) enum Form {
    /// A word, a number or quoted text.
    Word,
    /// One of these words.
    Words(&'static [&'static str]),
    /// `true` or `false`.
    Flag,
    /// A whole number up to that.
    Count(u32),
    /// A number, with a unit if it has one.
    Quantity(&'static Quantity),
    /// As many numbers of one dimension: at least, at most.
    Vector(usize, usize, &'static Quantity),
    /// A list that is not empty.
    List(&'static Form),
    /// A map from names that the writer chooses.
    Each(&'static Form),
    /// A map whose keys are known.
    Map(&'static Shape),
    /// A map whose keys are known and that can hold others like it.
    Nested(fn() -> &'static Shape),
    /// One of several.
    Either(&'static [Form]),
    /// A word, number, list of numbers, or a map of such by parameter.
    Arguments,
}

/// A key that must be there.
pub(super) const fn required(key: &'static str, doc: &'static str, form: Form) -> Field {
    Field { key, doc, is_required: true, form }
}

/// A key that may be left out.
pub(super) const fn optional(key: &'static str, doc: &'static str, form: Form) -> Field {
    Field { key, doc, is_required: false, form }
}

impl Shape {
    /// A shape of keys alone.
    pub(super) const fn new(what: &'static str, doc: &'static str, fields: &'static [Field]) -> Self {
        Self { what, doc, fields, one_of: &[], others: None }
    }

    /// The same with exactly one of some keys.
    pub(super) const fn with_one_of(self, one_of: &'static [&'static str]) -> Self {
        Self { one_of, ..self }
    }

    /// The field of a key.
    pub(super) fn field(&self, key: &str) -> Option<&'static Field> {
        self.fields.iter().find(|field| field.key == key)
    }

    /// All keys in the order of description.
    pub(super) fn keys(&self) -> impl Iterator<Item = &'static str> {
        self.fields.iter().map(|field| field.key)
    }
}
