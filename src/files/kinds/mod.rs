//! Kinds of behavior as data: declared in files, bound to robot and world for each node. `move`, `pick` and `place` are
//! declared like any other, in `config/behaviors/paper.yaml`.

mod bind;
mod calls;
mod claims;
mod commands;
mod declare;
mod hands;
mod holding;
mod named;
mod terms;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

pub(crate) use bind::{Binder, Site};
pub(crate) use declare::{BACKOFF_S, MAX_RETRIES, behavior_shape};

use crate::document::{Node, PAPER_FILE};
use crate::fault::Faults;
use crate::names::refuse_argument;
use crate::parameter::{Argument, Known, Parameter};
use crate::reader::{Item, Name};
use crate::types::Type;
use ambidex_model::{ObjectId, PlaceId, TypeId};
use terms::{
    Action, Base, ClaimTarget, ClaimTerm, Command, ConditionTerm, Doing, Effect, Offset, PotentialTerm, Stand, Table,
};

/// Every kind that the files declare, by name.
#[derive(Debug, Clone, Default)]
pub(crate) struct Kinds {
    by_name: BTreeMap<String, Arc<Declared>>,
    /// Kinds whose faults are told.
    broken: BTreeSet<String>,
    /// What no kind can be called.
    reserved: Vec<&'static str>,
    /// So many files were read before: what they declare may be declared again, if it is the same.
    known_files: usize,
}

/// Where a task declares what the world has already, otherwise.
pub(crate) const OF_THE_WORLD: &str =
    "the files of the world declare another one: choose another name, or write it as they do";

/// A kind whose terms are known to make sense.
#[derive(Debug)]
pub(crate) struct Declared {
    pub(crate) name: Name,
    written: Node,
    pub(crate) parameters: Vec<Parameter>,
    label: Option<Text>,
    claims: Claims,
    potential: PotentialTerm,
    goal: Option<Vec<ConditionTerm>>,
    precondition: Vec<ConditionTerm>,
    lasting: Vec<ConditionTerm>,
    interruptible: Option<bool>,
    effects: Vec<Effect>,
    commands: Vec<Command>,
    takes: Duration,
    timeout: Duration,
    retries: u32,
    backoff: Duration,
}

/// A name, or the argument that stands for it.
#[derive(Debug, Clone)]
struct NameOrParam {
    written: Name,
    parameter: Option<usize>,
}

/// Text made of arguments.
#[derive(Debug, Clone)]
struct Text {
    written: Name,
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone)]
enum Piece {
    Plain(String),
    Parameter(usize),
}

#[derive(Debug)]
enum Claims {
    All,
    Some(Vec<(Name, ClaimTerm)>),
}

/// Where the base stands at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stop {
    pub(crate) place: PlaceId,
    /// How far from one of its stands, map frame, meters; none where nothing tells.
    pub(crate) offset: Option<[f64; 2]>,
    /// The object whose place it is, wherever that lies; `place` is where it lies at the start.
    pub(crate) follows: Option<ObjectId>,
}

impl Kinds {
    /// None yet; some names mean something else.
    pub(crate) fn new(reserved: impl IntoIterator<Item = &'static str>) -> Self {
        Self { reserved: reserved.into_iter().collect(), ..Self::default() }
    }

    /// The same, to which those of further files are added.
    pub(crate) fn beside(&self, known_files: usize) -> Self {
        Self { known_files, ..self.clone() }
    }

    /// Adds what stands under `behaviors`.
    pub(crate) fn declare(&mut self, behaviors: Option<Item<'_>>, faults: &mut Faults) {
        let Some(entries) = behaviors.and_then(|item| item.named("a map of behaviors", faults)) else {
            return;
        };
        for (name, item) in entries {
            if self.reserved.contains(&name.value.as_str()) {
                let words: Vec<_> = self.reserved.iter().map(|word| format!("`{word}`")).collect();
                let help = format!("what a node of the task can say already: {}", words.join(", "));
                faults.push_with(&name, format!("a behavior cannot be called `{}`", name.value), help);
                continue;
            }
            let known = self.get(&name.value).filter(|kind| kind.name.span.file < self.known_files);
            if known.is_some_and(|kind| item.is_like(&kind.written)) {
                continue;
            }
            if self.by_name.contains_key(&name.value) || self.broken.contains(&name.value) {
                let message = format!("there is a behavior `{}` already", name.value);
                faults.push_with(&name, message, self.declared_twice(&name.value));
                continue;
            }
            refuse_argument(&name, faults);
            match Declared::read(name.clone(), item, faults) {
                Some(declared) => drop(self.by_name.insert(name.value, Arc::new(declared))),
                None => drop(self.broken.insert(name.value)),
            }
        }
    }

    /// Where the name was used first, as far as that can be told.
    fn declared_twice(&self, name: &str) -> &'static str {
        match self.get(name).map(|kind| kind.name.span.file) {
            Some(PAPER_FILE) => {
                "`move`, `pick` and `place` are those of the paper, and always there: choose another name"
            }
            Some(file) if file < self.known_files => OF_THE_WORLD,
            Some(_) | None => "each name is declared once in all the files of a mission: choose another name",
        }
    }

    /// Warns or refuses where a table of potentials speaks of what is not there, in files that were not read before.
    pub(crate) fn check_tables(&self, known: &Known<'_>, own_file: usize, faults: &mut Faults) {
        for kind in self.by_name.values().filter(|kind| kind.name.span.file >= self.known_files) {
            kind.check_table(known, own_file, faults);
        }
    }

    /// The kind of a name.
    pub(crate) fn get(&self, name: &str) -> Option<&Declared> {
        self.by_name.get(name).map(Arc::as_ref)
    }

    /// Whether a kind of that name has faults of its own.
    pub(crate) fn is_broken(&self, name: &str) -> bool {
        self.broken.contains(name)
    }

    /// All names in order.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }
}

impl Declared {
    /// Every key of a table is an argument that there can be. A library may speak of what only other missions have, and
    /// a robot may be exchanged: there it is a warning, if the key looks misspelt.
    fn check_table(&self, known: &Known<'_>, own_file: usize, faults: &mut Faults) {
        let Base::Table(Table { by, values, .. }) = &self.potential.base else { return };
        let ty = self.parameters[*by].ty;
        for (name, _) in values {
            let Some(names) = known.names(ty) else { continue };
            let is_ours = name.span.file == own_file;
            if is_ours && matches!(ty, Type::Object | Type::Place) {
                names.find(name, faults);
            } else if names.id(&name.value).is_none() {
                let meant = names.meant(&name.value).or_else(|| is_ours.then(|| names.suggestion(&name.value)));
                if meant.is_some() {
                    faults.warn(name, names.lacks(&name.value), meant);
                }
            }
        }
    }

    /// What a node of it is called if it has no name of its own.
    pub(crate) fn label(&self, arguments: &[Option<Argument>]) -> String {
        match &self.label {
            Some(label) => label.filled_or(arguments, &self.parameters),
            None => {
                let first = arguments.first().and_then(Option::as_ref).map(|argument| argument.text.as_str());
                [Some(self.name.value.as_str()), first].into_iter().flatten().collect::<Vec<_>>().join(" ")
            }
        }
    }

    /// Where a node of it drives to; none where it does not, or where nothing tells the place.
    pub(crate) fn stop(&self, arguments: &[Option<Argument>], starts: &[Option<PlaceId>]) -> Option<Stop> {
        let drive = self.commands.iter().find_map(|command| match &command.order.task().value {
            Some(Doing { action: Action::DriveTo(stand), .. }) => Some(stand),
            None | Some(_) => None,
        })?;
        let told = arguments.get(drive.place.parameter?)?.as_ref()?.value;
        let follows = told.followed();
        // What is held at the start lies nowhere: any place will do until it does.
        let start = || starts.get(follows?.index())?.or(Some(PlaceId(0)));
        Some(Stop { place: told.place().or_else(start)?, offset: drive.offset(arguments), follows })
    }

    /// Types that its claims name, as far as they are told.
    pub(crate) fn types(&self, arguments: &[Option<Argument>], find: impl Fn(&str) -> Option<TypeId>) -> Vec<TypeId> {
        let Claims::Some(claims) = &self.claims else {
            return Vec::new();
        };
        let types = claims.iter().filter_map(|(_, claim)| match &claim.target {
            ClaimTarget::Resource(_) => None,
            ClaimTarget::Type(name) => match name.parameter {
                None => find(&name.written.value),
                Some(index) => arguments.get(index)?.as_ref()?.value.ty(),
            },
        });
        types.collect()
    }
}

impl Text {
    /// The text with arguments in it; nothing for one that is left out.
    fn filled(&self, arguments: &[Option<Argument>]) -> String {
        self.filled_or(arguments, &[])
    }

    /// The same, with a default in place of an argument that is left out.
    fn filled_or(&self, arguments: &[Option<Argument>], parameters: &[Parameter]) -> String {
        let pieces = self.pieces.iter().map(|piece| match piece {
            Piece::Plain(text) => text.as_str(),
            Piece::Parameter(index) => {
                let given = arguments[*index].as_ref().map(|argument| argument.text.as_str());
                given.or_else(|| parameters.get(*index)?.plain_default()).unwrap_or("")
            }
        });
        pieces.collect()
    }
}

impl Stand {
    /// The offset in meters; none where none is written, which is where the `move` before went, if it went to this
    /// place, else the place's own stand.
    fn offset(&self, arguments: &[Option<Argument>]) -> Option<[f64; 2]> {
        match self.offset.as_ref()? {
            Offset::By(offset) => Some(*offset),
            Offset::Told(index) => arguments[*index].as_ref()?.value.offset(),
        }
    }
}
