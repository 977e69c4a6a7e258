//! The entries of a map of which every key is known.

use std::collections::BTreeSet;

use super::super::document::{Located, Node, Spot};
use super::super::fault::Faults;
use super::super::shape::{Form, Shape};
use super::{Item, shortened};
use ambidex_model::suggestion;

/// A map of which every key is known.
#[derive(Debug, Clone)]
pub(in super::super) struct Fields<'a> {
    pub(super) shape: &'static Shape,
    pub(super) at: Item<'a>,
    pub(super) entries: &'a [(Located<String>, Node)],
}

impl<'a> Fields<'a> {
    /// Where the map stands.
    pub(in super::super) fn spot(&self) -> Spot {
        self.entries.first().map_or(self.at.spot, |(key, _)| key.spot)
    }

    /// Every entry whose key is one of these, in the order of the file; the first of those that come twice.
    pub(in super::super) fn among(&self, keys: &[&str]) -> Vec<Item<'a>> {
        let mut seen = BTreeSet::new();
        self.entries_but(|key| keys.contains(&key)).map(|(_, item)| item).filter(|item| seen.insert(item.key)).collect()
    }

    /// The value of a key, if it is there.
    pub(in super::super) fn get(&self, key: &str) -> Option<Item<'a>> {
        self.among(&[key]).into_iter().next()
    }

    /// The number of a key in SI units, of the quantity that the shape tells.
    pub(in super::super) fn number(&self, key: &str, faults: &mut Faults) -> Option<f64> {
        match self.shape.field(key)?.form {
            Form::Quantity(quantity) => self.get(key)?.quantity(quantity, faults),
            Form::Word | Form::Words(_) | Form::Flag | Form::Count(_) | Form::Vector(..) | Form::List(_) => None,
            Form::Each(_) | Form::Map(_) | Form::Nested(_) | Form::Either(_) | Form::Arguments => None,
        }
    }

    /// The numbers of a key in SI units, as many and of the quantity that the shape tells.
    pub(in super::super) fn vector(&self, key: &str, faults: &mut Faults) -> Option<Vec<f64>> {
        match self.shape.field(key)?.form {
            Form::Vector(least, most, quantity) => self.get(key)?.vector(least..=most, quantity, faults),
            Form::Word | Form::Words(_) | Form::Flag | Form::Count(_) | Form::Quantity(_) | Form::List(_) => None,
            Form::Each(_) | Form::Map(_) | Form::Nested(_) | Form::Either(_) | Form::Arguments => None,
        }
    }

    /// The same, or what it is where the key is left out.
    pub(in super::super) fn number_or(&self, key: &str, default: f64, faults: &mut Faults) -> Option<f64> {
        if self.get(key).is_some() { self.number(key, faults) } else { Some(default) }
    }

    /// The one value of a choice of keys; none where the choice is wrong.
    pub(in super::super) fn one(&self) -> Option<Item<'a>> {
        match self.among(self.shape.one_of).as_slice() {
            [one] => Some(*one),
            _ => None,
        }
    }

    /// Every entry whose key is none of these.
    pub(in super::super) fn others(&self, known: &[&str]) -> impl Iterator<Item = (&'a Located<String>, Item<'a>)> {
        self.entries_but(|key| !known.contains(&key))
    }

    fn entries_but(&self, is_wanted: impl Fn(&str) -> bool) -> impl Iterator<Item = (&'a Located<String>, Item<'a>)> {
        let wanted = self.entries.iter().filter(move |(key, _)| is_wanted(&key.value));
        wanted.map(|(key, node)| (key, Item::under(key, node)))
    }

    /// Says that a key means nothing here.
    pub(in super::super) fn unknown<'b>(
        &self,
        key: &Located<String>,
        allowed: impl IntoIterator<Item = &'b str>,
        faults: &mut Faults,
    ) {
        let message = format!("{} has no key `{}`", self.shape.what, shortened(&key.value));
        faults.push(key.spot, &key.value, message, Some(suggestion(&key.value, "key", allowed)));
    }

    /// Says that none or several stand where one belongs.
    pub(in super::super) fn not_one_of<'b>(
        &self,
        found: usize,
        allowed: impl IntoIterator<Item = &'b str>,
        faults: &mut Faults,
    ) {
        let message = match found {
            0 => format!("{} that does not say what it is", self.shape.what),
            several => format!("{} that is {several} things instead of one", self.shape.what),
        };
        let allowed: Vec<&str> = allowed.into_iter().collect();
        let help = format!("write exactly one of: {}", allowed.join(", "));
        faults.push(self.spot(), self.at.key, message, Some(help));
    }
}
