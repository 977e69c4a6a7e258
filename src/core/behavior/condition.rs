//! Conditions over world and line.

use crate::world::{KnownPaths, NoPath, View};
use ambidex_model::{Condition, Lineage, Location, PlaceId, Pose, Reason};

/// Whether a condition is met.
///
/// # Errors
/// What is not so; [`Condition::Never`] has no better word than that the goal is not met by itself.
pub fn check(condition: &Condition, view: &View, line: &Lineage<'_>, known: &mut KnownPaths) -> Result<(), Reason> {
    let world_state = view.state.world();
    match condition {
        Condition::All(parts) => parts.iter().try_for_each(|part| check(part, view, line, known)),
        Condition::Never => Err(Reason::NotItsTurn { after: line.node }),
        Condition::At { place, stand, tolerance_m } => match view.driver() {
            Some(by) => Err(Reason::Driving { by }),
            None => met(is_at(world_state.base, *stand, *tolerance_m), || Reason::NotAt { place: *place }),
        },
        Condition::Path { place, stand } => {
            let no_path = known.path(&view.free_space, world_state.base, *stand).err();
            no_path.map_or(Ok(()), |no_path| Err(unreached(no_path, *place)))
        }
        Condition::Held(object) => {
            let is_held = match world_state.objects[object.index()] {
                Location::In(resource) => {
                    let leases = view.state.table().resource(resource).leases();
                    leases.iter().any(|lease| line.contains(lease.holder))
                }
                Location::At(_) | Location::Unknown => false,
            };
            met(is_held, || Reason::NotHeld { object: *object })
        }
        Condition::Free(object) => match world_state.objects[object.index()] {
            Location::In(by) => Err(Reason::Taken { object: *object, by }),
            Location::At(_) | Location::Unknown => Ok(()),
        },
        Condition::Lies(object, place) => {
            let is_there = world_state.objects[object.index()] == Location::At(*place);
            met(is_there, || Reason::Elsewhere { object: *object, place: *place })
        }
        Condition::Fact(fact, holds) => {
            met(world_state.facts[fact.index()] == *holds, || Reason::Fact { fact: *fact, holds: *holds })
        }
    }
}

fn unreached(no_path: NoPath, place: PlaceId) -> Reason {
    match no_path {
        NoPath::Closed => Reason::NoPath { place },
        NoPath::Beyond(steps) => Reason::PathNotFound { place, steps },
    }
}

fn met(is_met: bool, otherwise: impl FnOnce() -> Reason) -> Result<(), Reason> {
    if is_met { Ok(()) } else { Err(otherwise()) }
}

fn is_at(base: Pose, stand: Pose, tolerance_m: f64) -> bool {
    base.distance_m(&stand) <= tolerance_m
}
