//! What is put somewhere can be taken by a hand that reaches there.

use std::collections::{BTreeMap, BTreeSet};

use ambidex_core::behavior::stands;
use ambidex_core::world::Geometry;

use super::Seen;
use crate::fault::Faults;
use ambidex_model::{EffectTerm, Location, NodeId, ObjectId, PlaceId, Pose, ResourceId, Task};

pub(super) fn check(seen: &Seen<'_>, faults: &mut Faults) {
    let takers = takers(seen);
    for leaf in seen.mission.tree.leaves() {
        check_leaf(seen, leaf, &takers, faults);
    }
}

fn check_leaf(seen: &Seen<'_>, leaf: NodeId, takers: &BTreeMap<ObjectId, BTreeSet<ResourceId>>, faults: &mut Faults) {
    let behavior = seen.behavior(leaf);
    for command in &behavior.commands {
        let Task::Put(object, place) = command.task else { continue };
        let Some(takers) = takers.get(&object) else { continue };
        let reaches = |hand: &ResourceId| reaches(seen, *hand, object, place, stands(&behavior.precondition));
        if takers.iter().any(reaches) {
            continue;
        }
        let (object, place) = (seen.mission.names.object(object), seen.mission.names.place(place));
        let message = format!("it can never run: no hand that can take {object} reaches {place}");
        seen.warn(
            leaf,
            message,
            "see `stand` and `surface` of the place, and `reach` and `shoulder` of the arms",
            faults,
        );
    }
}

/// By object, the hands that hold it at the start or can take it from some place where it can lie.
fn takers(seen: &Seen<'_>) -> BTreeMap<ObjectId, BTreeSet<ResourceId>> {
    let places = places(seen);
    let mut takers: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for (object, location) in seen.mission.start.objects.iter().enumerate() {
        if !location.holders().is_empty() {
            takers.entry(ObjectId::from(object)).or_default().extend(location.holders());
        }
    }
    for behavior in seen.behaviors() {
        for command in &behavior.commands {
            let Some(object) = command.task.grasped() else { continue };
            let hands = seen.mission.robot.could_serve(behavior.claims[command.claim].selector);
            let from = stands(&behavior.precondition);
            // What is held can be anywhere: whoever takes it from there is a taker.
            let is_held = matches!(command.task, Task::GraspFrom(..));
            let can = |hand: &ResourceId| {
                is_held || places[object.index()].iter().any(|place| reaches(seen, *hand, object, *place, from))
            };
            takers.entry(object).or_default().extend(hands.into_iter().filter(can));
        }
    }
    takers
}

/// By object, where it can lie: where it does at the start, and wherever some behavior puts it.
fn places(seen: &Seen<'_>) -> Vec<BTreeSet<PlaceId>> {
    let start = |at: &Location| match at {
        Location::At(place) => BTreeSet::from([*place]),
        Location::In(_) | Location::Unknown => BTreeSet::new(),
    };
    let mut places: Vec<BTreeSet<PlaceId>> = seen.mission.start.objects.iter().map(start).collect();
    for effect in seen.behaviors().flat_map(|behavior| &behavior.effects) {
        match effect {
            EffectTerm::Lies(object, place) => drop(places[object.index()].insert(*place)),
            EffectTerm::Taken(..) | EffectTerm::LetGo(..) | EffectTerm::Fact(..) | EffectTerm::Stands(_) => {}
        }
    }
    places
}

/// Whether a hand reaches an object at a place from one of some stands; of an unknown one, and of what is no arm, so it seems.
fn reaches(seen: &Seen<'_>, hand: ResourceId, object: ObjectId, place: PlaceId, from: Option<(&[Pose], f64)>) -> bool {
    let Some((stands, tolerance_m)) = from else { return true };
    let (geometry, thing) = (Geometry::of(seen.mission), (object, place));
    let (own, approach) = (geometry.world.own_spot(object, place), geometry.world.approach(object, place));
    stands.iter().any(|stand| {
        geometry.puts_from(stand, hand, thing, tolerance_m)
            || geometry.reach_from(stand, hand, own, approach, tolerance_m).is_some()
    })
}
