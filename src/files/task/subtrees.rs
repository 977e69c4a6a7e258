//! Subtrees that are written once and used with arguments.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use super::node::{self, USE};
use crate::describe::{Described, Later, described};
use crate::document::{Located, Node, SourceSpan, Value};
use crate::fault::Faults;
use crate::kinds::OF_THE_WORLD;
use crate::names::refuse_argument;
use crate::parameter::{Known, PARAMETERS, Parameter, refuse_open_defaults};
use crate::reader::{Item, Name};
use crate::settings::Given;
use crate::template::{Piece, parameter, pieces};
use crate::types::Type;
use ambidex_model::suggestion;

described! {
    /// An entry of `subtrees`.
    pub(crate) struct Subtree<'a>: "a subtree",
    "A part of a task to be used with arguments. `$name` stands for an argument." {
        parameters: Vec<Parameter> = or(
            "parameters",
            "What a `use` of it tells; the first one can be written without its name.",
            PARAMETERS,
            Vec::new()
        ),
        /// Read where it is used.
        _task: Item<'a> = required(TASK, "What it does.", Later(node::node_form)),
    }
}

const TASK: &str = "task";

/// Every subtree of the files, by name.
#[derive(Debug, Clone, Default)]
pub(crate) struct Subtrees {
    by_name: BTreeMap<String, Arc<Part>>,
    /// Subtrees whose faults are told.
    broken: BTreeSet<String>,
    /// Those that use themselves, whatever lies between.
    endless: BTreeSet<String>,
    /// So many files were read before, and what they declare was checked: it may be declared again, if it is the same.
    known_files: usize,
}

/// A subtree with its name.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) name: Name,
    pub(crate) parameters: Vec<Parameter>,
    written: Node,
}

impl Part {
    /// What it does.
    pub(crate) fn task(&self) -> Item<'_> {
        let whole = Item::of(&self.name.value, &self.written);
        whole.value_of(TASK).unwrap_or(whole)
    }

    /// What its top is called where nothing is told: after it and its first argument.
    pub(crate) fn label(&self, first: Option<String>) -> Name {
        let value = [Some(self.name.value.clone()), first].into_iter().flatten().collect::<Vec<_>>().join(" ");
        Name { value, ..self.name.clone() }
    }
}

/// Which subtrees each one uses, and where.
pub(super) type Uses = BTreeMap<String, Vec<(String, SourceSpan)>>;

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
    /// A value without parameters.
    Value(Node),
    /// What stands there is known only where the subtree is used.
    Open,
}

impl Subtrees {
    /// The same, to which those of further files are added.
    pub(crate) fn beside(&self, known_files: usize) -> Self {
        Self { known_files, ..self.clone() }
    }

    /// Adds what stands under `subtrees`.
    pub(crate) fn declare(&mut self, subtrees: Option<Item<'_>>, faults: &mut Faults) {
        let Some(entries) = subtrees.and_then(|item| item.named("a map of subtrees", faults)) else {
            return;
        };
        for (name, item) in entries {
            if let Some(first) = self.by_name.get(&name.value) {
                let is_known = first.name.span.file < self.known_files;
                if !is_known || !item.is_like(&first.written) {
                    let help = is_known.then(|| OF_THE_WORLD.to_owned());
                    faults.push_or_with(&name, format!("there is a subtree `{}` already", name.value), help);
                }
                continue;
            }
            refuse_argument(&name, faults);
            let before = faults.errors();
            let read = Subtree::take(item, faults);
            refuse_open_defaults("a subtree", read.iter().flat_map(|subtree| &subtree.parameters), faults);
            match read.filter(|_| faults.errors() == before) {
                Some(Subtree { parameters, .. }) => {
                    let part = Part { name, parameters, written: item.node() };
                    self.by_name.insert(part.name.value.clone(), Arc::new(part));
                }
                None => drop(self.broken.insert(name.value)),
            }
        }
    }

    /// The subtree of a name.
    pub(crate) fn get(&self, name: &str) -> Option<&Part> {
        self.by_name.get(name).map(Arc::as_ref)
    }

    /// Whether a subtree of that name has faults of its own.
    pub(super) fn is_broken(&self, name: &str) -> bool {
        self.broken.contains(name)
    }

    /// Those that were not checked before, in the order of their names.
    pub(super) fn unchecked(&self) -> impl Iterator<Item = &Part> {
        self.by_name.values().map(Arc::as_ref).filter(|part| part.name.span.file >= self.known_files)
    }

    /// All names in order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }

    /// Warns of defaults in one file that name nothing: what uses the subtree may tell another value, or be missed.
    pub(crate) fn check_defaults(&self, known: &Known<'_>, own_file: usize, faults: &mut Faults) {
        let own = self.unchecked().filter(|part| part.name.span.file == own_file);
        own.flat_map(|part| &part.parameters).for_each(|parameter| known.warn_of_default(parameter, faults));
    }

    /// What was probably meant by a name that no subtree has, and what is allowed.
    pub(crate) fn suggestion(&self, name: &str) -> String {
        suggestion(name, "subtree", self.names())
    }

    /// Whether using it would never end.
    pub(super) fn is_endless(&self, name: &str) -> bool {
        self.endless.contains(name)
    }

    /// Finds subtrees that use themselves. `uses` says who uses target where.
    pub(super) fn refuse_cycles(&mut self, uses: &Uses, faults: &mut Faults) {
        let edges = || uses.iter().flat_map(|(user, used)| used.iter().map(|(used, _)| (user.as_str(), used.as_str())));
        let leading = never_ending(edges());
        let within = |(user, used): &(&str, &str)| leading.contains(user) && leading.contains(used);
        // What also never ends read backwards is on a cycle, or between two.
        let on_cycles = never_ending(edges().filter(within).map(|(user, used)| (used, user)));
        let mut told = BTreeSet::new();
        for name in on_cycles {
            if told.contains(name) {
                continue;
            }
            let Some(way) = way_back(name, uses) else { continue };
            // Told once for all on the way, at the first name of it.
            if way.iter().all(|(on, _)| *on >= name) {
                told.extend(way.iter().map(|(on, _)| *on));
                faults.push((way[0].1, USE), format!("`{name}` uses itself: {}", shown(name, &way)));
            }
        }
        self.endless = leading.into_iter().map(str::to_owned).collect();
    }
}

/// Names on a way, as many as can be read.
fn shown(name: &str, way: &[(&str, SourceSpan)]) -> String {
    const MAX_SHOWN: usize = 12;
    let mut names: Vec<&str> = [name].into_iter().chain(way.iter().map(|(on, _)| *on)).collect();
    if names.len() > MAX_SHOWN {
        names.splice(MAX_SHOWN - 2..names.len() - 1, ["…"]);
    }
    names.join(" → ")
}

/// Users that lead to a cycle: those left when all that use nothing (more) are taken away.
fn never_ending<'a>(edges: impl Iterator<Item = (&'a str, &'a str)>) -> BTreeSet<&'a str> {
    let mut users: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut open: BTreeMap<&str, usize> = BTreeMap::new();
    for (user, used) in edges {
        users.entry(used).or_default().push(user);
        open.entry(used).or_default();
        *open.entry(user).or_default() += 1;
    }
    let mut ended: Vec<&str> = open.iter().filter(|(_, uses)| **uses == 0).map(|(name, _)| *name).collect();
    while let Some(used) = ended.pop() {
        open.remove(used);
        for user in users.get(used).into_iter().flatten() {
            if let Some(uses) = open.get_mut(user) {
                *uses -= 1;
                ended.extend((*uses == 0).then_some(*user));
            }
        }
    }
    open.into_keys().collect()
}

/// A shortest way of uses from a subtree back to itself.
fn way_back<'a>(name: &str, uses: &'a Uses) -> Option<Vec<(&'a str, SourceSpan)>> {
    // By subtree: who uses it first, and where.
    let mut before: BTreeMap<&str, (&str, SourceSpan)> = BTreeMap::new();
    let mut open = VecDeque::from([name]);
    while let Some(user) = open.pop_front() {
        for (used, span) in uses.get(user).into_iter().flatten() {
            if !before.contains_key(used.as_str()) {
                before.insert(used, (user, *span));
                open.push_back(used);
            }
        }
    }
    let mut way = Vec::new();
    let mut at = name;
    while let Some((&used, &(user, span))) = before.get_key_value(at) {
        way.push((used, span));
        if user == name {
            way.reverse();
            return Some(way);
        }
        at = user;
    }
    None
}

impl<'a> Scope<'a> {
    /// A subtree with its arguments, by parameter.
    pub(super) fn of(parameters: &'a [Parameter], values: Vec<Option<Node>>) -> Self {
        Self { parameters, values, is_subtree: true }
    }

    /// A whole task, which may be a subtree, with its parameters.
    pub(super) fn of_task(given: &'a Given, is_subtree: bool) -> Self {
        Self { parameters: &given.parameters, values: given.values.clone(), is_subtree }
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
            // The place of an object is where that lies.
            let is_place_of = (found, ty) == (Type::Object, Type::Place);
            if found != ty && ty != Type::Text && !is_place_of {
                faults.push(&item, format!("`${name}` is {}, not {}", found.what(), ty.what()));
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
                Filled::Value(Located { value: Value::Scalar { text: value, number: None }, span: item.span })
            }
        })
    }

    fn find(&self, name: &str, item: &Item<'_>, used: &mut BTreeSet<usize>, faults: &mut Faults) -> Option<usize> {
        let found = self.parameters.iter().position(|parameter| parameter.name.value == name);
        used.extend(found);
        if found.is_none() {
            let allowed = self.parameters.iter().map(|parameter| parameter.name.value.as_str());
            let help = || suggestion(name, "parameter", allowed);
            faults.push_with(item, format!("there is no parameter `{name}` here"), help);
        }
        found
    }
}
