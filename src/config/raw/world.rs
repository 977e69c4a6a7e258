//! `world`: places, objects, obstacles, facts and where the robot starts.

use nalgebra::{Point3, Vector3};

use super::super::fault::Faults;
use super::super::quantity::{COORDINATE, EXTENT, HEADING, NEAR, TOLERANCE};
use super::super::reader::{Fields, Item};
use super::{Object, Place, World, each};
use crate::model::{Obstacle, Pose};

/// A height that nothing of a robot reaches over: that of obstacles given as areas, metres.
const TALL_M: f64 = 2.0;
/// Middle of a surface when none is given, in the frame of the stand, metres.
const SURFACE: Point3<f64> = Point3::new(0.5, 0.0, 0.75);

impl World {
    pub(super) fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let keys = ["tolerance", "robot", "places", "objects", "obstacles", "facts"];
        let fields = item.fields("the world", &keys, faults)?;
        let tolerance_m = match fields.optional("tolerance") {
            Some(item) => item.quantity(&TOLERANCE, faults),
            None => Some(0.25),
        };
        let robot = fields
            .required("robot", faults)
            .and_then(|item| item.fields("the robot's start", &["at", "heading"], faults))
            .and_then(|fields| pose(&fields, "at", faults));
        let places = fields.required("places", faults);
        Some(Self {
            tolerance_m,
            robot,
            places: each(places, "a map of places", faults, Place::read),
            objects: each(fields.optional("objects"), "a map of objects", faults, Object::read),
            obstacles: obstacles(&fields, faults),
            facts: each(fields.optional("facts"), "a map of facts", faults, |item, faults| item.flag(faults)),
        })
    }
}

fn pose(fields: &Fields<'_>, at: &str, faults: &mut Faults) -> Option<Pose> {
    let heading = match fields.optional("heading") {
        Some(item) => item.quantity(&HEADING, faults),
        None => Some(0.0),
    };
    let at = fields.required(at, faults)?.vector(2..=2, &COORDINATE, faults)?;
    Some(Pose::new(at[0], at[1], heading?))
}

impl Place {
    fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = item.fields("a place", &["stand", "heading", "surface"], faults)?;
        let stand = pose(&fields, "stand", faults);
        let surface = match fields.optional("surface") {
            Some(item) => item.vector(3..=3, &NEAR, faults).map(|at| Point3::from_slice(&at)),
            None => Some(SURFACE),
        };
        Some(Self { stand: stand?, surface: surface? })
    }
}

impl Object {
    fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = item.fields("an object", &["at", "offset"], faults)?;
        let offset = match fields.optional("offset") {
            Some(item) => item.vector(2..=3, &NEAR, faults).map(Some),
            None => Some(None),
        };
        let at = fields.required("at", faults)?.name("a place", faults)?;
        Some(Self { at, offset: offset?.map(|at| Vector3::new(at[0], at[1], at.get(2).copied().unwrap_or(0.0))) })
    }
}

fn obstacles(world: &Fields<'_>, faults: &mut Faults) -> Vec<Obstacle> {
    let list = world.optional("obstacles");
    let boxes = list.and_then(|item| item.list("a list of boxes", faults));
    let boxes = boxes.into_iter().flatten();
    boxes.filter_map(|item| obstacle(item, faults)).collect()
}

fn obstacle(item: Item<'_>, faults: &mut Faults) -> Option<Obstacle> {
    let fields = item.fields("an obstacle", &["min", "max"], faults)?;
    let mut corner = |key, tall_m| {
        let at = fields.required(key, faults)?.vector(2..=3, &COORDINATE, faults)?;
        Some(Point3::new(at[0], at[1], at.get(2).copied().unwrap_or(tall_m)))
    };
    let (min, max) = (corner("min", 0.0), corner("max", TALL_M));
    let (min, max) = (min?, max?);
    let extent = max - min;
    if extent.min() < *EXTENT.range.start() {
        let message = "`max` is not beyond `min` by 1 cm in every direction".to_owned();
        faults.push(fields.spot(), item.key, message, None);
        return None;
    }
    Some(Obstacle { min, max })
}
