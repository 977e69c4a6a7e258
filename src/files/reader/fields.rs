//! The entries of a map of which every key is known.

use std::collections::BTreeSet;

use super::Item;
use crate::document::{Entry, Located, SourceSpan};
use crate::fault::Faults;
use crate::shape::Shape;
use crate::text::shortened;
use ambidex_model::suggestion;

/// A map of which every key is known.
#[derive(Debug, Clone)]
pub(crate) struct Fields<'a> {
    pub(crate) shape: &'static Shape,
    pub(super) at: Item<'a>,
    pub(super) entries: &'a [Entry],
}

impl<'a> Fields<'a> {
    /// Where the map stands.
    pub(crate) fn span(&self) -> SourceSpan {
        self.entries.first().map_or(self.at.span, |(key, _)| key.span)
    }

    /// Every entry whose key is one of these, in the order of the file; the first of those that come twice.
    pub(crate) fn among(&self, keys: &[&str]) -> Vec<Item<'a>> {
        let mut seen = BTreeSet::new();
        self.entries_but(|key| keys.contains(&key)).map(|(_, item)| item).filter(|item| seen.insert(item.key)).collect()
    }

    /// The value of a key, if it is there.
    pub(crate) fn get(&self, key: &str) -> Option<Item<'a>> {
        self.among(&[key]).into_iter().next()
    }

    /// The one value of a choice of keys; none where the choice is wrong.
    pub(crate) fn one(&self) -> Option<Item<'a>> {
        match self.among(&self.shape.one_of).as_slice() {
            [one] => Some(*one),
            _ => None,
        }
    }

    /// Every entry whose key is none of those that the shape names.
    pub(crate) fn others(&self) -> impl Iterator<Item = (&'a Located<String>, Item<'a>)> {
        let shape = self.shape;
        self.entries_but(move |key| !shape.keys().any(|known| known == key))
    }

    fn entries_but(&self, is_wanted: impl Fn(&str) -> bool) -> impl Iterator<Item = (&'a Located<String>, Item<'a>)> {
        let wanted = self.entries.iter().filter(move |(key, _)| is_wanted(&key.value));
        wanted.map(|(key, node)| (key, Item::under(key, node)))
    }

    /// Says that a key means nothing here.
    pub(crate) fn unknown<'b>(
        &self,
        key: &Located<String>,
        allowed: impl IntoIterator<Item = &'b str>,
        faults: &mut Faults,
    ) {
        let message = format!("{} has no key `{}`", self.shape.what, shortened(&key.value));
        faults.push_with((key.span, &key.value), message, || suggestion(&key.value, "key", allowed));
    }

    /// Says that none or several stand where one belongs.
    pub(crate) fn not_one_of<'b>(&self, found: usize, allowed: impl IntoIterator<Item = &'b str>, faults: &mut Faults) {
        let message = match found {
            0 => format!("{} that does not say what it is", self.shape.what),
            several => format!("{} that is {several} things instead of one", self.shape.what),
        };
        let allowed: Vec<&str> = allowed.into_iter().collect();
        faults.push_with((self.span(), self.at.key), message, format!("write exactly one of: {}", allowed.join(", ")));
    }
}
