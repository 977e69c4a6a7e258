//! `world` of a mission: as it is written, and as places and objects with ids.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::describe::{Custom, Described, Each, Flag, List, Map, Point, Reads, TwoOrThree, Vector, Word, described};
use crate::fault::Faults;
use crate::names::{Register, refuse_argument};
use crate::quantity::{COORDINATE, EXTENT, HEADING, NEAR, TOLERANCE};
use crate::reader::Name;
use crate::shape::Form;
use ambidex_model::{
    HOLDERS_MAX, Holders, Location, Names, Obstacle, PlaceId, PlaceSpec, Pose, ResourceId, RobotSpec, WorldSpec,
    WorldState,
};

/// A height that nothing of a robot reaches over: that of obstacles given as areas, meters.
const TALL_M: f64 = 2.0;
/// Middle of a surface when none is given, in the frame of the stand, meters.
const SURFACE: Point3<f64> = Point3::new(0.5, 0.0, 0.75);

/// How far apart the first and the last of the objects without an offset lie on a surface, meters.
const SPREAD_M: f64 = 0.4;

/// A position no farther from the origin than a coordinate may be.
const ON_THE_MAP: Custom<[f64; 2]> = Custom(
    || Vector::<2>(&COORDINATE).form(),
    |item, reading| {
        let [x, y] = Vector::<2>(&COORDINATE).read(item, reading)?;
        let (distance_m, most_m) = (x.hypot(y), *COORDINATE.range.end());
        if distance_m > most_m {
            let message = format!("{:.1} km from the origin of the map", distance_m / 1000.0);
            reading.faults.push_with(&item, message, format!("at most {} km", most_m / 1000.0));
            return None;
        }
        Some([x, y])
    },
);
const CORNER: TwoOrThree = TwoOrThree(&COORDINATE);

described! {
    /// `world`.
    pub(crate) struct World: "the world",
    "Where everything is at the start. The map frame: x and y in the plane, z up." {
        tolerance_m: Option<f64> =
            maybe_or("tolerance", "How near to a stand counts as being there; 0.25 m.", &TOLERANCE, 0.25),
        robot: Option<Start> = wanted("robot", "Where the robot starts.", Map::<Start>::new()),
        places: Vec<(Name, Option<Place>)> = wanted_all(
            "places",
            "Where the robot stands and things lie.",
            Each("a map of places", Map::<Place>::new())
        ),
        objects: Vec<(Name, Option<Object>)> =
            maybe_all("objects", "What can be taken.", Each("a map of objects", Map::<Object>::new())),
        obstacles: Vec<Obstacle> =
            maybe_all("obstacles", "What the base must not drive into.", List("a list of boxes", UPRIGHT_BOX)),
        facts: Vec<(Name, Option<Fact>)> = maybe_all(
            "facts",
            "What behaviors set and clear, and whether it holds at the start.",
            Each("a map of facts", FACT)
        ),
    }
}

described! {
    /// Where the robot starts.
    pub(crate) struct Start: "the robot's start", "Where the robot starts." {
        at: [f64; 2] = required("at", "Its position on the map.", ON_THE_MAP),
        heading: f64 = or("heading", "Its direction, counterclockwise from x; 0.", &HEADING, 0.0),
    }
}

described! {
    /// An entry of `places`.
    pub(crate) struct Place: "a place", "A place: where the robot stands, and where things lie." {
        stand: [f64; 2] = required("stand", "Where the base stands, on the map.", ON_THE_MAP),
        heading: f64 = or("heading", "Where it faces, counterclockwise from x; 0.", &HEADING, 0.0),
        surface: Point3<f64> = or(
            "surface",
            "The middle of the surface in the frame of the stand; 0.5 m ahead, 0.75 m high.",
            Point(&NEAR),
            SURFACE
        ),
    }
}

described! {
    /// An entry of `objects`.
    pub(crate) struct Object: "an object", "A thing that can be taken." {
        start: StartOf = one(StartOf),
        offset: Option<([f64; 2], Option<f64>)> = optional(
            "offset",
            "Where it lies on any surface, from its middle, in the frame of the stand; without one the objects lie side by side.",
            TwoOrThree(&NEAR)
        ),
    }
}

described! {
    /// Where an object is at the start.
    pub(crate) enum StartOf: "an object", "Where it is at the start." {
        At(Name) = ("at", "The place where it lies at the start.", Word("a place")),
        Held(Vec<Name>) = (
            "held",
            "The gripper or slot that holds it at the start, or a list of those that do.",
            HOLDING
        ),
    }
}

/// One resource or several.
const HOLDING: Custom<Vec<Name>> = Custom(
    || Form::Either(vec![Form::Word, SEVERAL.form()]),
    |item, reading| match item.is_list() {
        true => SEVERAL.read(item, reading),
        false => A_RESOURCE.read(item, reading).map(|name| vec![name]),
    },
);
const A_RESOURCE: Word = Word("a resource");
const SEVERAL: List<Word> = List("a list of resources", A_RESOURCE);

described! {
    /// An entry of `facts`.
    pub(crate) struct Fact: "a fact", "A fact that more is told of than whether it holds." {
        holds: bool = or("holds", "Whether it holds at the start; `false`.", Flag, false),
        is_outside: bool = or(
            "outside",
            "Whether others than behaviors may set and clear it, so that a mission waits for it; `false`.",
            Flag,
            false
        ),
    }
}

/// Whether a fact holds, or a map that tells more.
const FACT: Custom<Fact> = Custom(
    || Form::Either(vec![Flag.form(), Form::Map(Fact::shape)]),
    |item, reading| match item.is_map() {
        true => Fact::read(item, reading),
        false => Flag.read(item, reading).map(|holds| Fact { holds, is_outside: false }),
    },
);

described! {
    /// An entry of `obstacles`.
    struct Corners: "an obstacle", "An upright box on the map." {
        min: ([f64; 2], Option<f64>) = required("min", "Its lower corner.", CORNER),
        max: ([f64; 2], Option<f64>) =
            required("max", "Its upper corner; without a height as tall as a robot.", CORNER),
    }
}

/// An entry of `obstacles` as a box that has an inside.
const UPRIGHT_BOX: Custom<Obstacle> = Custom(
    || Form::Map(Corners::shape),
    |item, reading| {
        let fields = item.fields(Corners::shape(), reading.faults)?;
        let corners = Corners::from_map(&fields, reading)?;
        let corner = |([x, y], z): ([f64; 2], Option<f64>), tall_m| Point3::new(x, y, z.unwrap_or(tall_m));
        let (min, max) = (corner(corners.min, 0.0), corner(corners.max, TALL_M));
        if (max - min).min() < *EXTENT.range.start() {
            reading.faults.push((fields.span(), item.key), "`max` is not beyond `min` by 1 cm in every direction");
            return None;
        }
        Some(Obstacle { min, max })
    },
);

/// The names of the world; known even where what they name is wrong.
#[derive(Debug, Clone)]
pub(crate) struct WorldNames {
    pub(crate) places: Register,
    pub(crate) objects: Register,
    pub(crate) facts: Register,
}

/// A world without faults: every name in it an id.
#[derive(Debug, Clone)]
pub(crate) struct Built {
    pub(crate) spec: WorldSpec,
    pub(crate) start: WorldState,
    /// Where each object lies at the start; none for one that is held.
    pub(crate) starts: Vec<Option<PlaceId>>,
    pub(crate) tolerance_m: f64,
}

impl WorldNames {
    /// The names in the order of the file.
    pub(crate) fn of(raw: &World) -> Self {
        Self {
            places: Register::of_entries("place", &raw.places),
            objects: Register::of_entries("object", &raw.objects),
            facts: Register::of_entries("fact", &raw.facts),
        }
    }
}

/// Checks the world; `None` when it has faults.
pub(crate) fn build(
    raw: World,
    names: &WorldNames,
    robot: Option<(&RobotSpec, &Names)>,
    faults: &mut Faults,
) -> Option<Built> {
    let own = raw.places.iter().map(|(name, _)| name).chain(raw.objects.iter().map(|(name, _)| name));
    own.chain(raw.facts.iter().map(|(name, _)| name)).for_each(|name| refuse_argument(name, faults));
    let count = raw.objects.len();
    let mut starts = Starts { names, robot, held: BTreeMap::new(), found: Vec::new() };
    let mut object_offsets = Vec::new();
    for (index, (name, object)) in raw.objects.into_iter().enumerate() {
        let Some(object) = object else { continue };
        starts.add(&name, &object.start, faults);
        let offset = object.offset.map(|([x, y], z)| Vector3::new(x, y, z.unwrap_or(0.0)));
        object_offsets.push(offset.unwrap_or_else(|| spread(index, count)));
    }
    let place = |place: Place| {
        let [x, y] = place.stand;
        PlaceSpec { stand: Pose::new(x, y, place.heading), surface: place.surface }
    };
    let places: Option<Vec<_>> = raw.places.into_iter().map(|(_, found)| found.map(place)).collect();
    let facts: Option<Vec<Fact>> = raw.facts.into_iter().map(|(_, fact)| fact).collect();
    let facts = facts?;
    let outside = facts.iter().map(|fact| fact.is_outside).collect();
    let facts = facts.iter().map(|fact| fact.holds).collect();
    let Start { at: [x, y], heading } = raw.robot?;
    let base = Pose::new(x, y, heading);
    let built = Built {
        starts: starts.found.iter().map(place_of).collect(),
        start: WorldState { base, objects: starts.found, facts },
        spec: WorldSpec { places: places?, object_offsets, obstacles: raw.obstacles, outside },
        tolerance_m: raw.tolerance_m?,
    };
    (built.starts.len() == count).then_some(built)
}

/// Where objects are at the start.
struct Starts<'a> {
    names: &'a WorldNames,
    robot: Option<(&'a RobotSpec, &'a Names)>,
    /// What each resource holds.
    held: BTreeMap<ResourceId, String>,
    found: Vec<Location>,
}

impl Starts<'_> {
    fn add(&mut self, name: &Name, start: &StartOf, faults: &mut Faults) {
        let at = match start {
            StartOf::At(place) => self.names.places.find(place, faults).map(|place| Location::At(place.into())),
            StartOf::Held(holders) => self.held(name, holders, faults).map(Location::In),
        };
        self.found.extend(at);
    }

    /// The resources of those names, each of which can hold something and holds nothing else.
    fn held(&mut self, object: &Name, holders: &[Name], faults: &mut Faults) -> Option<Holders> {
        let (robot, names) = self.robot?;
        let names = Register::of("resource", names.resources.iter().map(String::as_str));
        let mut found = Vec::new();
        for holder in holders {
            let Some(resource) = names.find(holder, faults).map(ResourceId::from) else { continue };
            let is_moved = robot.resources[resource.index()].controller.is_some();
            if is_moved && robot.arm(resource).is_none() {
                faults.push(holder, format!("`{}` is no gripper and no slot, so that it holds nothing", holder.value));
            } else if let Some(other) = self.held.insert(resource, object.value.clone()) {
                faults.push(holder, format!("`{}` holds `{other}` already", holder.value));
            } else {
                found.push(resource);
            }
        }
        if found.len() > HOLDERS_MAX {
            faults.push(&holders[HOLDERS_MAX], format!("at most {HOLDERS_MAX} hold one object"));
        }
        Holders::try_from(found).ok()
    }
}

fn place_of(at: &Location) -> Option<PlaceId> {
    match at {
        Location::At(place) => Some(*place),
        Location::In(_) | Location::Unknown => None,
    }
}

/// Side by side from right to left, so that two arms can take two objects from one surface.
fn spread(index: usize, count: usize) -> Vector3<f64> {
    let share = match count {
        0 | 1 => 0.5,
        several => index as f64 / (several - 1) as f64,
    };
    Vector3::new(0.0, (share - 0.5) * SPREAD_M, 0.0)
}
