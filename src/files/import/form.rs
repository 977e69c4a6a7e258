//! The form of a dHTT task file: what stands in it, with every name still as written.

use std::collections::{BTreeMap, BTreeSet};

use super::entry::{Entry, Kind, Param, parent, robot};
use super::notes::{self, Note};
use super::older;
use crate::describe::{Described, Each, Later, List, PathTo, Reads, described};
use crate::document::{Located, Value};
use crate::fault::Faults;
use crate::quantity::POTENTIAL;
use crate::reader::{Item, Name};
use crate::scope::Reading;
use crate::shape::Form;

/// The parameter that gives a behavior its potential.
pub(super) const POTENTIAL_KEY: &str = "activation_potential";
/// What every tree has above its topmost node.
const ROOT: &str = "root";

const NODE_LIST: &str = "NodeList";
pub(super) const NODES: &str = "Nodes";
const BEHAVIOR_TYPE: &str = "behavior_type";
const PARAMS: &str = "params";

const WORD: Later = Later(|| Form::Word);
const WORDS: Later = Later(|| Form::List(Box::new(Form::Word)));
const ANYTHING: Later = Later(|| Form::Arguments);

described! {
    /// A task file as written.
    struct TaskFile<'a>: "a dHTT task", "A tree of nodes.", others ANYTHING, known [] {
        listed: Option<Vec<Item<'a>>> = wanted(
            NODE_LIST,
            "The names of all nodes; the children of a node stand in its order.",
            List("a list of the names of nodes", WORD)
        ),
        nodes: Option<Vec<(Name, Option<Item<'a>>)>> = wanted(
            NODES,
            "What each node is, by name.",
            Each("a map of nodes", Later(|| Form::Map(Node::shape)))
        ),
    }
}

described! {
    /// An entry of `Nodes` as written.
    struct Node<'a>: "a dHTT node", "A node of the tree.", others ANYTHING, known [] {
        kind: Option<Item<'a>> =
            wanted("type", "1 (AND), 2 (THEN), 3 (OR) or 4 (a behavior).", Later(|| Form::Count(4))),
        parent: Option<Item<'a>> =
            wanted("parent", "The name of the node above it, or NONE for the topmost.", WORD),
        plugin: Option<Item<'a>> = maybe(BEHAVIOR_TYPE, "Its plugin.", WORD),
        old_plugin: Option<Item<'a>> = maybe("type_plugin", "Its plugin, as older files call it.", WORD),
        robot: Option<Item<'a>> = maybe("robot", "The robot that it is for.", WORD),
        params: Option<Item<'a>> = maybe(PARAMS, "Texts such as 'object: cup'.", WORDS),
    }
}

/// Whether a file is a task file, as far as its keys tell.
pub(super) fn is_task(file: Item<'_>) -> bool {
    [NODE_LIST, NODES].into_iter().any(|key| file.value_of(key).is_some())
}

/// A task file in which every part that is right is known.
#[derive(Debug)]
pub(super) struct Task {
    /// In the order of `NodeList`.
    pub(super) entries: Vec<Entry>,
    /// What is not of the form.
    pub(super) notes: Vec<Note>,
}

impl Task {
    /// Reads a task file; `None` when it is no map.
    pub(super) fn read(file: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = file.fields(TaskFile::shape(), faults)?;
        let TaskFile { listed, nodes } = TaskFile::from_map(&fields, &mut Reading::new(faults))?;
        if let (Some(listed), Some(nodes)) = (&listed, &nodes) {
            check_list(listed, nodes, faults);
        }
        let listed = listed.unwrap_or_default();
        let places: BTreeMap<&str, usize> =
            listed.iter().enumerate().rev().filter_map(|(at, item)| Some((item.text()?, at))).collect();
        let nodes = nodes.unwrap_or_default().into_iter();
        let mut entries: Vec<_> = nodes.filter_map(|(name, item)| Some(Entry::read(name, item?, faults))).collect();
        entries.sort_by_key(|entry| places.get(entry.name.value.as_str()).copied());
        if entries.iter().any(|entry| entry.is_root || !entry.children.is_empty()) {
            older::settle(&mut entries, faults);
        }
        raise_zeros(&mut entries);
        Some(Self { entries, notes: notes::unknown("", &fields, faults) })
    }
}

impl Entry {
    /// An entry of `Nodes`, of either form.
    fn read(name: Name, item: Item<'_>, faults: &mut Faults) -> Self {
        let nothing = Entry::named(name);
        if older::is_older(item) {
            return older::read(nothing, item, faults);
        }
        let Some(fields) = item.fields(Node::shape(), faults) else { return nothing };
        let Some(node) = Node::from_map(&fields, &mut Reading::new(faults)) else { return nothing };
        let kind = node.kind.and_then(|item| kind(item, faults));
        let plugin = [node.plugin, node.old_plugin].into_iter().flatten().min_by_key(|item| item.span.offset);
        if kind == Some(Kind::Behavior) && plugin.is_none() {
            let message = format!("a behavior lacks the key `{BEHAVIOR_TYPE}`");
            let help = "its plugin, such as dhtt_plugins::TestBehavior".to_owned();
            faults.push_with((fields.span(), &nothing.name.value), message, help);
        }
        let mut entry = Self {
            kind,
            parent: node.parent.and_then(|item| parent(item, faults)),
            plugin: plugin.and_then(|item| PathTo("the name of a plugin").take(item, faults)),
            robot: node.robot.and_then(|item| robot(item, faults)),
            notes: notes::unknown(&nothing.name.value, &fields, faults),
            ..nothing
        };
        entry.read_params(node.params, faults);
        entry
    }

    fn read_params(&mut self, params: Option<Item<'_>>, faults: &mut Faults) {
        let Some(params) = params.filter(|item| !item.is_nothing()) else { return };
        if !params.is_list() {
            return params.wrong("a list of texts such as 'object: cup'", faults);
        }
        let mut seen = BTreeSet::new();
        for item in params.each() {
            let Some((key, value)) = param(item, faults) else { continue };
            let is_first = seen.insert(key);
            if key == POTENTIAL_KEY && !is_first {
                faults.push((item.span, PARAMS), format!("`{POTENTIAL_KEY}` comes twice"));
            } else if key == POTENTIAL_KEY {
                let number = Value::Scalar { text: value.to_owned(), number: None };
                let number = Located { value: number, span: item.span };
                self.potential = Item::of(POTENTIAL_KEY, &number).quantity(&POTENTIAL, faults);
            } else if is_first {
                self.params.push(Param { key: key.to_owned(), value: value.to_owned(), span: item.span });
            } else {
                let message = format!("`{key}` comes twice: `{key}: {value}` is left out");
                self.notes.push(Note::new(&self.name.value, item.span, message, None));
            }
        }
    }
}

/// A potential of 0 means to run last, which is what a mission says with one that is less than all others.
fn raise_zeros(entries: &mut [Entry]) {
    const LAST: f64 = 0.001;
    // A behavior that tells none gets 1.
    let potentials = || entries.iter().filter(|entry| entry.kind == Some(Kind::Behavior)).map(|entry| entry.potential);
    let others = potentials().map(|potential| potential.unwrap_or(1.0)).filter(|potential| *potential > 0.0);
    let least = others.fold(1.0, f64::min);
    let last = if LAST < least { LAST } else { least / 2.0 };
    for entry in entries.iter_mut().filter(|entry| entry.kind == Some(Kind::Behavior)) {
        if entry.potential == Some(0.0) {
            entry.potential = Some(last);
            let message = format!("a potential of 0 means to run last: it is {last} now, less than all others");
            let help = "in a mission a potential of 0 means never to run".to_owned();
            entry.notes.push(Note::new(&entry.name.value, entry.name.span, message, Some(help)));
        }
    }
}

/// Each node is listed once, and each that is listed is there.
fn check_list(listed: &[Item<'_>], nodes: &[(Name, Option<Item<'_>>)], faults: &mut Faults) {
    let there: BTreeSet<&str> = nodes.iter().map(|(name, _)| name.value.as_str()).collect();
    let mut seen = BTreeSet::new();
    for item in listed {
        let Some(name) = item.name("the name of a node", faults) else { continue };
        if !there.contains(name.value.as_str()) {
            let message = format!("`{}` has no entry in `{NODES}`", name.value);
            let help = notes::suggested(&name.value, "node", there.iter().copied(), faults);
            faults.push_or_with((name.span, NODE_LIST), message, help);
        }
        if !seen.insert(name.value.clone()) {
            faults.push((name.span, NODE_LIST), format!("`{}` comes twice", name.value));
        }
    }
    for (name, _) in nodes {
        if !seen.contains(&name.value) {
            let help = "add it there, where it belongs among the children of its parent".to_owned();
            faults.push_with((name.span, &name.value), format!("not in `{NODE_LIST}`"), help);
        }
        if name.value == ROOT || notes::is_template(&name.value) {
            let help = "`root` stands above every tree, and `$` for an argument: rename it".to_owned();
            faults.push_with((name.span, &name.value), format!("a node cannot be called `{}`", name.value), help);
        }
    }
}

fn kind(item: Item<'_>, faults: &mut Faults) -> Option<Kind> {
    let (message, help) = match item.text() {
        Some("1") => return Some(Kind::And),
        Some("2") => return Some(Kind::Then),
        Some("3") => return Some(Kind::Or),
        Some("4") => return Some(Kind::Behavior),
        Some("0") => ("type 0 is the root, which every tree has of itself", "leave the node out"),
        Some("5") => (
            "type 5 is the tree of another file, which is not followed",
            "write the nodes of that file in its place, or import that file by itself",
        ),
        Some(_) | None => {
            item.wrong("1 (AND), 2 (THEN), 3 (OR) or 4 (a behavior)", faults);
            return None;
        }
    };
    faults.push_with(&item, message.to_owned(), help.to_owned());
    None
}

/// A text 'key: value' as its two halves.
fn param<'a>(item: Item<'a>, faults: &mut Faults) -> Option<(&'a str, &'a str)> {
    const HELP: &str = "write it in quotes, with a colon: 'object: cup'";
    let halves = item.text().and_then(|text| text.split_once(':'));
    let halves = halves.map(|(key, value)| (key.trim(), value.trim()));
    let found = halves.filter(|(key, value)| !key.is_empty() && !value.is_empty());
    if found.is_none() {
        let message = match item.text() {
            Some(text) => format!("`{}` is not of the form 'key: value'", notes::line(text)),
            None => "a parameter is a text of the form 'key: value'".to_owned(),
        };
        faults.push_with(&item, message, HELP.to_owned());
    }
    found
}
