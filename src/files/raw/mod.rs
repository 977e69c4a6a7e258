//! What stands in the files: their shape with names not yet looked up. A part that is wrong is `None` and has its fault.

mod robot;
mod world;

pub(super) use robot::ROBOT;
pub(super) use world::WORLD;

use nalgebra::{Point3, Vector3};

use super::fault::Faults;
use super::reader::{Item, Name};
use ambidex_model::{ControllerKind, Obstacle, Pose};

/// `world`.
#[derive(Debug, Clone)]
pub(super) struct World {
    pub(super) tolerance_m: Option<f64>,
    pub(super) robot: Option<Pose>,
    pub(super) places: Vec<(Name, Option<Place>)>,
    pub(super) objects: Vec<(Name, Option<Object>)>,
    pub(super) obstacles: Vec<Obstacle>,
    pub(super) facts: Vec<(Name, Option<bool>)>,
}

/// An entry of `places`.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) stand: Pose,
    pub(super) surface: Point3<f64>,
}

/// An entry of `objects`.
#[derive(Debug, Clone)]
pub(super) struct Object {
    pub(super) at: Name,
    pub(super) offset: Option<Vector3<f64>>,
}

/// A robot file.
#[derive(Debug, Clone)]
pub(super) struct Robot {
    pub(super) robot: Option<Name>,
    pub(super) radius_m: Option<f64>,
    pub(super) resources: Vec<(Name, Option<Resource>)>,
    pub(super) controllers: Vec<(Name, Option<ControllerKind>)>,
}

/// An entry of `resources`.
#[derive(Debug, Clone)]
pub(super) struct Resource {
    pub(super) ty: Name,
    pub(super) controller: Option<Name>,
}

/// Reads a map from names that the writer chooses; a name whose value is wrong is kept, so that it is known.
pub(super) fn each<'a, T>(
    map: Option<Item<'a>>,
    what: &str,
    faults: &mut Faults,
    mut read: impl FnMut(Item<'a>, &mut Faults) -> Option<T>,
) -> Vec<(Name, Option<T>)> {
    let entries = map.and_then(|item| item.named(what, faults));
    let entries = entries.into_iter().flatten();
    entries.map(|(name, item)| (name, read(item, faults))).collect()
}
