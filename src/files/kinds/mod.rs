//! Kinds of behavior as data: declared in files, bound to robot and world for each node. `move`, `pick` and `place` are
//! declared like any other, in `config/behaviors/paper.yaml`.

mod bind;
mod claims;
mod commands;
mod declare;
mod shape;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

pub(super) use bind::{Binder, Site};
pub(super) use shape::{BEHAVIOR, MAX_RETRIES};

use super::fault::Faults;
use super::parameter::{Argument, Parameter};
use super::reader::{Item, Name};
use ambidex_model::{Mode, PlaceId, Pose, TypeId};

/// Every kind that the files declare, by name.
#[derive(Debug, Default)]
pub(super) struct Kinds {
    by_name: BTreeMap<String, Declared>,
    /// Kinds whose faults are told.
    broken: BTreeSet<String>,
}

/// A kind whose terms are known to make sense.
#[derive(Debug)]
pub(super) struct Declared {
    pub(super) name: Name,
    pub(super) parameters: Vec<Parameter>,
    label: Option<Text>,
    claims: Claims,
    potential: PotentialTerm,
    goal: Option<Vec<ConditionTerm>>,
    precondition: Vec<ConditionTerm>,
    effects: Vec<Effect>,
    commands: Vec<Command>,
    takes: Duration,
    timeout: Duration,
    retries: u32,
}

/// A name, or the argument that stands for it.
#[derive(Debug, Clone)]
struct Slot {
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
    Some(Vec<ClaimTerm>),
}

#[derive(Debug)]
struct ClaimTerm {
    name: Name,
    whom: Whom,
    filter: Filter,
    shared: Option<Text>,
    keep: KeepTerm,
    is_optional: bool,
}

#[derive(Debug)]
enum Whom {
    Type(Slot),
    Resource(Slot),
}

#[derive(Debug)]
enum Filter {
    Any,
    Empty,
    Reaches(Slot),
    Holds(Slot),
}

#[derive(Debug)]
enum KeepTerm {
    Release,
    Physical,
    For(Text),
}

#[derive(Debug)]
struct PotentialTerm {
    base: Base,
    scale_by: Option<Slot>,
}

#[derive(Debug)]
enum Base {
    Constant(f64),
    /// The number that an argument tells.
    Parameter(usize),
    High,
    Nearness(Stand),
    Table {
        by: usize,
        values: BTreeMap<String, f64>,
        otherwise: f64,
    },
}

#[derive(Debug)]
struct Stand {
    place: Slot,
    offset: Offset,
}

#[derive(Debug)]
enum Offset {
    /// Where the move before went, if it went to this place; else the place's own stand.
    None,
    By([f64; 2]),
    Parameter(usize),
}

#[derive(Debug)]
enum ConditionTerm {
    At(Stand),
    Path(Stand),
    Held(Slot),
    Free(Slot),
    Lies(Slot, Slot),
    Fact(Text, bool),
}

#[derive(Debug)]
enum Effect {
    Taken(Slot, usize),
    Lies(Slot, Slot),
    Fact(Text, bool),
}

#[derive(Debug)]
struct Command {
    spot: super::document::Spot,
    claim: usize,
    mode: Mode,
    task: TaskTerm,
}

#[derive(Debug)]
enum TaskTerm {
    Stand,
    Drive(Stand),
    Grasp(Slot),
    Put(Slot, Slot),
    Look(Slot),
}

/// A stand of a place, map frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stop {
    pub(super) place: PlaceId,
    pub(super) stand: Pose,
}

impl Kinds {
    /// Adds what stands under `behaviors`.
    pub(super) fn declare(&mut self, behaviors: Option<Item<'_>>, reserved: &[&str], faults: &mut Faults) {
        let Some(entries) = behaviors.and_then(|item| item.named("a map of behaviors", faults)) else {
            return;
        };
        for (name, item) in entries {
            if self.by_name.contains_key(&name.value) || reserved.contains(&name.value.as_str()) {
                let message = format!("there is a `{}` already", name.value);
                let help = "`move`, `pick` and `place` are always there; every other name is yours, once".to_owned();
                faults.push(name.spot, &name.key, message, Some(help));
                continue;
            }
            match Declared::read(name.clone(), item, faults) {
                Some(declared) => drop(self.by_name.insert(name.value, declared)),
                None => drop(self.broken.insert(name.value)),
            }
        }
    }

    /// The kind of a name.
    pub(super) fn get(&self, name: &str) -> Option<&Declared> {
        self.by_name.get(name)
    }

    /// Whether a kind of that name has faults of its own.
    pub(super) fn is_broken(&self, name: &str) -> bool {
        self.broken.contains(name)
    }

    /// All names in order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }
}

impl Declared {
    /// What a node of it is called if it has no name of its own.
    pub(super) fn label(&self, arguments: &[Option<Argument>]) -> String {
        match &self.label {
            Some(label) => label.filled_or(arguments, &self.parameters),
            None => {
                let first = arguments.first().and_then(Option::as_ref).map(|argument| argument.text.as_str());
                [Some(self.name.value.as_str()), first].into_iter().flatten().collect::<Vec<_>>().join(" ")
            }
        }
    }

    /// Where a node of it drives to; none where it does not, or where nothing tells the place.
    pub(super) fn stop(&self, arguments: &[Option<Argument>], stands: &[Pose]) -> Option<Stop> {
        let drive = self.commands.iter().find_map(|command| match &command.task {
            TaskTerm::Drive(stand) => Some(stand),
            TaskTerm::Stand | TaskTerm::Grasp(_) | TaskTerm::Put(..) | TaskTerm::Look(_) => None,
        })?;
        let place = arguments.get(drive.place.parameter?)?.as_ref()?.value.place()?;
        let mut stand = *stands.get(place.index())?;
        stand.at += nalgebra::Vector2::from(drive.offset.of(arguments).unwrap_or_default());
        Some(Stop { place, stand })
    }

    /// Types that its claims name, as far as they are told.
    pub(super) fn types(&self, arguments: &[Option<Argument>], find: impl Fn(&str) -> Option<TypeId>) -> Vec<TypeId> {
        let Claims::Some(claims) = &self.claims else {
            return Vec::new();
        };
        let types = claims.iter().filter_map(|claim| match &claim.whom {
            Whom::Resource(_) => None,
            Whom::Type(slot) => match slot.parameter {
                None => find(&slot.written.value),
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

impl Offset {
    /// The offset in metres; none where none is written.
    fn of(&self, arguments: &[Option<Argument>]) -> Option<[f64; 2]> {
        match self {
            Self::None => None,
            Self::By(offset) => Some(*offset),
            Self::Parameter(index) => arguments[*index].as_ref()?.value.offset(),
        }
    }
}
