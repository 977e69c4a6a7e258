//! What a declared behavior looks like in a file.

use super::super::parameter::PARAMETERS;
use super::super::quantity::{DURATION, NEAR, POTENTIAL, TIMEOUT};
use super::super::shape::{Form, Shape, optional, required};

/// Most retries.
pub(in super::super) const MAX_RETRIES: u32 = 1000;

const CONDITIONS: Form = Form::List(&Form::Map(&CONDITION));
/// A place, or a place with an offset of its stand.
const STAND: Form = Form::Either(&[Form::Word, Form::Map(&STAND_OF)]);

/// A number, `high`, or a parameter that stands for a number.
const CONSTANT: Form = Form::Either(&[Form::Quantity(&POTENTIAL), Form::Words(&["high"]), Form::Word]);

/// A declared behavior.
pub(in super::super) static BEHAVIOR: Shape = Shape::new(
    "a behavior",
    "A kind of behavior. `$name` stands for an argument.",
    &[
        optional("label", "What a node of it is called; without one the kind and its first argument.", Form::Word),
        optional("parameters", "What a node tells it; the first one can be written without its name.", PARAMETERS),
        optional(
            "claims",
            "The resources it needs, by names that its commands use; `all` is the whole robot.",
            Form::Either(&[Form::Words(&["all"]), Form::Each(&Form::Map(&CLAIM))]),
        ),
        required(
            "potential",
            "How efficient it looks to run it now: a number, one that a node tells (`$name`), `high` (above all that is \
             told by nearness), or more.",
            Form::Either(&[CONSTANT, Form::Map(&POTENTIAL_OF)]),
        ),
        optional("goal", "When it is done; without it only by running.", CONDITIONS),
        optional("precondition", "What must be so for it to run.", CONDITIONS),
        optional("effects", "What is so when it succeeded.", Form::List(&Form::Map(&EFFECT))),
        optional("commands", "Which controllers do what while it runs.", Form::List(&Form::Map(&COMMAND))),
        optional("takes", "How long it runs at least; 0 s.", Form::Quantity(&DURATION)),
        optional("timeout", "How long it may run; 2 min.", Form::Quantity(&TIMEOUT)),
        optional("retries", "How often it tries again after it failed; 2.", Form::Count(MAX_RETRIES)),
    ],
);

/// An entry of `claims`.
pub(super) static CLAIM: Shape = Shape::new(
    "a claim",
    "A resource that the behavior needs.",
    &[
        optional("type", "Any resource of this type.", Form::Word),
        optional("resource", "This resource.", Form::Word),
        optional("empty", "Only one that holds no object.", Form::Flag),
        optional("reaches", "Only an empty one that reaches this object.", Form::Word),
        optional("holds", "Only the one that holds this object.", Form::Word),
        optional("shared", "Together with all that use it for the same, such as `at $to`; alone if left out.", Form::Word),
        optional(
            "keep",
            "What becomes of it on success: `physical` (as a gripper that holds something), or `for` an intention; given \
             back if left out.",
            Form::Either(&[Form::Words(&["physical"]), Form::Map(&KEEP)]),
        ),
        optional("optional", "Left out for a robot that has none.", Form::Flag),
    ],
)
.with_one_of(&["type", "resource"]);

/// `keep: {for: …}`.
pub(super) static KEEP: Shape = Shape::new(
    "a keep",
    "Kept for what comes next in the THEN, which may use it.",
    &[required("for", "The intention, such as `at $to`; others of the same can join.", Form::Word)],
);

/// `potential` as a map.
pub(super) static POTENTIAL_OF: Shape = Shape::new(
    "a potential",
    "An activation potential.",
    &[
        optional("constant", "Always the same.", CONSTANT),
        optional("nearness", "One over the distance of the base to there, in metres (equation 1).", STAND),
        optional("table", "A number for each argument.", Form::Map(&TABLE)),
        optional("scale_by", "Times the free resources of this type.", Form::Word),
    ],
)
.with_one_of(&["constant", "nearness", "table"]);

/// `table` of a potential.
pub(super) static TABLE: Shape = Shape::new(
    "a table",
    "A number for each argument of one parameter.",
    &[
        required("by", "The parameter, such as `$object`.", Form::Word),
        required("values", "The potential for each argument.", Form::Each(&Form::Quantity(&POTENTIAL))),
        required("otherwise", "The potential for any other argument.", Form::Quantity(&POTENTIAL)),
    ],
);

/// A place with an offset of its stand.
pub(super) static STAND_OF: Shape = Shape::new(
    "a stand",
    "Where the robot stands at a place.",
    &[
        required("place", "The place.", Form::Word),
        optional("offset", "From the stand of the place.", Form::Either(&[Form::Word, Form::Vector(2, 2, &NEAR)])),
    ],
);

/// An entry of `goal` or `precondition`.
pub(super) static CONDITION: Shape = Shape::new(
    "a condition",
    "Something that is so or not.",
    &[
        optional("at", "The base is at rest at the stand of this place.", STAND),
        optional("path", "A free path leads to the stand of this place.", STAND),
        optional("held", "The object is in a gripper of this task.", Form::Word),
        optional("free", "The object is in no gripper.", Form::Word),
        optional("lies", "The object lies at the place.", Form::Map(&OBJECT_AT)),
        optional("fact", "The fact holds.", Form::Word),
        optional("not_fact", "The fact does not hold.", Form::Word),
    ],
)
.with_one_of(&["at", "path", "held", "free", "lies", "fact", "not_fact"]);

/// An object and a place.
pub(super) static OBJECT_AT: Shape = Shape::new(
    "an object at a place",
    "An object and a place.",
    &[required("object", "The object.", Form::Word), required("at", "The place.", Form::Word)],
);

/// An entry of `effects`.
pub(super) static EFFECT: Shape = Shape::new(
    "an effect",
    "Something that is so when the behavior succeeded.",
    &[
        optional("taken", "The object is in the resource of a claim.", Form::Map(&TAKEN)),
        optional("lies", "The object lies at the place.", Form::Map(&OBJECT_AT)),
        optional("set", "The fact holds.", Form::Word),
        optional("clear", "The fact does not hold.", Form::Word),
    ],
)
.with_one_of(&["taken", "lies", "set", "clear"]);

/// `taken`.
pub(super) static TAKEN: Shape = Shape::new(
    "a taken object",
    "An object and the claim whose resource holds it.",
    &[required("object", "The object.", Form::Word), required("by", "The name of the claim.", Form::Word)],
);

/// An entry of `commands`.
pub(super) static COMMAND: Shape = Shape::new(
    "a command",
    "What the controller of a claimed resource does.",
    &[
        required("claim", "The name of the claim.", Form::Word),
        optional("achieve", "To be reached; the behavior ends when all are.", TASK_FORM),
        optional(
            "maintain",
            "To last as long as the behavior, together with all others that want the same.",
            TASK_FORM,
        ),
    ],
)
.with_one_of(&["achieve", "maintain"]);

const TASK_FORM: Form = Form::Either(&[Form::Words(&["stand"]), Form::Map(&TASK)]);

/// What a controller does.
pub(super) static TASK: Shape = Shape::new(
    "a task of a controller",
    "What a controller does; `stand` alone is to stand still.",
    &[
        optional("drive_to", "Base: to the stand of a place.", STAND),
        optional("grasp", "Arm: take the object.", Form::Word),
        optional("put", "Arm: set the object down at the place.", Form::Map(&OBJECT_AT)),
        optional("look_at", "Head or camera: look at the surface of the place.", Form::Word),
    ],
)
.with_one_of(&["drive_to", "grasp", "put", "look_at"]);
