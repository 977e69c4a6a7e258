//! The terms of a declared behavior: what they look like in a file, and what they are read as.

use super::scope::{Claimed, Parameter, Slot, Template, TermContext, constant_parameter};
use super::{Claims, NameOrParam, Text};
use crate::describe::{At, Context, Described, Describes, Each, Flag, Map, Reads, Vector, described};
use crate::parameter::Type;
use crate::quantity::{NEAR, POTENTIAL};
use crate::reader::{Item, Name, Written};
use crate::shape::Form;
use ambidex_model::Mode;

const PLACE: Slot = Slot(Type::Place);
const OBJECT: Slot = Slot(Type::Object);
const HIGH: [&str; 1] = ["high"];
const PHYSICAL: [&str; 1] = ["physical"];
const STANDING: [&str; 1] = ["stand"];
const ALL: [&str; 1] = ["all"];

described! {
    /// An entry of `claims`.
    pub(super) struct ClaimTerm in TermContext: "a claim", "A resource that the behavior needs." {
        target: ClaimTarget = one(ClaimTarget),
        empty: Option<bool> = optional("empty", "Only one that holds no object.", Flag),
        reaches: Option<NameOrParam> = optional("reaches", "Only an empty one that reaches this object.", OBJECT),
        holds: Option<NameOrParam> = optional("holds", "Only the one that holds this object.", OBJECT),
        shared: Option<Text> = optional(
            "shared",
            "Together with all that use it for the same, such as `at $to`; alone if left out.",
            Template
        ),
        keep: KeepTerm = or(
            "keep",
            "What becomes of it on success: `physical` (as a gripper that holds something), or `for` an intention; given \
             back if left out.",
            KeptForm,
            KeepTerm::Release
        ),
        is_optional: bool = or("optional", "Left out for a robot that has none.", Flag, false),
    }
}

described! {
    /// What a claim is a claim on.
    pub(super) choice ClaimTarget in TermContext {
        Type(NameOrParam) = ("type", "Any resource of this type.", Slot(Type::Kind)),
        Resource(NameOrParam) = ("resource", "This resource.", Slot(Type::Resource)),
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
    struct Kept in TermContext: "a keep", "Kept for what comes next in the THEN, which may use it." {
        intention: Text =
            required("for", "The intention, such as `at $to`; others of the same can join.", Template),
    }
}

described! {
    /// `potential`, as a map or as a constant alone.
    pub(super) struct PotentialTerm in TermContext: "a potential", "An activation potential." {
        base: Base = one(Base),
        scale_by: Option<NameOrParam> =
            optional("scale_by", "Times the free resources of this type.", Slot(Type::Kind)),
    }
}

described! {
    /// What a potential is before it is scaled.
    pub(super) choice Base in TermContext {
        Constant(Constant) = ("constant", "Always the same.", ConstantForm),
        Nearness(Stand) = (
            "nearness",
            "One over the distance of the base to there, in meters (equation 1).",
            StandForm
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
    pub(super) struct Table in TermContext: "a table", "A number for each argument of one parameter." {
        by: usize = required("by", "The parameter, such as `$object`.", Parameter("a parameter such as `$object`")),
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
    pub(super) struct Stand in TermContext: "a stand", "Where the robot stands at a place." {
        place: NameOrParam = required("place", "The place.", PLACE),
        offset: Option<Offset> = optional("offset", "From the stand of the place.", OffsetForm),
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
    pub(super) enum ConditionTerm in TermContext: "a condition", "Something that is so or not." {
        At(Stand) = ("at", "The base is at rest at the stand of this place.", StandForm),
        Path(Stand) = ("path", "A free path leads to the stand of this place.", StandForm),
        Held(NameOrParam) = ("held", "The object is in a gripper of this task.", OBJECT),
        Free(NameOrParam) = ("free", "The object is in no gripper.", OBJECT),
        Lies(ObjectAt) = ("lies", "The object lies at the place.", Map::<ObjectAt>::new()),
        Fact(Text) = ("fact", "The fact holds.", Template),
        NotFact(Text) = ("not_fact", "The fact does not hold.", Template),
    }
}

described! {
    /// An object and a place.
    pub(super) struct ObjectAt in TermContext: "an object at a place", "An object and a place." {
        object: NameOrParam = required("object", "The object.", OBJECT),
        place: NameOrParam = required("at", "The place.", PLACE),
    }
}

described! {
    /// An entry of `effects`.
    pub(super) enum Effect in TermContext: "an effect", "Something that is so when the behavior succeeded." {
        Taken(Taken) = (TAKEN, "The object is in the resource of a claim.", Map::<Taken>::new()),
        Lies(ObjectAt) = ("lies", "The object lies at the place.", Map::<ObjectAt>::new()),
        Set(Text) = ("set", "The fact holds.", Template),
        Clear(Text) = ("clear", "The fact does not hold.", Template),
    }
}

/// The key of the effect that an object is taken.
pub(super) const TAKEN: &str = "taken";

described! {
    /// `taken`.
    pub(super) struct Taken in TermContext: "a taken object", "An object and the claim whose resource holds it." {
        object: NameOrParam = required("object", "The object.", OBJECT),
        claim: usize = required("by", "The name of the claim.", Claimed),
    }
}

described! {
    /// An entry of `commands`.
    pub(super) struct Command in TermContext: "a command", "What the controller of a claimed resource does." {
        claim: usize = required("claim", "The name of the claim.", Claimed),
        order: Order = one(Order),
    }
}

described! {
    /// What a controller is told.
    pub(super) choice Order in TermContext {
        Achieve(Written<TaskTerm>) = (
            "achieve",
            "To be reached; the behavior ends when all are.",
            At(TaskForm { mode: Mode::Achieve })
        ),
        Maintain(Written<TaskTerm>) = (
            "maintain",
            "To last as long as the behavior, together with all others that want the same.",
            At(TaskForm { mode: Mode::Maintain })
        ),
    }
}

/// What a controller does.
#[derive(Debug)]
pub(super) enum TaskTerm {
    Stand,
    Act(Action),
}

described! {
    /// What a controller does and is told with a map.
    pub(super) enum Action in TermContext: "a task of a controller",
    "What a controller does; `stand` alone is to stand still." {
        DriveTo(Stand) = ("drive_to", "Base: to the stand of a place.", StandForm),
        Grasp(NameOrParam) = ("grasp", "Arm: take the object.", OBJECT),
        Put(ObjectAt) = ("put", "Arm: set the object down at the place.", Map::<ObjectAt>::new()),
        LookAt(NameOrParam) = ("look_at", "Head or camera: look at the surface of the place.", PLACE),
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
    fn check(&self, context: &mut impl Context) {
        if let Some(NameOrParam { written, .. }) = &self.holds
            && (self.empty.is_some() || self.reaches.is_some())
        {
            let message = "what holds an object is not empty".to_owned();
            context.faults().push(written.span, &written.key, message, None);
        }
        if let (Some(shared), KeepTerm::For(kept)) = (&self.shared, &self.keep)
            && shared.written.value != kept.written.value
        {
            let message = format!("used for `{}`, it cannot be kept for another", shared.written.value);
            context.faults().push(kept.written.span, &kept.written.key, message, None);
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

/// A value that can be written in several ways: what it looks like, and how it is read.
macro_rules! ways {
    ($($(#[$meta:meta])* $form:ident as $out:ty: $describes:expr, |$self:ident, $item:ident, $context:ident| $read:expr;)*) => {
        $(
            $(#[$meta])*
            impl Describes for $form {
                fn form(&self) -> Form {
                    $describes
                }
            }

            impl<'a, C: TermContext> Reads<'a, C> for $form {
                type Out = $out;

                fn read(&self, $item: Item<'a>, $context: &mut C) -> Option<$out> {
                    let $self = self;
                    $read
                }
            }
        )*
    };
}

/// `claims`: a map, or `all`.
pub(super) struct ClaimsForm;
/// `keep`: a word or a map.
struct KeptForm;
/// `potential`: a constant or a map.
pub(super) struct PotentialForm;
/// A number, `high`, or a parameter that stands for a number.
struct ConstantForm;
/// A place alone or with an offset.
struct StandForm;
/// Two lengths, or a parameter that stands for them.
struct OffsetForm;
/// What a controller does: a word or a map.
struct TaskForm {
    mode: Mode,
}

ways! {
    ClaimsForm as Claims: Form::Either(vec![Form::Words(&ALL), Form::Each(Box::new(Form::Map(ClaimTerm::shape)))]),
        |_form, item, context| claims(item, context);
    KeptForm as KeepTerm: Form::Either(vec![Form::Words(&PHYSICAL), Form::Map(Kept::shape)]), |_form, item, context| {
        if item.is_map() {
            return Map::<Kept>::new().read(item, context).map(|kept| KeepTerm::For(kept.intention));
        }
        let word = item.word(&PHYSICAL, "`physical`, or `for` an intention", context.faults());
        word.map(|_| KeepTerm::Physical)
    };
    PotentialForm as PotentialTerm: Form::Either(vec![ConstantForm.form(), Form::Map(PotentialTerm::shape)]),
        |_form, item, context| {
            if item.is_map() {
                return Map::<PotentialTerm>::new().read(item, context);
            }
            Some(PotentialTerm { base: Base::Constant(ConstantForm.read(item, context)?), scale_by: None })
        };
    ConstantForm as Constant: Form::Either(vec![Form::Quantity(&POTENTIAL), Form::Words(&HIGH), Form::Word]),
        |_form, item, context| {
            if item.text().is_some_and(|text| HIGH.contains(&text)) {
                return Some(Constant::High);
            }
            if constant_parameter(&item) {
                return Slot(Type::Number).read(item, context)?.parameter.map(Constant::Told);
            }
            item.quantity(&POTENTIAL, context.faults()).map(Constant::Value)
        };
    StandForm as Stand: Form::Either(vec![Form::Word, Form::Map(Stand::shape)]), |_form, item, context| {
        if item.is_map() {
            return Map::<Stand>::new().read(item, context);
        }
        Some(Stand { place: PLACE.read(item, context)?, offset: None })
    };
    OffsetForm as Offset: Form::Either(vec![Form::Word, Vector::<2>(&NEAR).form()]), |_form, item, context| {
        if !item.is_scalar() {
            return Vector::<2>(&NEAR).read(item, context).map(Offset::By);
        }
        let told = Slot(Type::Offset).read(item, context)?.parameter;
        if told.is_none() {
            item.wrong(Type::Offset.what(), context.faults());
        }
        told.map(Offset::Told)
    };
    TaskForm as TaskTerm: Form::Either(vec![Form::Words(&STANDING), Form::Map(Action::shape)]),
        |form, item, context| {
            if !item.is_map() {
                return item.word(&STANDING, "`stand`, or a map", context.faults()).map(|_| TaskTerm::Stand);
            }
            let action = Map::<Action>::new().read(item, context)?;
            let ends = !matches!(action, Action::LookAt(_));
            if form.mode == Mode::Maintain && ends {
                let message = "what ends by itself cannot be maintained".to_owned();
                context.faults().push(item.span, item.key, message, Some("write `achieve`".to_owned()));
            }
            Some(TaskTerm::Act(action))
        };
}

fn claims(item: Item<'_>, context: &mut impl TermContext) -> Option<Claims> {
    const WHAT: &str = "a map of claims, or `all`";
    if item.is_scalar() {
        return item.word(&ALL, WHAT, context.faults()).map(|_| Claims::All);
    }
    let entries = item.named(WHAT, context.faults())?;
    context.scope().claims = entries.iter().map(|(name, _)| name.clone()).collect();
    let mut claims = Vec::new();
    for (name, item) in entries {
        let term = Map::<ClaimTerm>::new().read(item, context);
        if let Some(term) = &term {
            term.check(context);
        }
        claims.push(term.map(|term| (name, term)));
    }
    claims.into_iter().collect::<Option<_>>().map(Claims::Some)
}
