//! Terms about what is held: by how many, taken from where, let go into what.

use super::NameOrParam;
use super::named::{CLAIMED, NameOf, OBJECT, PLACE};
use crate::describe::{Count, Custom, Described, Flag, Reads, described};
use crate::shape::Form;
use crate::types::Type;
use ambidex_model::HOLDERS_MAX;

/// How many can hold one object.
const HANDS: Count = Count(HOLDERS_MAX as u32);

described! {
    /// `held` as a map.
    pub(super) struct HeldTerm: "what is held", "That an object is held by this task, by how many, and with what." {
        object: NameOrParam = required("object", "The object.", OBJECT),
        hands: u32 = or("hands", "How many hold it at least; 1.", HANDS, 1),
        alone: bool = or("alone", "Whether nothing else may hold it; `false`.", Flag, false),
        of: Option<NameOrParam> =
            optional("type", "Only resources of this type count.", NameOf(Type::Kind)),
        resource: Option<NameOrParam> =
            optional("resource", "Only this resource counts.", NameOf(Type::Resource)),
    }
}

/// An object alone, or a map.
pub(super) const HELD: Custom<HeldTerm> = Custom(
    || Form::Either(vec![Form::Word, Form::Map(HeldTerm::shape)]),
    |item, reading| {
        if !item.is_map() {
            return Some(HeldTerm {
                object: OBJECT.read(item, reading)?,
                hands: 1,
                alone: false,
                of: None,
                resource: None,
            });
        }
        let held = HeldTerm::read(item, reading)?;
        let wrong = match (&held.of, &held.resource, held.hands) {
            (Some(_), Some(_), _) => Some("held by a `type` or by one `resource`, not both"),
            (None, Some(_), 2..) => Some("one resource is one hand"),
            (_, _, 0) => Some("held by nobody: write `free`"),
            (_, _, _) => None,
        };
        if let Some(wrong) = wrong {
            reading.faults.push(&item, wrong);
        }
        wrong.is_none().then_some(held)
    },
);

described! {
    /// `taken` or `let_go`.
    pub(super) struct ObjectBy: "an object and its holder", "An object and the claim whose resource is its holder." {
        object: NameOrParam = required("object", "The object.", OBJECT),
        claim: usize = required("by", "The name of the claim.", CLAIMED),
    }
}

described! {
    /// `grasp` as a map.
    struct GraspFrom: "a grasp", "Takes an object out of what holds it." {
        object: Option<NameOrParam> = optional(
            "object",
            "The object; what the claim `holds`, if left out.",
            OBJECT
        ),
        from: usize = required("from", "The claim that `holds` it: another hand, or a slot of the robot.", CLAIMED),
    }
}

/// What is grasped.
#[derive(Debug)]
pub(super) enum Grasped {
    /// An object that lies somewhere.
    Lying(NameOrParam),
    /// What the resource of that claim holds.
    From(Option<NameOrParam>, usize),
}

/// An object alone, or a map.
pub(super) const GRASPED: Custom<Grasped> = Custom(
    || Form::Either(vec![Form::Word, Form::Map(GraspFrom::shape)]),
    |item, reading| {
        if item.is_map() {
            return GraspFrom::read(item, reading).map(|grasp| Grasped::From(grasp.object, grasp.from));
        }
        OBJECT.read(item, reading).map(Grasped::Lying)
    },
);

described! {
    /// `put`.
    pub(super) struct PutTerm: "a put", "Sets an object down at a place, or lets it go into something." {
        object: NameOrParam = required("object", "The object.", OBJECT),
        to: PutTo = one(PutTo),
    }
}

described! {
    /// Where something is put.
    pub(super) enum PutTo: "a put", "Where it is put." {
        At(NameOrParam) = ("at", "The place.", PLACE),
        Into(usize) = ("into", "The claim on another hand, or on a slot of the robot.", CLAIMED),
    }
}
