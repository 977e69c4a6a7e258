//! Subtrees that are written once and used with arguments.

use std::collections::{BTreeMap, BTreeSet};

use super::super::document::{Located, Node, Spot, Value};
use super::super::fault::Faults;
use super::super::parameter::{PARAMETERS, Parameter, Type};
use super::super::reader::{Item, Name};
use super::super::shape::{Form, Shape, optional, required};
use super::super::template::{Piece, parameter, pieces};
use super::NODE;
use crate::model::suggestion;

/// An entry of `subtrees`.
pub(in super::super) static SUBTREE: Shape = Shape::new(
    "a subtree",
    "A part of a task to be used with arguments. `$name` stands for an argument.",
    &[
        optional("parameters", "What a `use` of it tells; the first one can be written without its name.", PARAMETERS),
        required("task", "What it does.", Form::Map(&NODE)),
    ],
);

/// Every subtree of the files, by name.
#[derive(Debug, Default)]
pub(in super::super) struct Subtrees<'a> {
    by_name: BTreeMap<String, Subtree<'a>>,
    /// Subtrees whose faults are told.
    broken: BTreeSet<String>,
    /// Those that use themselves, whatever lies between.
    endless: BTreeSet<String>,
}

/// A subtree.
#[derive(Debug)]
pub(super) struct Subtree<'a> {
    pub(super) name: Name,
    pub(super) parameters: Vec<Parameter>,
    pub(super) task: Item<'a>,
}

/// What parameters stand for while a subtree is read.
#[derive(Debug, Clone, Default)]
pub(super) struct Scope<'a> {
    parameters: &'a [Parameter],
    /// By parameter; all none while the subtree is only checked.
    values: Vec<Option<Node>>,
    /// Whether this is a subtree at all.
    pub(super) is_subtree: bool,
}

/// A value in which parameters were filled in.
#[derive(Debug)]
pub(super) enum Filled {
    /// A value.
    Value(Node),
    /// What stands there is known only where the subtree is used.
    Open,
}

impl<'a> Subtrees<'a> {
    /// Adds what stands under `subtrees`.
    pub(in super::super) fn declare(&mut self, subtrees: Option<Item<'a>>, faults: &mut Faults) {
        let Some(entries) = subtrees.and_then(|item| item.named("a map of subtrees", faults)) else {
            return;
        };
        for (name, item) in entries {
            if self.by_name.contains_key(&name.value) {
                let message = format!("there is a subtree `{}` already", name.value);
                faults.push(name.spot, &name.key, message, None);
                continue;
            }
            let before = faults.errors();
            let read = item.fields(&SUBTREE, faults).and_then(|fields| {
                let parameters = Parameter::read_all(fields.get("parameters"), faults);
                Some((parameters, fields.get("task")?))
            });
            match read.filter(|_| faults.errors() == before) {
                Some((parameters, task)) => {
                    self.by_name.insert(name.value.clone(), Subtree { name, parameters, task });
                }
                None => drop(self.broken.insert(name.value)),
            }
        }
    }

    /// The subtree of a name.
    pub(super) fn get(&self, name: &str) -> Option<&Subtree<'a>> {
        self.by_name.get(name)
    }

    /// Whether a subtree of that name has faults of its own.
    pub(super) fn is_broken(&self, name: &str) -> bool {
        self.broken.contains(name)
    }

    /// All of them in the order of their names.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Subtree<'a>> {
        self.by_name.values()
    }

    /// All names in order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }

    /// Whether using it would never end.
    pub(super) fn is_endless(&self, name: &str) -> bool {
        self.endless.contains(name)
    }

    /// Finds subtrees that use themselves. `uses` says who uses whom where.
    pub(super) fn refuse_cycles(&mut self, uses: &BTreeMap<String, Vec<(String, Spot)>>, faults: &mut Faults) {
        for name in self.by_name.keys() {
            let Some(way) = way_back(name, uses) else { continue };
            self.endless.insert(name.clone());
            // Told once for all on the way, at the first name of it.
            if way.iter().any(|(on, _)| on < name) {
                continue;
            }
            let names: Vec<&str> = [name.as_str()].into_iter().chain(way.iter().map(|(on, _)| on.as_str())).collect();
            let message = format!("`{name}` uses itself: {}", names.join(" → "));
            faults.push(way[0].1, "use", message, None);
        }
        let reaches_one = |name: &String| reached(name, uses).iter().any(|other| self.endless.contains(other));
        let leading: Vec<_> = self.by_name.keys().filter(|name| reaches_one(name)).cloned().collect();
        self.endless.extend(leading);
    }
}

/// Everything that a subtree uses, directly or not.
fn reached(name: &str, uses: &BTreeMap<String, Vec<(String, Spot)>>) -> BTreeSet<String> {
    let mut reached = BTreeSet::new();
    let mut open = vec![name.to_owned()];
    while let Some(next) = open.pop() {
        for (used, _) in uses.get(&next).into_iter().flatten() {
            if reached.insert(used.clone()) {
                open.push(used.clone());
            }
        }
    }
    reached
}

/// A shortest way of uses from a subtree back to itself.
fn way_back(name: &str, uses: &BTreeMap<String, Vec<(String, Spot)>>) -> Option<Vec<(String, Spot)>> {
    let none = Vec::new();
    let next = |(at, _): &(String, Spot)| uses.get(at).unwrap_or(&none).clone();
    let start = (name.to_owned(), Spot::default());
    let firsts = next(&start);
    let mut ways: Vec<Vec<(String, Spot)>> = firsts.into_iter().map(|first| vec![first]).collect();
    let mut seen = BTreeSet::new();
    let mut index = 0;
    while let Some(way) = ways.get(index).cloned() {
        index += 1;
        let last = way.last()?;
        if last.0 == name {
            return Some(way);
        }
        if seen.insert(last.0.clone()) {
            ways.extend(next(last).into_iter().map(|step| way.iter().cloned().chain([step]).collect()));
        }
    }
    None
}

impl<'a> Scope<'a> {
    /// A subtree with its arguments, by parameter.
    pub(super) fn of(parameters: &'a [Parameter], values: Vec<Option<Node>>) -> Self {
        Self { parameters, values, is_subtree: true }
    }

    /// A subtree that is only checked.
    pub(super) fn open(parameters: &'a [Parameter]) -> Self {
        Self::of(parameters, vec![None; parameters.len()])
    }

    /// A value with arguments filled in; `None` where one is unknown or of another type, which is a fault.
    pub(super) fn fill(
        &self,
        item: Item<'_>,
        ty: Type,
        used: &mut BTreeSet<usize>,
        faults: &mut Faults,
    ) -> Option<Filled> {
        let Some(text) = item.text() else {
            return Some(Filled::Value(item.node()));
        };
        if let Some(name) = parameter(text) {
            let index = self.find(name, &item, used, faults)?;
            let found = self.parameters[index].ty;
            if found != ty && ty != Type::Text {
                let message = format!("`${name}` is {}, not {}", found.what(), ty.what());
                faults.push(item.spot, item.key, message, None);
                return None;
            }
            return Some(self.values[index].clone().map_or(Filled::Open, Filled::Value));
        }
        let mut value = String::new();
        let mut is_open = false;
        for piece in pieces(text) {
            match piece {
                Piece::Plain(text) => value += text,
                Piece::Parameter(name) => match &self.values[self.find(name, &item, used, faults)?] {
                    Some(Node { value: Value::Scalar { text, .. }, .. }) => value += text,
                    Some(_) => {}
                    None => is_open = true,
                },
            }
        }
        let is_same = value == text;
        Some(match (is_open, is_same) {
            (true, _) => Filled::Open,
            (false, true) => Filled::Value(item.node()),
            (false, false) => {
                Filled::Value(Located { value: Value::Scalar { text: value, number: None }, spot: item.spot })
            }
        })
    }

    fn find(&self, name: &str, item: &Item<'_>, used: &mut BTreeSet<usize>, faults: &mut Faults) -> Option<usize> {
        let found = self.parameters.iter().position(|parameter| parameter.name.value == name);
        used.extend(found);
        if found.is_none() {
            let allowed = self.parameters.iter().map(|parameter| parameter.name.value.as_str());
            let help = suggestion(name, "parameter", allowed);
            let message = format!("there is no parameter `{name}` here");
            faults.push(item.spot, item.key, message, Some(help));
        }
        found
    }
}
