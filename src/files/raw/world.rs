//! `world`: places, objects, obstacles, facts and where the robot starts.

use nalgebra::{Point3, Vector3};

use super::super::fault::Faults;
use super::super::quantity::{COORDINATE, EXTENT, HEADING, NEAR, TOLERANCE};
use super::super::reader::{Fields, Item};
use super::super::shape::{Form, Shape, optional, required};
use super::{Object, Place, World, each};
use ambidex_model::{Obstacle, Pose};

/// A height that nothing of a robot reaches over: that of obstacles given as areas, metres.
const TALL_M: f64 = 2.0;
/// Middle of a surface when none is given, in the frame of the stand, metres.
const SURFACE: Point3<f64> = Point3::new(0.5, 0.0, 0.75);

const ON_THE_MAP: Form = Form::Vector(2, 2, &COORDINATE);
const HEADED: Form = Form::Quantity(&HEADING);

/// `world`.
pub(in super::super) static WORLD: Shape = Shape::new(
    "the world",
    "Where everything is at the start. The map frame: x and y in the plane, z up.",
    &[
        optional("tolerance", "How near to a stand counts as being there; 0.25 m.", Form::Quantity(&TOLERANCE)),
        required("robot", "Where the robot starts.", Form::Map(&START)),
        required("places", "Where the robot stands and things lie.", Form::Each(&Form::Map(&PLACE))),
        optional("objects", "What can be taken.", Form::Each(&Form::Map(&OBJECT))),
        optional("obstacles", "What the base must not drive into.", Form::List(&Form::Map(&OBSTACLE))),
        optional("facts", "What behaviors set and clear, and whether it holds at the start.", Form::Each(&Form::Flag)),
    ],
);

static START: Shape = Shape::new(
    "the robot's start",
    "Where the robot starts.",
    &[
        required("at", "Its position on the map.", ON_THE_MAP),
        optional("heading", "Its direction, counterclockwise from x; 0.", HEADED),
    ],
);

static PLACE: Shape = Shape::new(
    "a place",
    "A place: where the robot stands, and where things lie.",
    &[
        required("stand", "Where the base stands, on the map.", ON_THE_MAP),
        optional("heading", "Where it faces, counterclockwise from x; 0.", HEADED),
        optional(
            "surface",
            "The middle of the surface in the frame of the stand; 0.5 m ahead, 0.75 m high.",
            Form::Vector(3, 3, &NEAR),
        ),
    ],
);

static OBJECT: Shape = Shape::new(
    "an object",
    "A thing that can be taken.",
    &[
        required("at", "The place where it lies at the start.", Form::Word),
        optional(
            "offset",
            "Where it lies on any surface, from its middle, in the frame of the stand; without one the objects lie side by side.",
            Form::Vector(2, 3, &NEAR),
        ),
    ],
);

static OBSTACLE: Shape = Shape::new(
    "an obstacle",
    "An upright box on the map.",
    &[
        required("min", "Its lower corner.", Form::Vector(2, 3, &COORDINATE)),
        required("max", "Its upper corner; without a height as tall as a robot.", Form::Vector(2, 3, &COORDINATE)),
    ],
);

impl World {
    pub(in super::super) fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = item.fields(&WORLD, faults)?;
        let tolerance_m = fields.number_or("tolerance", 0.25, faults);
        let robot = fields
            .get("robot")
            .and_then(|item| item.fields(&START, faults))
            .and_then(|fields| pose(&fields, "at", faults));
        let places = fields.get("places");
        Some(Self {
            tolerance_m,
            robot,
            places: each(places, "a map of places", faults, Place::read),
            objects: each(fields.get("objects"), "a map of objects", faults, Object::read),
            obstacles: obstacles(&fields, faults),
            facts: each(fields.get("facts"), "a map of facts", faults, |item, faults| item.flag(faults)),
        })
    }
}

fn pose(fields: &Fields<'_>, at: &str, faults: &mut Faults) -> Option<Pose> {
    let heading = fields.number_or("heading", 0.0, faults);
    let at = fields.vector(at, faults)?;
    Some(Pose::new(at[0], at[1], heading?))
}

impl Place {
    fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = item.fields(&PLACE, faults)?;
        let stand = pose(&fields, "stand", faults);
        let surface = match fields.get("surface") {
            Some(_) => fields.vector("surface", faults).map(|at| Point3::from_slice(&at)),
            None => Some(SURFACE),
        };
        Some(Self { stand: stand?, surface: surface? })
    }
}

impl Object {
    fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = item.fields(&OBJECT, faults)?;
        let offset = match fields.get("offset") {
            Some(_) => fields.vector("offset", faults).map(Some),
            None => Some(None),
        };
        let at = fields.get("at")?.name("a place", faults)?;
        Some(Self { at, offset: offset?.map(|at| Vector3::new(at[0], at[1], at.get(2).copied().unwrap_or(0.0))) })
    }
}

fn obstacles(world: &Fields<'_>, faults: &mut Faults) -> Vec<Obstacle> {
    let list = world.get("obstacles");
    let boxes = list.and_then(|item| item.list("a list of boxes", faults));
    let boxes = boxes.into_iter().flatten();
    boxes.filter_map(|item| obstacle(item, faults)).collect()
}

fn obstacle(item: Item<'_>, faults: &mut Faults) -> Option<Obstacle> {
    let fields = item.fields(&OBSTACLE, faults)?;
    let mut corner = |key, tall_m| {
        let at = fields.vector(key, faults)?;
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
