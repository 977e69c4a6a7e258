//! Typed reading of a YAML tree: every mistake goes to the faults and reading goes on beside it.

mod fields;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

pub(crate) use fields::Fields;

use crate::document::{Entry, Located, Node, SourceSpan, Value};
use crate::fault::{At, Faults};
use crate::quantity::Quantity;
use crate::shape::Shape;
use crate::text::shortened;
use ambidex_model::{Misnamed, suggestion};

/// A value with the key that it stands under.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Item<'a> {
    /// The key; the file's or the list's for what has none of its own.
    pub(crate) key: &'a str,
    /// Where to point: the value, or the key when the value is a list, a map or nothing.
    pub(crate) span: SourceSpan,
    value: &'a Value,
}

/// A value with the key that it stands under, and where.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Written<T> {
    pub(crate) value: T,
    pub(crate) key: String,
    pub(crate) span: SourceSpan,
}

/// A name as written; one that is a key stands under itself.
pub(crate) type Name = Written<String>;

impl<'k, 'a: 'k> From<&Item<'a>> for At<'k> {
    fn from(item: &Item<'a>) -> Self {
        (item.span, item.key).into()
    }
}

impl<'k, T> From<&'k Written<T>> for At<'k> {
    fn from(written: &'k Written<T>) -> Self {
        (written.span, &written.key).into()
    }
}

impl<'a> Item<'a> {
    /// What stands in a file as a whole, under no key.
    pub(crate) fn root(node: &'a Node) -> Self {
        Self { key: "", span: node.span, value: &node.value }
    }

    fn under(key: &'a Located<String>, node: &'a Node) -> Self {
        let span = match node.value {
            Value::Scalar { .. } => node.span,
            Value::Null | Value::List(_) | Value::Map(_) => key.span,
        };
        Self { key: &key.value, span, value: &node.value }
    }

    /// Says that something else belongs here.
    pub(crate) fn wrong(&self, wanted: &str, faults: &mut Faults) {
        let found = match self.value {
            Value::Null => "nothing".to_owned(),
            Value::Scalar { text, .. } => format!("`{}`", shortened(text)),
            Value::List(_) => "a list".to_owned(),
            Value::Map(_) => "a map".to_owned(),
        };
        faults.push(self, format!("found {found} instead of {wanted}"));
    }

    /// The value of a key that the writer chose.
    pub(crate) fn of(key: &'a str, node: &'a Node) -> Self {
        Self { key, span: node.span, value: &node.value }
    }

    /// An item that has no value, for what may be left out.
    pub(crate) fn nothing(key: &'a str, span: SourceSpan) -> Self {
        Self { key, span, value: &Value::Null }
    }

    /// Whether it is a single word, number or text.
    pub(crate) fn is_scalar(&self) -> bool {
        matches!(self.value, Value::Scalar { .. })
    }

    /// Whether it is a map.
    pub(crate) fn is_map(&self) -> bool {
        matches!(self.value, Value::Map(_))
    }

    /// Whether it is a list.
    pub(crate) fn is_list(&self) -> bool {
        matches!(self.value, Value::List(_))
    }

    /// The keys of a map; none of anything else.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'a str> {
        let entries: &[_] = match self.value {
            Value::Map(entries) => entries,
            Value::Null | Value::Scalar { .. } | Value::List(_) => &[],
        };
        entries.iter().map(|(key, _)| key.value.as_str())
    }

    /// The items of a list; none of anything else.
    pub(crate) fn each(&self) -> Vec<Self> {
        match self.value {
            Value::List(list) => self.items(list).collect(),
            Value::Null | Value::Scalar { .. } | Value::Map(_) => Vec::new(),
        }
    }

    /// The value of a key of a map whose shape is not known yet.
    pub(crate) fn value_of(&self, wanted: &str) -> Option<Self> {
        let Value::Map(entries) = self.value else {
            return None;
        };
        entries.iter().find(|(key, _)| key.value == wanted).map(|(key, node)| Self::under(key, node))
    }

    /// Whether there is no value.
    pub(crate) fn is_nothing(&self) -> bool {
        matches!(self.value, Value::Null)
    }

    /// A copy of the value, to be kept beyond the file.
    pub(crate) fn node(&self) -> Node {
        Located { value: self.value.clone(), span: self.span }
    }

    /// Whether the same is written there, wherever it stands.
    pub(crate) fn is_like(&self, other: &Node) -> bool {
        self.value.is_like(&other.value)
    }

    /// A path: any text of one line.
    pub(crate) fn path(&self, what: &str, faults: &mut Faults) -> Option<Name> {
        match self.text() {
            Some(text) if !text.is_empty() && !text.contains('\0') => {
                Some(Name { value: text.to_owned(), key: self.key.to_owned(), span: self.span })
            }
            Some(_) | None => {
                self.wrong(what, faults);
                None
            }
        }
    }

    /// A name: a word, a number or quoted text.
    pub(crate) fn name(&self, what: &str, faults: &mut Faults) -> Option<Name> {
        let text = match self.value {
            // Not what anybody calls a thing: a number that went wrong.
            Value::Scalar { number: Some(number), .. } if !number.is_finite() => None,
            Value::Scalar { text, .. } => Some(text),
            Value::Null | Value::List(_) | Value::Map(_) => None,
        };
        let Some(text) = text else {
            self.wrong(what, faults);
            return None;
        };
        let name = Name { value: text.clone(), key: self.key.to_owned(), span: self.span };
        is_name(&name, faults).then_some(name)
    }

    /// One of some words.
    pub(crate) fn word(&self, allowed: &[&str], what: &str, faults: &mut Faults) -> Option<&'a str> {
        let Value::Scalar { text, .. } = self.value else {
            self.wrong(what, faults);
            return None;
        };
        if allowed.contains(&text.as_str()) {
            return Some(text);
        }
        let message = format!("found `{}` instead of {what}", shortened(text));
        faults.push_with(self, message, || suggestion(text, what, allowed.iter().copied()));
        None
    }

    /// Its text as written, where it is a word, number or text.
    pub(crate) fn text(&self) -> Option<&'a str> {
        match self.value {
            Value::Scalar { text, .. } => Some(text),
            Value::Null | Value::List(_) | Value::Map(_) => None,
        }
    }

    /// A number in SI units.
    pub(crate) fn quantity(&self, quantity: &Quantity, faults: &mut Faults) -> Option<f64> {
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
                let round = |bound: &f64| (bound * 1e5).round() / 1e5;
                let bounds = format!("allowed: {} to {} {unit}", round(from), round(to)).trim_end().to_owned();
                faults.push_with(self, message, after(quantity.meant(text), bounds));
                None
            }
            Err(_) => {
                let units: Vec<_> = dimension.units().iter().map(|unit| unit.0).collect();
                let message = format!("found `{}` instead of {}", shortened(text), dimension.example());
                let help = (units != [""]).then(|| format!("units: {}", units.join(", ")));
                faults.push_or_with(self, message, help.map(|units| after(quantity.meant(text), units)));
                None
            }
        }
    }

    /// A list of numbers in SI units, of an allowed length.
    pub(crate) fn vector(
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
            let found = if list.len() == 1 { "1 number".to_owned() } else { format!("{} numbers", list.len()) };
            faults.push(self, format!("found {found} instead of {wanted}"));
            return None;
        }
        let numbers: Vec<Option<f64>> = self.items(list).map(|item| item.quantity(quantity, faults)).collect();
        numbers.into_iter().collect()
    }

    fn items(self, list: &'a [Node]) -> impl Iterator<Item = Item<'a>> {
        list.iter().map(move |node| Item {
            key: self.key,
            span: if node.span.line > 0 { node.span } else { self.span },
            value: &node.value,
        })
    }

    /// The items of a list that is not empty.
    pub(crate) fn list(&self, what: &str, faults: &mut Faults) -> Option<Vec<Item<'a>>> {
        match self.value {
            Value::List(list) if !list.is_empty() => Some(self.items(list).collect()),
            Value::List(_) => {
                faults.push(self, format!("an empty list instead of {what}"));
                None
            }
            Value::Null | Value::Scalar { .. } | Value::Map(_) => {
                self.wrong(what, faults);
                None
            }
        }
    }

    /// `true`, `false`, `yes` or `no`.
    pub(crate) fn flag(&self, faults: &mut Faults) -> Option<bool> {
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
    pub(crate) fn count(&self, max: u32, faults: &mut Faults) -> Option<u32> {
        let count = match self.value {
            Value::Scalar { text, .. } => text.parse().ok().filter(|count| *count <= max),
            Value::Null | Value::List(_) | Value::Map(_) => None,
        };
        if count.is_none() {
            self.wrong(&format!("a whole number from 0 to {max}"), faults);
        }
        count
    }

    /// A whole number no farther from 0 than `most`.
    pub(crate) fn whole(&self, most: i32, faults: &mut Faults) -> Option<i32> {
        let number = self.text().and_then(|text| text.parse().ok()).filter(|number| (-most..=most).contains(number));
        if number.is_none() {
            self.wrong(&format!("a whole number from -{most} to {most}"), faults);
        }
        number
    }

    /// A map from names that the writer chooses.
    pub(crate) fn named(&self, what: &str, faults: &mut Faults) -> Option<Vec<(Name, Item<'a>)>> {
        let Value::Map(entries) = self.value else {
            self.wrong(what, faults);
            return None;
        };
        refuse_repeated(entries, faults);
        let mut seen = BTreeSet::new();
        let mut named = Vec::new();
        for (key, node) in entries {
            let name = Name { value: key.value.clone(), key: key.value.clone(), span: key.span };
            if is_name(&name, faults) && seen.insert(&key.value) {
                named.push((name, Self::under(key, node)));
            }
        }
        Some(named)
    }

    /// A map of that shape: unknown keys, missing ones and two where one belongs are faults.
    pub(crate) fn fields(&self, shape: &'static Shape, faults: &mut Faults) -> Option<Fields<'a>> {
        let Value::Map(entries) = self.value else {
            self.wrong(shape.what, faults);
            return None;
        };
        refuse_repeated(entries, faults);
        let fields = Fields { shape, at: *self, entries };
        let unknown = entries.iter().filter(|(key, _)| !shape.allows(&key.value));
        let mut is_complete = true;
        for (key, _) in unknown {
            is_complete = false;
            fields.unknown(key, shape.keys(), faults);
        }
        for field in shape.fields.iter().filter(|field| field.is_required) {
            if fields.get(field.key).is_none() {
                let message = format!("{} lacks the key `{}`", shape.what, field.key);
                faults.push_with((fields.span(), self.key), message, field.doc.to_owned());
            }
        }
        // A choice that is only misspelt has its fault.
        let chosen = fields.among(&shape.one_of).len();
        if !shape.one_of.is_empty() && chosen != 1 && (chosen > 1 || is_complete) {
            fields.not_one_of(chosen, shape.one_of.iter().copied(), faults);
        }
        Some(fields)
    }
}

/// What is allowed, behind what was probably meant.
fn after(meant: Option<String>, allowed: String) -> String {
    match meant {
        Some(meant) => format!("{meant} {}{}", allowed[..1].to_uppercase(), &allowed[1..]),
        None => allowed,
    }
}

/// A key stands in a map once, however it is quoted.
fn refuse_repeated(entries: &[Entry], faults: &mut Faults) {
    let mut seen = BTreeMap::new();
    for (key, _) in entries {
        if let Some(line) = seen.insert(&key.value, key.span.line) {
            faults.push((key.span, &key.value), format!("duplicate key: it stands on line {line} already"));
        }
    }
}

fn is_name(name: &Name, faults: &mut Faults) -> bool {
    match Misnamed::by_letters(&name.value) {
        Some(misnamed) => faults.push(name, misnamed.to_string()),
        None => return true,
    }
    false
}
