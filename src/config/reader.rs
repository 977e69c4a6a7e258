//! Typed reading of a YAML tree: every mistake goes to the faults and reading goes on beside it.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use super::document::{Located, Node, Spot, Value};
use super::fault::{Faults, suggestion};
use super::quantity::Quantity;

/// Longest name, bytes.
const MAX_NAME_BYTES: usize = 64;

/// A value with the key that it stands under.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item<'a> {
    /// The key; the file's or the list's for what has none of its own.
    pub(super) key: &'a str,
    /// Where to point: the value, or the key when the value is a list, a map or nothing.
    pub(super) spot: Spot,
    value: &'a Value,
}

/// A name as written, and the key that it stands under; a key that is a name stands under itself.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    pub(super) value: String,
    pub(super) key: String,
    pub(super) spot: Spot,
}

/// A map of which every key is known.
#[derive(Debug, Clone)]
pub(super) struct Fields<'a> {
    what: &'a str,
    at: Item<'a>,
    entries: &'a [(Located<String>, Node)],
}

impl<'a> Item<'a> {
    /// The whole file.
    pub(super) fn root(node: &'a Node) -> Self {
        Self { key: "", spot: node.spot, value: &node.value }
    }

    fn under(key: &'a Located<String>, node: &'a Node) -> Self {
        let spot = match node.value {
            Value::Scalar { .. } => node.spot,
            Value::Null | Value::List(_) | Value::Map(_) => key.spot,
        };
        Self { key: &key.value, spot, value: &node.value }
    }

    fn wrong(&self, wanted: &str, faults: &mut Faults) {
        let found = match self.value {
            Value::Null => "nothing".to_owned(),
            Value::Scalar { text, .. } => format!("`{}`", shortened(text)),
            Value::List(_) => "a list".to_owned(),
            Value::Map(_) => "a map".to_owned(),
        };
        let message = format!("found {found} instead of {wanted}");
        faults.push(self.spot, self.key, message, None);
    }

    /// Whether it is a single word, number or text.
    pub(super) fn is_scalar(&self) -> bool {
        matches!(self.value, Value::Scalar { .. })
    }

    /// A name: a word, a number or quoted text.
    pub(super) fn name(&self, what: &str, faults: &mut Faults) -> Option<Name> {
        let Value::Scalar { text, .. } = self.value else {
            self.wrong(what, faults);
            return None;
        };
        let name = Name { value: text.clone(), key: self.key.to_owned(), spot: self.spot };
        is_name(&name, faults).then_some(name)
    }

    /// A number in SI units.
    pub(super) fn quantity(&self, quantity: &Quantity, faults: &mut Faults) -> Option<f64> {
        let dimension = quantity.dimension;
        let Value::Scalar { text, number } = self.value else {
            self.wrong(dimension.example(), faults);
            return None;
        };
        let (from, to) = (quantity.range.start(), quantity.range.end());
        match dimension.si(text, *number) {
            Ok(value) if quantity.range.contains(&value) => Some(value),
            Ok(_) => {
                let unit = dimension.units()[0].0;
                let message = format!("`{}` is out of bounds", shortened(text));
                let help = format!("allowed: {from:.5} to {to:.5} {unit}");
                faults.push(self.spot, self.key, message, Some(help));
                None
            }
            Err(_) => {
                let units: Vec<_> = dimension.units().iter().map(|unit| unit.0).collect();
                let message = format!("found `{}` instead of {}", shortened(text), dimension.example());
                let help = format!("units: {}", units.join(", "));
                faults.push(self.spot, self.key, message, Some(help));
                None
            }
        }
    }

    /// A list of numbers in SI units, of an allowed length.
    pub(super) fn vector(
        &self,
        lengths: RangeInclusive<usize>,
        quantity: &Quantity,
        faults: &mut Faults,
    ) -> Option<Vec<f64>> {
        let wanted = match (lengths.start(), lengths.end()) {
            (2, 2) => "two numbers: [x, y]",
            (3, 3) => "three numbers: [x, y, z]",
            _ => "two or three numbers: [x, y] or [x, y, z]",
        };
        let Value::List(list) = self.value else {
            self.wrong(wanted, faults);
            return None;
        };
        if !lengths.contains(&list.len()) {
            let message = format!("found {} numbers instead of {wanted}", list.len());
            faults.push(self.spot, self.key, message, None);
            return None;
        }
        let numbers: Vec<Option<f64>> = self.items(list).map(|item| item.quantity(quantity, faults)).collect();
        numbers.into_iter().collect()
    }

    fn items(self, list: &'a [Node]) -> impl Iterator<Item = Item<'a>> {
        list.iter().map(move |node| Item {
            key: self.key,
            spot: if node.spot.line > 0 { node.spot } else { self.spot },
            value: &node.value,
        })
    }

    /// The items of a list that is not empty.
    pub(super) fn list(&self, what: &str, faults: &mut Faults) -> Option<Vec<Item<'a>>> {
        match self.value {
            Value::List(list) if !list.is_empty() => Some(self.items(list).collect()),
            Value::List(_) => {
                let message = format!("an empty list instead of {what}");
                faults.push(self.spot, self.key, message, None);
                None
            }
            Value::Null | Value::Scalar { .. } | Value::Map(_) => {
                self.wrong(what, faults);
                None
            }
        }
    }

    /// Yes or no.
    pub(super) fn flag(&self, faults: &mut Faults) -> Option<bool> {
        match self.value {
            Value::Scalar { text, .. } if text == "true" || text == "yes" => Some(true),
            Value::Scalar { text, .. } if text == "false" || text == "no" => Some(false),
            Value::Null | Value::Scalar { .. } | Value::List(_) | Value::Map(_) => {
                self.wrong("`true` or `false`", faults);
                None
            }
        }
    }

    /// A whole number up to `max`.
    pub(super) fn count(&self, max: u32, faults: &mut Faults) -> Option<u32> {
        let count = match self.value {
            Value::Scalar { text, .. } => text.parse().ok().filter(|count| *count <= max),
            Value::Null | Value::List(_) | Value::Map(_) => None,
        };
        if count.is_none() {
            self.wrong(&format!("a whole number from 0 to {max}"), faults);
        }
        count
    }

    /// A map from names that the writer chooses.
    pub(super) fn named(&self, what: &str, faults: &mut Faults) -> Option<Vec<(Name, Item<'a>)>> {
        let Value::Map(entries) = self.value else {
            self.wrong(what, faults);
            return None;
        };
        let mut seen = BTreeSet::new();
        let mut named = Vec::new();
        for (key, node) in entries {
            // YAML itself refuses a key that comes twice, except when spelled in two ways.
            let name = Name { value: key.value.clone(), key: key.value.clone(), spot: key.spot };
            if is_name(&name, faults) && seen.insert(&key.value) {
                named.push((name, Self::under(key, node)));
            }
        }
        Some(named)
    }

    /// A map of which all keys are known; others are faults.
    pub(super) fn fields(&self, what: &'a str, allowed: &[&str], faults: &mut Faults) -> Option<Fields<'a>> {
        let Value::Map(entries) = self.value else {
            self.wrong(what, faults);
            return None;
        };
        for (key, _) in entries {
            if !allowed.contains(&key.value.as_str()) {
                let message = format!("{what} has no key `{}`", shortened(&key.value));
                let help = suggestion(&key.value, "key", allowed.iter().copied());
                faults.push(key.spot, &key.value, message, Some(help));
            }
        }
        Some(Fields { what, at: *self, entries })
    }
}

impl<'a> Fields<'a> {
    /// Where the map stands.
    pub(super) fn spot(&self) -> Spot {
        self.entries.first().map_or(self.at.spot, |(key, _)| key.spot)
    }

    /// Every entry whose key is one of these, in the order of the file.
    pub(super) fn among(&self, keys: &[&str]) -> Vec<Item<'a>> {
        self.entries
            .iter()
            .filter(|(key, _)| keys.contains(&key.value.as_str()))
            .map(|(key, node)| Item::under(key, node))
            .collect()
    }

    /// The value of a key, if it is there.
    pub(super) fn optional(&self, key: &str) -> Option<Item<'a>> {
        self.among(&[key]).into_iter().next()
    }

    /// The value of a key that must be there.
    pub(super) fn required(&self, key: &str, faults: &mut Faults) -> Option<Item<'a>> {
        let found = self.optional(key);
        if found.is_none() {
            let message = format!("{} lacks the key `{key}`", self.what);
            faults.push(self.spot(), self.at.key, message, None);
        }
        found
    }
}

fn is_name(name: &Name, faults: &mut Faults) -> bool {
    let text = &name.value;
    let message = if text.trim().is_empty() {
        "a name cannot be empty".to_owned()
    } else if text.len() > MAX_NAME_BYTES {
        format!("a name has at most {MAX_NAME_BYTES} bytes")
    } else if text.chars().any(char::is_control) {
        "a name is one line of printable letters".to_owned()
    } else {
        return true;
    };
    faults.push(name.spot, &name.key, message, None);
    false
}

/// The beginning of what was found, for a message.
fn shortened(text: &str) -> String {
    const MAX_SHOWN: usize = 40;
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
