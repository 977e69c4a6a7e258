//! Parameters of declared behaviors and subtrees, and the arguments they get.

use std::collections::BTreeSet;

use crate::describe::{Custom, Described, Each, Later, Reads, described};
use crate::document::{Node, SourceSpan, Value};
use crate::fault::Faults;
use crate::names::Register;
use crate::quantity::{NEAR, POTENTIAL};
use crate::reader::{Item, Name};
use crate::shape::Form;
use crate::text::scalar;
use crate::types::Type;
use crate::world::WorldNames;
use ambidex_model::{Names, ObjectId, PlaceId, ResourceId, TypeId, suggestion};

described! {
    /// A parameter with all that can be said of it.
    struct Full<'a>: "a parameter", "What an argument is, and what it is when none is given." {
        ty: Type = required("type", "What it stands for.", TYPE),
        default: Option<Item<'a>> = optional(
            DEFAULT,
            "Its value when none is given, or several, of which the first that is there counts: `$before` is where the \
             `move` before it in its THEN goes, `$start` is where its object is at the start.",
            Later(|| Form::Arguments)
        ),
    }
}

/// The key of the default of a parameter.
pub(crate) const DEFAULT: &str = "default";
/// The default that is where the `move` before goes.
pub(crate) const BEFORE: &str = "$before";
/// The default that is where the object is at the start.
pub(crate) const START: &str = "$start";

/// A parameter of a behavior, a subtree or a call.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) name: Name,
    pub(crate) ty: Type,
    /// What is tried in turn when no argument is given; none where one must be.
    pub(crate) defaults: Option<Vec<Node>>,
}

/// An argument looked up.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Argument {
    /// As written, for names made of it.
    pub(crate) text: String,
    pub(crate) value: Meaning,
}

/// What an argument means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Meaning {
    Object(ObjectId),
    Place(PlaceId),
    /// The place where the object lies.
    PlaceOf(ObjectId),
    Resource(ResourceId),
    Kind(TypeId),
    Number(f64),
    /// Meters, in the axes of the map.
    Offset([f64; 2]),
    Text,
}

/// Everything that arguments can name; a part that could not be read has no names, and nothing is said of it again.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known<'a> {
    pub(crate) world: Option<&'a WorldNames>,
    pub(crate) robot: Option<&'a RobotNames>,
}

/// The names of a robot's parts.
#[derive(Debug, Clone)]
pub(crate) struct RobotNames {
    pub(crate) resources: Register,
    pub(crate) types: Register,
}

impl RobotNames {
    /// Those of a robot file.
    pub(crate) fn of(robot: &Names) -> Self {
        let register = |what, names: &[String]| Register::of(what, names.iter().map(String::as_str));
        Self { resources: register("resource", &robot.resources), types: register("type of resource", &robot.types) }
    }
}

macro_rules! meanings {
    ($($name:ident, $variant:ident, $of:ty;)+) => {
        impl Meaning {$(
            #[doc = concat!("What it means, if it is a ", stringify!($name), ".")]
            pub(crate) fn $name(self) -> Option<$of> {
                if let Self::$variant(value) = self { Some(value) } else { None }
            }
        )+}
    };
}

meanings! {
    object, Object, ObjectId;
    place, Place, PlaceId;
    followed, PlaceOf, ObjectId;
    resource, Resource, ResourceId;
    ty, Kind, TypeId;
    number, Number, f64;
    offset, Offset, [f64; 2];
}

impl Known<'_> {
    /// What an argument of a type can name; none where it names nothing, or nobody knows.
    pub(crate) fn names(&self, ty: Type) -> Option<&Register> {
        match ty {
            Type::Object => self.world.map(|names| &names.objects),
            Type::Place => self.world.map(|names| &names.places),
            Type::Resource => self.robot.map(|names| &names.resources),
            Type::Kind => self.robot.map(|names| &names.types),
            Type::Number | Type::Offset | Type::Text => None,
        }
    }

    /// What an argument of a type means; a fault if it means nothing.
    pub(crate) fn argument(&self, item: Item<'_>, ty: Type, faults: &mut Faults) -> Option<Argument> {
        let value = match ty {
            Type::Number => Meaning::Number(item.quantity(&POTENTIAL, faults)?),
            Type::Offset => {
                let offset = item.vector(2..=2, &NEAR, faults)?;
                Meaning::Offset([offset[0], offset[1]])
            }
            Type::Place => {
                let name = item.name(ty.what(), faults)?;
                let is_place = self.world.is_some_and(|names| names.places.id(&name.value).is_some());
                let object = self.world.and_then(|names| names.objects.id(&name.value)).filter(|_| !is_place);
                match object {
                    Some(object) => Meaning::PlaceOf(object.into()),
                    None => self.named(&name, ty, faults)?,
                }
            }
            Type::Object | Type::Resource | Type::Kind | Type::Text => {
                self.named(&item.name(ty.what(), faults)?, ty, faults)?
            }
        };
        Some(Argument { text: item.text().unwrap_or_default().to_owned(), value })
    }

    /// Warns of a default that names nothing here.
    pub(crate) fn warn_of_default(&self, parameter: &Parameter, faults: &mut Faults) {
        let Some((name, names)) = parameter.plain_default().zip(self.names(parameter.ty)) else { return };
        // An object stands for the place where it lies.
        let is_object = || self.names(Type::Object).is_some_and(|objects| objects.id(name).is_some());
        if names.id(name).is_none() && !(parameter.ty == Type::Place && is_object()) {
            let span = parameter.defaults.iter().flatten().next().map_or(parameter.name.span, |default| default.span);
            faults.warn((span, DEFAULT), names.lacks(name), Some(names.suggestion(name)));
        }
    }

    /// What a name of a type stands for; a fault if nothing has it.
    pub(crate) fn named(&self, name: &Name, ty: Type, faults: &mut Faults) -> Option<Meaning> {
        if matches!(ty, Type::Text | Type::Number | Type::Offset) {
            return Some(Meaning::Text);
        }
        let found = self.names(ty)?.find(name, faults)?;
        Some(match ty {
            Type::Object => Meaning::Object(found.into()),
            Type::Place => Meaning::Place(found.into()),
            Type::Resource => Meaning::Resource(found.into()),
            Type::Kind => Meaning::Kind(found.into()),
            Type::Text | Type::Number | Type::Offset => Meaning::Text,
        })
    }
}

impl Parameter {
    /// Its default, where that is a word and nothing that is found out later.
    pub(crate) fn plain_default(&self) -> Option<&str> {
        let first = Item::of(&self.name.value, self.defaults.as_ref()?.first()?).text();
        first.filter(|text| !text.starts_with('$'))
    }
}

/// `parameters`: a type, or a type with a default, by name.
pub(crate) const PARAMETERS: Custom<Vec<Parameter>> = Custom(
    || Form::Each(Box::new(ENTRY.form())),
    |item, reading| {
        let read = Each("a map of parameters", ENTRY).read(item, reading)?;
        let known = read.into_iter().filter_map(|(name, found)| {
            let (ty, defaults) = found?;
            Some(Parameter { name, ty, defaults })
        });
        Some(known.collect())
    },
);

const ENTRY: Custom<(Type, Option<Vec<Node>>)> = Custom(
    || Form::Either(vec![TYPE.form(), Form::Map(Full::shape)]),
    |item, reading| {
        if !item.is_map() {
            return Some((TYPE.read(item, reading)?, None));
        }
        let Full { ty, default } = Full::read(item, reading)?;
        let defaults = default.map(|item| match item.node() {
            // A list is several values, except where the value itself is a list.
            Node { value: Value::List(list), .. } if ty != Type::Offset => list,
            node => vec![node],
        });
        for default in defaults.iter().flatten() {
            check_default(ty, Item::of(DEFAULT, default), reading.faults);
        }
        Some((ty, defaults))
    },
);

const TYPE: Custom<Type> = Custom(
    || Form::Words(&Type::WORDS),
    |item, reading| {
        let word = item.word(&Type::WORDS, "a type of parameter", reading.faults)?;
        Type::ALL.into_iter().find(|ty| ty.word() == word)
    },
);

/// Whether a value looks like one of this type; whether a name exists is seen where it is used.
fn check_form(ty: Type, item: Item<'_>, faults: &mut Faults) {
    match ty {
        Type::Number => drop(item.quantity(&POTENTIAL, faults)),
        Type::Offset => drop(item.vector(2..=2, &NEAR, faults)),
        Type::Object | Type::Place | Type::Resource | Type::Kind | Type::Text => drop(item.name(ty.what(), faults)),
    }
}

/// What starts with a dollar is no argument yet, and is found out for places alone.
fn check_default(ty: Type, item: Item<'_>, faults: &mut Faults) {
    match item.text().filter(|text| text.starts_with('$')) {
        Some(BEFORE | START) if ty == Type::Place => {}
        Some(text) => {
            let message = format!("`{text}` cannot be the default of {}", ty.what());
            faults.push_with(&item, message, "write a value; that of a place may be `$before` or `$start`");
        }
        None => check_form(ty, item, faults),
    }
}

/// Where a subtree or a mission is used nothing is known of a THEN around it: its defaults are values, and one each.
pub(crate) fn refuse_open_defaults<'p>(
    what: &str,
    parameters: impl Iterator<Item = &'p Parameter>,
    faults: &mut Faults,
) {
    for parameter in parameters {
        let defaults = parameter.defaults.as_deref().unwrap_or_default();
        let open = defaults.iter().enumerate().find(|(index, default)| {
            let text = Item::of(&parameter.name.value, default).text();
            *index > 0 || text.is_some_and(|text| text.starts_with('$'))
        });
        if let Some((_, default)) = open {
            let message = format!("{what} has one plain value as a default");
            faults.push_with((default.span, DEFAULT), message, "several, `$before` and `$start` are for behaviors");
        }
    }
}

/// The value of each parameter as written; none where it is left to its default.
///
/// A value that is no map is that of the first parameter. `None` when one is unknown or lacking, which is a fault.
pub(crate) fn assign<'a>(
    what: &Name,
    parameters: &[Parameter],
    item: Item<'a>,
    span: SourceSpan,
    faults: &mut Faults,
) -> Option<Vec<Option<Item<'a>>>> {
    let before = faults.errors();
    let mut values = vec![None; parameters.len()];
    if item.is_map() {
        for (name, value) in item.named("a map of arguments", faults)? {
            match parameters.iter().position(|parameter| parameter.name.value == name.value) {
                Some(index) => values[index] = Some(value),
                None => unknown(what, parameters, &name, faults),
            }
        }
    } else if !item.is_nothing() {
        match values.first_mut() {
            Some(first) => *first = Some(item),
            None => item.wrong(&format!("nothing: `{}` has no parameters", what.value), faults),
        }
    }
    for (parameter, value) in parameters.iter().zip(&values) {
        if value.is_none() && parameter.defaults.is_none() {
            let (name, ty) = (&parameter.name.value, parameter.ty.what());
            let message = format!("`{}` lacks its parameter `{name}`, {ty}", what.value);
            faults.push_with((span, &what.value), message, format!("write `{}`", example(&what.value, parameters)));
        }
    }
    (faults.errors() == before).then_some(values)
}

/// Something to write another value in place of.
pub(crate) fn example_value(ty: Type) -> String {
    match ty {
        Type::Offset => "[0 m, 0 m]".to_owned(),
        Type::Number => "1".to_owned(),
        Type::Object | Type::Place | Type::Resource | Type::Kind | Type::Text => ty.word().to_uppercase(),
    }
}

/// How a node with its arguments is written: a value for all that has no default.
pub(crate) fn example(name: &str, parameters: &[Parameter]) -> String {
    let needed: Vec<_> = parameters.iter().filter(|parameter| parameter.defaults.is_none()).collect();
    let value = |parameter: &Parameter| example_value(parameter.ty);
    let arguments = needed.iter().map(|parameter| format!("{}: {}", parameter.name.value, value(parameter)));
    match needed.as_slice() {
        [] => scalar(name),
        [only] if only.name.value == parameters[0].name.value => format!("{{{}: {}}}", scalar(name), value(only)),
        _ => format!("{{{}: {{{}}}}}", scalar(name), arguments.collect::<Vec<_>>().join(", ")),
    }
}

fn unknown(what: &Name, parameters: &[Parameter], name: &Name, faults: &mut Faults) {
    let message = format!("`{}` has no parameter `{}`", what.value, name.value);
    let allowed = parameters.iter().map(|parameter| parameter.name.value.as_str());
    faults.push_with(name, message, || suggestion(&name.value, "parameter", allowed));
}

/// Warns of parameters that nothing uses, unless there were faults since `before`: one may be the use that is missed.
pub(crate) fn warn_of_unused(parameters: &[Parameter], used: &BTreeSet<usize>, before: usize, faults: &mut Faults) {
    if faults.errors() > before {
        return;
    }
    for (_, Parameter { name, .. }) in parameters.iter().enumerate().filter(|(index, _)| !used.contains(index)) {
        faults.warn(name, format!("parameter `{}` is not used", name.value), None);
    }
}
