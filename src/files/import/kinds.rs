//! The kinds of behavior of a mission, one for each plugin, with a parameter for all that its nodes tell.

use std::collections::{BTreeMap, BTreeSet};

use super::entry::{Entry, Kind, Param};
use super::form::POTENTIAL_KEY;
use super::notes::{Note, is_template, line};
use crate::task::node_shape;
use ambidex_model::{NAME_MAX, is_obeyed};

/// Longest name of a kind, so that its label has room for parameters.
const MAX_KIND_BYTES: usize = 48;
/// What a plugin is called whose own name cannot be that of a kind.
const NAMELESS: &str = "behavior";

/// A kind before it is written.
#[derive(Debug)]
pub(super) struct KindDraft {
    pub(super) name: String,
    pub(super) plugin: String,
    /// What a node of it is called if it has no name of its own.
    pub(super) label: String,
    pub(super) texts: Vec<TextDraft>,
    /// Whether every node of it tells its potential.
    pub(super) is_told: bool,
}

/// A parameter that is a text.
#[derive(Debug)]
pub(super) struct TextDraft {
    pub(super) name: String,
    /// Whether every node of the kind tells it.
    pub(super) is_told: bool,
}

/// Every kind of a task, in the order of the nodes.
#[derive(Debug, Default)]
pub(super) struct Kinds {
    list: Vec<KindDraft>,
    by_plugin: BTreeMap<String, usize>,
    names: BTreeSet<String>,
    /// The last number behind each name that several plugins have.
    numbers: BTreeMap<String, u32>,
}

impl Kinds {
    pub(super) fn of(entries: &[Entry]) -> Self {
        let mut kinds = Self::default();
        let behaviors = || entries.iter().filter(|entry| entry.kind == Some(Kind::Behavior));
        for entry in behaviors() {
            let kind = kinds.kind(entry.plugin.as_ref().map_or("", |plugin| &plugin.value));
            for param in entry.params.iter().filter(|param| misfit(param).is_none()) {
                kind.add(&param.key);
            }
        }
        for entry in behaviors() {
            let kind = kinds.kind(entry.plugin.as_ref().map_or("", |plugin| &plugin.value));
            kind.is_told &= entry.potential.is_some();
            for text in &mut kind.texts {
                text.is_told &= entry.params.iter().any(|param| param.key == text.name && misfit(param).is_none());
            }
        }
        kinds
    }

    pub(super) fn into_list(self) -> Vec<KindDraft> {
        self.list
    }

    /// The kind of a behavior.
    pub(super) fn of_entry(&self, entry: &Entry) -> Option<&KindDraft> {
        self.by_plugin.get(&entry.plugin.as_ref()?.value).map(|kind| &self.list[*kind])
    }

    /// What a behavior tells its kind, and what of its parameters it cannot tell.
    pub(super) fn arguments(&self, entry: &Entry) -> (Vec<(String, String)>, Vec<Note>) {
        let potential = entry.potential.map(|potential| (POTENTIAL_KEY.to_owned(), potential.to_string()));
        let mut arguments: Vec<_> = potential.into_iter().collect();
        let mut left_out = Vec::new();
        let texts = self.of_entry(entry).map_or(&[][..], |kind| &kind.texts);
        for param in &entry.params {
            let Param { key, value, span } = param;
            let why = misfit(param).or_else(|| {
                let is_there = texts.iter().any(|text| text.name == *key);
                (!is_there).then(|| "there are too many parameters".to_owned())
            });
            match why {
                None => arguments.push((key.clone(), value.clone())),
                Some(why) => {
                    let message = format!("`{}: {}` is left out: {why}", line(key), line(value));
                    left_out.push(Note::new(&entry.name.value, *span, message, None));
                }
            }
        }
        (arguments, left_out)
    }

    fn kind(&mut self, plugin: &str) -> &mut KindDraft {
        let next = self.list.len();
        let index = *self.by_plugin.entry(plugin.to_owned()).or_insert(next);
        if index == next {
            let name = self.name(plugin);
            let (label, texts) = (name.clone(), Vec::new());
            self.list.push(KindDraft { name, plugin: plugin.to_owned(), label, texts, is_told: true });
        }
        &mut self.list[index]
    }

    /// The last part of the plugin's name, or all of it; with a number if others have that.
    fn name(&mut self, plugin: &str) -> String {
        let last = plugin.rsplit("::").next().unwrap_or_default();
        let plain = if is_name(last) { last } else { NAMELESS };
        let is_free = |name: &&str| is_name(name) && !is_taken(name) && !self.names.contains(*name);
        if let Some(free) = [last, plugin, plain].into_iter().find(is_free) {
            self.names.insert(free.to_owned());
            return free.to_owned();
        }
        let number = self.numbers.entry(plain.to_owned()).or_insert(1);
        loop {
            *number += 1;
            let name = format!("{plain} {number}");
            if self.names.insert(name.clone()) {
                return name;
            }
        }
    }
}

impl KindDraft {
    /// A parameter stands in the label, so that it is of some use; one too many is not declared.
    fn add(&mut self, key: &str) {
        let longer = format!("{} ${key}", self.label);
        if longer.len() <= NAME_MAX && self.texts.iter().all(|text| text.name != key) {
            self.label = longer;
            self.texts.push(TextDraft { name: key.to_owned(), is_told: true });
        }
    }
}

/// Why a parameter cannot be an argument; none if it can.
fn misfit(Param { key, value, .. }: &Param) -> Option<String> {
    if !key.chars().all(|letter| letter.is_alphanumeric() || letter == '_') {
        Some("the name of a parameter is made of letters, digits and `_`".to_owned())
    } else if is_template(value) {
        Some("`$` stands for an argument, which the file does not give".to_owned())
    } else if value.len() > NAME_MAX || value.chars().any(is_obeyed) {
        Some(format!("an argument is one line of at most {NAME_MAX} bytes"))
    } else {
        None
    }
}

/// Whether a name means something else already.
fn is_taken(name: &str) -> bool {
    let built_in = node_shape().others.iter().flat_map(|others| &others.known).map(|field| field.key);
    node_shape().keys().chain(built_in).any(|taken| taken == name)
}

fn is_name(text: &str) -> bool {
    let is_short = !text.trim().is_empty() && text.len() <= MAX_KIND_BYTES;
    is_short && !text.chars().any(is_obeyed) && !is_template(text)
}
