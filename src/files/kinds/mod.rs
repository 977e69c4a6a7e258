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
use std::time::Duration;

pub(crate) use bind::{Binder, Site};
pub(crate) use declare::{BACKOFF_S, MAX_RETRIES, behavior_shape};

use crate::document::PAPER_FILE;
use crate::fault::Faults;
use crate::names::refuse_argument;
use crate::parameter::{Argument, Known, Parameter};
use crate::reader::{Item, Name};
use crate::types::Type;
use ambidex_model::{ObjectId, PlaceId, Pose, TypeId};
use terms::{
    Action, Base, ClaimTarget, ClaimTerm, Command, ConditionTerm, Doing, Effect, Offset, PotentialTerm, Stand, Table,
};

/// Every kind that the files declare, by name.
#[derive(Debug, Default)]
pub(crate) struct Kinds {
    by_name: BTreeMap<String, Declared>,
    /// Kinds whose faults are told.
    broken: BTreeSet<String>,
    /// What no kind can be called.
    reserved: Vec<&'static str>,
}

/// A kind whose terms are known to make sense.
#[derive(Debug)]
pub(crate) struct Declared {
    pub(crate) name: Name,
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

/// A stand of a place, map frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stop {
    pub(crate) place: PlaceId,
    pub(crate) stand: Pose,
    /// The object whose place it is, wherever that lies; `place` is where it lies at the start.
    pub(crate) follows: Option<ObjectId>,
}

impl Stop {
    /// The same at another place.
    pub(crate) fn moved_to(self, place: PlaceId, stands: &[Pose]) -> Self {
        let (from, to) = (stands[self.place.index()], stands[place.index()]);
        Self { place, stand: Pose { at: to.at + (self.stand.at - from.at), ..to }, ..self }
    }
}

impl Kinds {
    /// None yet; some names mean something else.
    pub(crate) fn new(reserved: impl IntoIterator<Item = &'static str>) -> Self {
        Self { reserved: reserved.into_iter().collect(), ..Self::default() }
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
            if self.by_name.contains_key(&name.value) || self.broken.contains(&name.value) {
                let message = format!("there is a behavior `{}` already", name.value);
                faults.push_with(&name, message, self.declared_twice(&name.value));
                continue;
            }
            refuse_argument(&name, faults);
            match Declared::read(name.clone(), item, faults) {
                Some(declared) => drop(self.by_name.insert(name.value, declared)),
                None => drop(self.broken.insert(name.value)),
            }
        }
    }

    /// Where the name was used first, as far as that can be told.
    fn declared_twice(&self, name: &str) -> &'static str {
        match self.get(name).is_some_and(|kind| kind.name.span.file == PAPER_FILE) {
            true => "`move`, `pick` and `place` are those of the paper, and always there: choose another name",
            false => "each name is declared once in all the files of a mission: choose another name",
        }
    }

    /// Warns or refuses where a table of potentials speaks of what is not there.
    pub(crate) fn check_tables(&self, known: &Known<'_>, own_file: usize, faults: &mut Faults) {
        for kind in self.by_name.values() {
            kind.check_table(known, own_file, faults);
        }
    }

    /// The kind of a name.
    pub(crate) fn get(&self, name: &str) -> Option<&Declared> {
        self.by_name.get(name)
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
    pub(crate) fn stop(
        &self,
        arguments: &[Option<Argument>],
        stands: &[Pose],
        starts: &[Option<PlaceId>],
    ) -> Option<Stop> {
        let drive = self.commands.iter().find_map(|command| match &command.order.task().value {
            Some(Doing { action: Action::DriveTo(stand), .. }) => Some(stand),
            None | Some(_) => None,
        })?;
        let told = arguments.get(drive.place.parameter?)?.as_ref()?.value;
        let follows = told.followed();
        // What is held at the start lies nowhere: any place will do until it does.
        let start = || starts.get(follows?.index())?.or(Some(PlaceId(0)));
        let place = told.place().or_else(start)?;
        let mut stand = *stands.get(place.index())?;
        stand.at += nalgebra::Vector2::from(drive.offset(arguments).unwrap_or_default());
        Some(Stop { place, stand, follows })
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
