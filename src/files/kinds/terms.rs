//! The terms of a declared behavior: what they look like in a file, and what they are read as.

use super::hands::{GRASPED, Grasped, HELD, HeldTerm, ObjectBy, PutTerm};
use super::named::{CLAIMED, NameOf, OBJECT, PLACE, TEMPLATE};
use super::{Claims, NameOrParam, Text};
use crate::describe::{At, Custom, Described, Each, Flag, Map, Reads, Vector, Word, described};
use crate::document::Node;
use crate::fault::Faults;
use crate::quantity::{NEAR, POTENTIAL};
use crate::reader::{Item, Name, Written};
use crate::scope::Reading;
use crate::shape::Form;
use crate::template;
use crate::types::Type;
use ambidex_model::{Mode, split_argument};

const HIGH: [&str; 1] = ["high"];
const PHYSICAL: [&str; 1] = ["physical"];
const STANDING: [&str; 1] = ["stand"];
const ALL: [&str; 1] = ["all"];

described! {
    /// An entry of `claims`.
    pub(super) struct ClaimTerm: "a claim", "A resource that the behavior needs." {
        target: ClaimTarget = one(ClaimTarget),
        empty: Option<bool> = optional("empty", "Only one that holds no object.", Flag),
        reaches: Option<NameOrParam> = optional("reaches", "Only an empty one that reaches this object.", OBJECT),
        holds: Option<NameOrParam> = optional("holds", "Only the one that holds this object.", OBJECT),
        shared: Option<Text> = optional(
            "shared",
            "Together with all that use it for the same, such as `at $to`; alone if left out.",
            TEMPLATE
        ),
        keep: KeepTerm = or(
            "keep",
            "What becomes of it on success: `physical` (as a gripper that holds something), or `for` an intention; given \
             back if left out.",
            KEPT,
            KeepTerm::Release
        ),
        is_optional: bool = or("optional", "Left out for a robot that has none.", Flag, false),
    }
}

described! {
    /// What a claim is a claim on.
    pub(super) enum ClaimTarget: "a claim", "What it is a claim on." {
        Type(NameOrParam) = ("type", "Any resource of this type.", NameOf(Type::Kind)),
        Resource(NameOrParam) = ("resource", "This resource.", NameOf(Type::Resource)),
    }
}

/// Which of the resources that a claim is on will do.
pub(super) enum Filter<'a> {
    Any,
    Empty,
    Reaches(&'a NameOrParam),
    Holds(&'a NameOrParam),
}

/// What becomes of a claimed resource on success.
#[derive(Debug)]
pub(super) enum KeepTerm {
    Release,
    Physical,
    For(Text),
}

described! {
    /// `keep` as a map.
    struct Kept: "a keep", "Kept for what comes next in the THEN, which may use it." {
        intention: Text =
            required("for", "The intention, such as `at $to`; others of the same can join.", TEMPLATE),
    }
}

described! {
    /// `potential`, as a map or as a constant alone.
    pub(super) struct PotentialTerm: "a potential", "An activation potential." {
        base: Base = one(Base),
        scale_by: Option<NameOrParam> =
            optional("scale_by", "Times the free resources of this type.", NameOf(Type::Kind)),
    }
}

described! {
    /// What a potential is before it is scaled.
    pub(super) enum Base: "a potential", "What it is before it is scaled." {
        Constant(Constant) = ("constant", "Always the same.", CONSTANT),
        Nearness(Stand) = (
            "nearness",
            "One over the distance of the base to there, in meters (equation 1).",
            STAND
        ),
        Table(Table) = ("table", "A number for each argument.", Map::<Table>::new()),
    }
}

/// A potential that does not depend on the world.
#[derive(Debug)]
pub(super) enum Constant {
    Value(f64),
    /// The number that an argument tells, by parameter.
    Told(usize),
    /// Above all that nearness reaches.
    High,
}

described! {
    /// `table` of a potential.
    pub(super) struct Table: "a table", "A number for each argument of one parameter." {
        by: usize = required("by", "The parameter, such as `$object`.", BY),
        values: Vec<(Name, Option<f64>)> = required(
            "values",
            "The potential for each argument.",
            Each("a map from arguments to numbers", &POTENTIAL)
        ),
        otherwise: f64 = required("otherwise", "The potential for any other argument.", &POTENTIAL),
    }
}

described! {
    /// A place, or a place with an offset of its stand.
    pub(super) struct Stand: "a stand", "Where the robot stands at a place." {
        place: NameOrParam = required("place", "The place.", PLACE),
        offset: Option<Offset> = optional("offset", "From the stand of the place.", OFFSET),
    }
}

/// An offset of a stand, meters in the axes of the map.
#[derive(Debug)]
pub(super) enum Offset {
    By([f64; 2]),
    /// What an argument tells, by parameter.
    Told(usize),
}

described! {
    /// An entry of `goal` or `precondition`.
    pub(super) enum ConditionTerm: "a condition", "Something that is so or not." {
        At(Stand) = ("at", "The base is at rest at the stand of this place.", STAND),
        Path(Stand) = ("path", "A free path leads to the stand of this place.", STAND),
        Held(HeldTerm) = ("held", "The object is in a gripper of this task, or in so many.", HELD),
        Free(NameOrParam) = ("free", "Nothing holds the object.", OBJECT),
        Lies(ObjectAt) = ("lies", "The object lies at the place.", Map::<ObjectAt>::new()),
        Fact(Text) = ("fact", "The fact holds.", TEMPLATE),
        NotFact(Text) = ("not_fact", "The fact does not hold.", TEMPLATE),
    }
}

described! {
    /// An object and a place.
    pub(super) struct ObjectAt: "an object at a place", "An object and a place." {
        object: NameOrParam = required("object", "The object.", OBJECT),
        place: NameOrParam = required("at", "The place.", PLACE),
    }
}

described! {
    /// An entry of `effects`.
    pub(super) enum Effect: "an effect", "Something that is so when the behavior succeeded." {
        Taken(Written<ObjectBy>) =
            ("taken", "The resource of a claim holds the object too.", At(Map::<ObjectBy>::new())),
        LetGo(Written<ObjectBy>) = (
            "let_go",
            "The resource of a claim holds the object no more; something else does.",
            At(Map::<ObjectBy>::new())
        ),
        Lies(Written<ObjectAt>) = (
            "lies",
            "The object lies at the place, and nothing holds it.",
            At(Map::<ObjectAt>::new())
        ),
        Set(Text) = ("set", "The fact holds.", TEMPLATE),
        Clear(Text) = ("clear", "The fact does not hold.", TEMPLATE),
    }
}

described! {
    /// An entry of `commands`.
    pub(super) struct Command: "a command", "What the controller of a claimed resource does." {
        claim: usize = required("claim", "The name of the claim.", CLAIMED),
        order: Order = one(Order),
    }
}

described! {
    /// What a controller is told.
    pub(super) enum Order: "a command", "What a controller is told." {
        Achieve(Written<TaskTerm>) = (
            "achieve",
            "To be reached; the behavior ends when all are.",
            At(TO_DO)
        ),
        Maintain(Written<TaskTerm>) = (
            "maintain",
            "To last as long as the behavior, together with all others that want the same.",
            At(TO_MAINTAIN)
        ),
    }
}

/// What a controller does; none is to keep still.
pub(super) type TaskTerm = Option<Doing>;

described! {
    /// What a controller does and is told with a map.
    pub(super) struct Doing: "a task of a controller",
    "What a controller does; `stand` alone is to keep still." {
        action: Action = one(Action),
        with: Vec<(Name, Option<CallValue>)> = maybe_all(
            WITH,
            "With `call`: a value for each parameter that the robot file gives it.",
            Each("a map of arguments", CALL_VALUE)
        ),
    }
}

/// The key of the arguments of a call.
pub(super) const WITH: &str = "with";

/// What a parameter of a call is told.
#[derive(Debug)]
pub(super) enum CallValue {
    /// What a parameter of the behavior stands for.
    Told(usize, Name),
    /// A text with arguments in it.
    Made(Text),
    /// What is written there.
    Written(Node),
}

described! {
    /// What a controller does.
    pub(super) enum Action: "a task of a controller", "What a controller does." {
        DriveTo(Stand) = ("drive_to", "Base: to the stand of a place.", STAND),
        Grasp(Written<Grasped>) = (
            "grasp",
            "Arm: take the object where it lies, or `from` what holds it.",
            At(GRASPED)
        ),
        Put(Written<PutTerm>) = (
            "put",
            "Arm: set the object down `at` a place, or let it go `into` another hand or a slot.",
            At(Map::<PutTerm>::new())
        ),
        LookAt(NameOrParam) = ("look_at", "Head or camera: look at the surface of the place.", PLACE),
        Call(Name) = ("call", "Any: what its robot file says that it offers.", Word("the name of a call")),
    }
}

impl ClaimTerm {
    /// Which of the resources will do.
    pub(super) fn filter(&self) -> Filter<'_> {
        match (&self.holds, &self.reaches, self.empty) {
            (Some(object), ..) => Filter::Holds(object),
            (None, Some(object), _) => Filter::Reaches(object),
            (None, None, Some(true)) => Filter::Empty,
            (None, None, Some(false) | None) => Filter::Any,
        }
    }

    /// What is legal key by key and makes no sense together.
    fn check(&self, faults: &mut Faults) {
        if let Some(NameOrParam { written, .. }) = &self.holds
            && (self.empty.is_some() || self.reaches.is_some())
        {
            faults.push(written, "what holds an object is not empty");
        }
        if let (Some(shared), KeepTerm::For(kept)) = (&self.shared, &self.keep)
            && shared.written.value != kept.written.value
        {
            faults.push(&kept.written, format!("used for `{}`, it cannot be kept for another", shared.written.value));
        }
    }
}

impl Order {
    /// How the controller's task ends.
    pub(super) fn mode(&self) -> Mode {
        match self {
            Self::Achieve(_) => Mode::Achieve,
            Self::Maintain(_) => Mode::Maintain,
        }
    }

    /// The task, with its key and place.
    pub(super) fn task(&self) -> &Written<TaskTerm> {
        let (Self::Achieve(task) | Self::Maintain(task)) = self;
        task
    }
}

/// `claims`: a map, or `all`.
pub(super) const CLAIMS: Custom<Claims> =
    Custom(|| Form::Either(vec![Form::Words(&ALL), Form::Each(Box::new(Form::Map(ClaimTerm::shape)))]), claims);

/// `potential`: a constant or a map.
pub(super) const POTENTIAL_TERM: Custom<PotentialTerm> = Custom(
    || Form::Either(vec![CONSTANT.form(), Form::Map(PotentialTerm::shape)]),
    |item, reading| {
        if item.is_map() {
            return PotentialTerm::read(item, reading);
        }
        Some(PotentialTerm { base: Base::Constant(CONSTANT.read(item, reading)?), scale_by: None })
    },
);

/// A word or a map.
const KEPT: Custom<KeepTerm> = Custom(
    || Form::Either(vec![Form::Words(&PHYSICAL), Form::Map(Kept::shape)]),
    |item, reading| {
        if item.is_map() {
            return Kept::read(item, reading).map(|kept| KeepTerm::For(kept.intention));
        }
        let word = item.word(&PHYSICAL, "`physical`, or `for` an intention", reading.faults);
        word.map(|_| KeepTerm::Physical)
    },
);

/// A number, `high`, or a parameter that stands for a number.
const CONSTANT: Custom<Constant> = Custom(
    || Form::Either(vec![Form::Quantity(&POTENTIAL), Form::Words(&HIGH), Form::Word]),
    |item, reading| match item.text() {
        Some(text) if HIGH.contains(&text) => Some(Constant::High),
        Some(text) if template::parameter(text).is_some() => {
            NameOf(Type::Number).read(item, reading)?.parameter.map(Constant::Told)
        }
        Some(_) | None => item.quantity(&POTENTIAL, reading.faults).map(Constant::Value),
    },
);

/// A parameter by whose argument a table is read.
const BY: Custom<usize> = Custom(
    || Form::Word,
    |item, reading| {
        const WHAT: &str = "a parameter such as `$object`";
        let written = item.name(WHAT, reading.faults)?;
        if let Some(name) = template::parameter(&written.value) {
            let found = reading.parameter(name, &written)?;
            if reading.scope.parameters[found].1 != Type::Offset {
                return Some(found);
            }
            reading
                .faults
                .push(&written, format!("`{}` is {}, and a table is by a name", written.value, Type::Offset.what()));
            return None;
        }
        reading.faults.push(&written, format!("found `{}` instead of {WHAT}", written.value));
        None
    },
);

/// A place alone or with an offset.
const STAND: Custom<Stand> = Custom(
    || Form::Either(vec![Form::Word, Form::Map(Stand::shape)]),
    |item, reading| {
        if item.is_map() {
            return Stand::read(item, reading);
        }
        Some(Stand { place: PLACE.read(item, reading)?, offset: None })
    },
);

/// Two lengths, or a parameter that stands for them.
const OFFSET: Custom<Offset> = Custom(
    || Form::Either(vec![Form::Word, Vector::<2>(&NEAR).form()]),
    |item, reading| {
        if !item.is_scalar() {
            return Vector::<2>(&NEAR).read(item, reading).map(Offset::By);
        }
        let told = NameOf(Type::Offset).read(item, reading)?.parameter;
        if told.is_none() {
            item.wrong(Type::Offset.what(), reading.faults);
        }
        told.map(Offset::Told)
    },
);

/// What a controller does: a word or a map.
const TO_DO: Custom<TaskTerm> = Custom(
    || Form::Either(vec![Form::Words(&STANDING), Form::Map(Doing::shape)]),
    |item, reading| {
        if item.is_map() {
            let doing = Doing::read(item, reading)?;
            if let (Some(with), false) = (item.value_of(WITH), matches!(doing.action, Action::Call(_))) {
                reading.faults.push(&with, "arguments are for a `call`");
            }
            return Some(Some(doing));
        }
        item.word(&STANDING, "`stand`, or a map", reading.faults).map(|_| None)
    },
);

/// The same as long as it lasts, which it cannot if it ends by itself.
const TO_MAINTAIN: Custom<TaskTerm> = Custom(
    || TO_DO.form(),
    |item, reading| {
        let task = TO_DO.read(item, reading)?;
        if !matches!(task, None | Some(Doing { action: Action::LookAt(_) | Action::Call(_), .. })) {
            reading.faults.push_with(&item, "what ends by itself cannot be maintained", "write `achieve`");
        }
        Some(task)
    },
);

/// A value of any type, which the call knows.
const CALL_VALUE: Custom<CallValue> = Custom(
    || Form::Arguments,
    |item, reading| match item.text() {
        Some(text) if template::parameter(text).is_some() => {
            let written = item.name("a parameter", reading.faults)?;
            let index = reading.parameter(template::parameter(text)?, &written)?;
            Some(CallValue::Told(index, written))
        }
        Some(text) if split_argument(text).is_some() => TEMPLATE.read(item, reading).map(CallValue::Made),
        Some(_) | None => Some(CallValue::Written(item.node())),
    },
);

fn claims(item: Item<'_>, reading: &mut Reading<'_>) -> Option<Claims> {
    const WHAT: &str = "a map of claims, or `all`";
    if item.is_scalar() {
        return item.word(&ALL, WHAT, reading.faults).map(|_| Claims::All);
    }
    let entries = item.named(WHAT, reading.faults)?;
    reading.scope.claims = entries.iter().map(|(name, _)| name.clone()).collect();
    let mut claims = Vec::new();
    for (name, item) in entries {
        let term = ClaimTerm::read(item, reading);
        if let Some(term) = &term {
            term.check(reading.faults);
        }
        claims.push(term.map(|term| (name, term)));
    }
    claims.into_iter().collect::<Option<_>>().map(Claims::Some)
}
