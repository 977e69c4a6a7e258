//! What stands in the files: their shape with names not yet looked up. A part that is wrong is `None` and has its fault.

mod robot;
mod task;
mod world;

use nalgebra::{Point3, Vector3};

use super::document::Spot;
use super::fault::Faults;
use super::reader::{Item, Name};
use crate::model::{ControllerKind, Obstacle, Pose};

/// A mission file.
#[derive(Debug, Clone)]
pub(super) struct Mission {
    pub(super) mission: Option<Name>,
    pub(super) robot: Option<Name>,
    pub(super) world: Option<World>,
    pub(super) task: Option<Task>,
}

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

/// A node of `task`.
#[derive(Debug, Clone)]
pub(super) struct Task {
    pub(super) spot: Spot,
    pub(super) name: Option<Name>,
    pub(super) retries: Option<u32>,
    pub(super) timeout_s: Option<f64>,
    pub(super) kind: Option<Kind>,
}

/// What a node is.
#[derive(Debug, Clone)]
pub(super) enum Kind {
    And(Vec<Task>),
    Or(Vec<Task>),
    Then(Vec<Task>),
    Behavior(Behavior),
}

/// What a behavior does.
#[derive(Debug, Clone)]
pub(super) enum Behavior {
    Move { to: Name, offset: [f64; 2], scale_by: Option<Name> },
    Pick { object: Name, at: Option<Name> },
    Place { object: Name, at: Option<Name> },
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

impl Mission {
    /// Reads a mission file.
    pub(super) fn read(file: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let keys = ["mission", "robot", "world", "task"];
        let fields = file.fields("a mission", &keys, faults)?;
        let mut text = |key, what| fields.required(key, faults)?.name(what, faults);
        let mission = text("mission", "the name of the mission");
        let robot = text("robot", "the path of a robot file");
        let world = fields.required("world", faults);
        let task = fields.required("task", faults);
        Some(Self {
            mission,
            robot,
            world: world.and_then(|item| World::read(item, faults)),
            task: task.and_then(|item| Task::read(item, faults)),
        })
    }
}

/// Reads a map from names that the writer chooses; a name whose value is wrong is kept, so that it is known.
fn each<'a, T>(
    map: Option<Item<'a>>,
    what: &str,
    faults: &mut Faults,
    read: impl Fn(Item<'a>, &mut Faults) -> Option<T>,
) -> Vec<(Name, Option<T>)> {
    let entries = map.and_then(|item| item.named(what, faults));
    let entries = entries.into_iter().flatten();
    entries.map(|(name, item)| (name, read(item, faults))).collect()
}
