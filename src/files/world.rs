//! The world as read, to places and objects with ids.

use nalgebra::Vector3;

use super::fault::Faults;
use super::names::Register;
use super::raw::World;
use ambidex_model::{Location, PlaceId, PlaceSpec, Pose, WorldSpec, WorldState};

/// How far apart the first and the last of the objects without an offset lie on a surface, metres.
const SPREAD_M: f64 = 0.4;

/// The names of the world; known even where what they name is wrong.
#[derive(Debug, Clone)]
pub(super) struct WorldNames {
    pub(super) places: Register,
    pub(super) objects: Register,
    pub(super) facts: Register,
}

/// A checked world.
#[derive(Debug, Clone)]
pub(super) struct Built {
    pub(super) spec: WorldSpec,
    pub(super) start: WorldState,
    /// Where each object is at the start.
    pub(super) starts: Vec<PlaceId>,
    pub(super) tolerance_m: f64,
}

impl WorldNames {
    /// The names in the order of the file.
    pub(super) fn of(raw: &World) -> Self {
        let names = |list: Vec<&'_ super::reader::Name>, what| {
            Register::of(what, list.into_iter().map(|name| name.value.as_str()))
        };
        Self {
            places: names(raw.places.iter().map(|(name, _)| name).collect(), "place"),
            objects: names(raw.objects.iter().map(|(name, _)| name).collect(), "object"),
            facts: names(raw.facts.iter().map(|(name, _)| name).collect(), "fact"),
        }
    }
}

/// Checks the world; `None` when it has faults.
pub(super) fn build(raw: World, names: &WorldNames, faults: &mut Faults) -> Option<Built> {
    let count = raw.objects.len();
    let mut starts = Vec::new();
    let mut object_offsets = Vec::new();
    for (index, (_, object)) in raw.objects.into_iter().enumerate() {
        let Some(object) = object else { continue };
        let at = names.places.find(&object.at, faults);
        starts.extend(at.map(PlaceId::from));
        object_offsets.push(object.offset.unwrap_or_else(|| spread(index, count)));
    }
    let place = |place: super::raw::Place| PlaceSpec { stand: place.stand, surface: place.surface };
    let places: Option<Vec<_>> = raw.places.into_iter().map(|(_, found)| found.map(place)).collect();
    let facts: Option<Vec<_>> = raw.facts.into_iter().map(|(_, holds)| holds).collect();
    let base: Pose = raw.robot?;
    let built = Built {
        start: WorldState { base, objects: starts.iter().copied().map(Location::At).collect(), facts: facts? },
        spec: WorldSpec { places: places?, object_offsets, obstacles: raw.obstacles },
        tolerance_m: raw.tolerance_m?,
        starts,
    };
    (built.starts.len() == count).then_some(built)
}

/// Side by side from right to left, so that two arms can take two objects from one surface.
fn spread(index: usize, count: usize) -> Vector3<f64> {
    let share = match count {
        0 | 1 => 0.5,
        several => index as f64 / (several - 1) as f64,
    };
    Vector3::new(0.0, (share - 0.5) * SPREAD_M, 0.0)
}
