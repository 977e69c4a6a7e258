//! A dHTT tree as a mission: a kind of behavior for each plugin, and at each node what its kind can be told.

use std::collections::{BTreeMap, BTreeSet};

use super::entry::{Entry, Kind, Param};
use super::form::{POTENTIAL_KEY, Task};
use super::kinds::{KindDraft, Kinds};
use super::notes::{Note, line};
use super::tree::Tree;
use crate::document::SourceSpan;

/// Most names listed of one parameter.
const MAX_LISTED: usize = 12;
const ONE_ROBOT: &str = "a mission is for one robot, which does everything";
const TO_MOVE: &str = "to drive and take things a mission says `move`, `pick` and `place`";

/// A mission before it is written.
#[derive(Debug)]
pub(super) struct Draft {
    pub(super) kinds: Vec<KindDraft>,
    pub(super) top: NodeDraft,
    /// What the task is told of by words: each parameter with its values.
    pub(super) named: Vec<(String, Vec<String>)>,
    /// Comments on the file as a whole.
    pub(super) comments: Vec<String>,
    /// Everything that is not carried over.
    pub(super) notes: Vec<Note>,
}

/// A node before it is written.
#[derive(Debug)]
pub(super) struct NodeDraft {
    pub(super) name: String,
    pub(super) is: Is,
    pub(super) comments: Vec<String>,
}

/// What a node is.
#[derive(Debug)]
pub(super) enum Is {
    /// `and`, `or` or `then`.
    Composite(&'static str, Vec<NodeDraft>),
    /// A behavior: its kind and its arguments.
    Behavior(String, Vec<(String, String)>),
}

/// Translates a task whose tree is sound.
pub(super) fn translate(task: &Task, tree: &Tree) -> Draft {
    let kinds = Kinds::of(&task.entries);
    let robot = task.entries.iter().find_map(|entry| entry.robot.as_ref());
    let mut translation = Translation { entries: &task.entries, tree, kinds: &kinds, robot, notes: Vec::new() };
    let top = translation.node(tree.top);
    let mut notes = translation.notes;
    let of_all: Vec<Note> = robot.map(of_robot).into_iter().chain(task.notes.iter().cloned()).collect();
    let comments = of_all.iter().map(Note::comment).collect();
    notes.extend(of_all);
    Draft { named: named(&task.entries, &kinds), kinds: kinds.into_list(), top, comments, notes }
}

impl NodeDraft {
    /// Names in preorder.
    pub(super) fn names(&self) -> Vec<&str> {
        let below: &[Self] = match &self.is {
            Is::Composite(_, children) => children,
            Is::Behavior(..) => &[],
        };
        [self.name.as_str()].into_iter().chain(below.iter().flat_map(Self::names)).collect()
    }
}

struct Translation<'a> {
    entries: &'a [Entry],
    tree: &'a Tree,
    kinds: &'a Kinds,
    /// The first that a node is for.
    robot: Option<&'a (String, SourceSpan)>,
    notes: Vec<Note>,
}

impl Translation<'_> {
    fn node(&mut self, at: usize) -> NodeDraft {
        let entry = &self.entries[at];
        let mut notes = entry.notes.clone();
        notes.extend(other_robot(entry, self.robot));
        let is = match entry.kind.and_then(Kind::word) {
            Some(word) => {
                notes.extend(of_composite(entry, word));
                Is::Composite(word, self.tree.children[at].iter().map(|child| self.node(*child)).collect())
            }
            None => {
                let (arguments, left_out) = self.kinds.arguments(entry);
                notes.extend(left_out);
                let kind = self.kinds.of_entry(entry).map(|kind| kind.name.clone()).unwrap_or_default();
                // What every node of the kind has in common is told where the kind is declared.
                self.notes.extend(of_behavior(entry, &arguments));
                Is::Behavior(kind, arguments)
            }
        };
        let comments = notes.iter().map(Note::comment).collect();
        self.notes.extend(notes);
        NodeDraft { name: entry.name.value.clone(), is, comments }
    }
}

/// What AND, OR and THEN cannot be told.
fn of_composite(entry: &Entry, word: &str) -> Vec<Note> {
    let name = &entry.name.value;
    let usual = format!("{word}behavior");
    let plugin = entry.plugin.as_ref().filter(|plugin| {
        let last = plugin.value.rsplit("::").next().unwrap_or_default();
        last.to_lowercase() != usual
    });
    let odd = plugin.map(|plugin| {
        let message = format!("its plugin `{}` is left out: it becomes a plain `{word}`", line(&plugin.value));
        Note::new(name, plugin.span, message, None)
    });
    let potential = entry.potential.map(|potential| Param {
        key: POTENTIAL_KEY.to_owned(),
        value: potential.to_string(),
        span: entry.name.span,
    });
    let params = potential.iter().chain(&entry.params).map(|Param { key, value, span }| {
        let message = format!("`{}: {}` is left out: `{word}` has no parameters", line(key), line(value));
        Note::new(name, *span, message, None)
    });
    odd.into_iter().chain(params).collect()
}

/// What a behavior does not tell of itself, or tells in vain.
fn of_behavior(entry: &Entry, arguments: &[(String, String)]) -> Option<Note> {
    let name = &entry.name.value;
    let texts = entry.params.iter().filter(|param| arguments.iter().any(|(key, _)| *key == param.key));
    let texts: Vec<String> = texts.map(|Param { key, value, .. }| format!("`{key}: {value}`")).collect();
    let kept = match texts.as_slice() {
        [] => None,
        [one] => Some(format!("{one} is kept as a text that nothing acts by")),
        several => Some(format!("{} are kept as texts that nothing acts by", several.join(", "))),
    };
    let plugin = entry.plugin.as_ref();
    let span = plugin.map_or(entry.name.span, |plugin| plugin.span);
    if entry.potential.is_none() {
        let plugin = plugin.map_or("", |plugin| &plugin.value);
        let computed = format!("`{}` computes its potential, which is not in the file: it is 1 now", line(plugin));
        let message = [Some(computed), kept].into_iter().flatten().collect::<Vec<_>>().join("; ");
        return Some(Note::new(name, span, message, Some(format!("a plugin is code, and not imported; {TO_MOVE}"))));
    }
    let span = entry.params.first().map_or(span, |param| param.span);
    kept.map(|kept| Note::new(name, span, kept, Some(TO_MOVE.to_owned())))
}

/// Said once, at the first node.
fn of_robot((robot, span): &(String, SourceSpan)) -> Note {
    let message = format!("`robot: {}` is left out wherever it stands", line(robot));
    Note::new("", *span, message, Some(ONE_ROBOT.to_owned()))
}

/// Said at each node that is for another robot than the first.
fn other_robot(entry: &Entry, first: Option<&(String, SourceSpan)>) -> Option<Note> {
    let (first, _) = first?;
    let (robot, span) = entry.robot.as_ref().filter(|(robot, _)| robot != first)?;
    let message = format!("`robot: {}` is left out, though other nodes are for robot {}", line(robot), line(first));
    Some(Note::new(&entry.name.value, *span, message, Some(ONE_ROBOT.to_owned())))
}

/// The values of each parameter that is kept as a text.
fn named(entries: &[Entry], kinds: &Kinds) -> Vec<(String, Vec<String>)> {
    let mut named: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for entry in entries.iter().filter(|entry| entry.kind == Some(Kind::Behavior)) {
        let (arguments, _) = kinds.arguments(entry);
        for (key, value) in arguments.into_iter().filter(|(key, _)| key != POTENTIAL_KEY) {
            named.entry(key).or_default().insert(value);
        }
    }
    let shown = |values: BTreeSet<String>| values.into_iter().take(MAX_LISTED).collect();
    named.into_iter().map(|(key, values)| (key, shown(values))).collect()
}
