//! `world` of a mission: as it is written, and as places and objects with ids.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::describe::{At, Custom, Described, Each, Flag, List, Map, Reads, TwoOrThree, Vector, Word, described};
use crate::fault::Faults;
use crate::names::{Register, refuse_argument};
use crate::quantity::{EXTENT, HEADING, NEAR, TOLERANCE};
use crate::reader::{Name, Written};
use crate::room::{self, OBSTACLE, ON_THE_MAP, Place, Spans, WALL, spread};
use crate::shape::Form;
use ambidex_model::{
    Distance, HOLDERS_MAX, Holders, Location, Names, ObjectSpec, Obstacle, PlaceId, Pose, ResourceId, RobotSpec, Shape,
    Side, WorldSpec, WorldState,
};

described! {
    /// `world`.
    pub(crate) struct World: "the world",
    "Where everything is at the start. The map frame: x and y in the plane, z up." {
        tolerance_m: Option<f64> =
            maybe_or("tolerance", "How near to a stand counts as being there; 0.25 m.", &TOLERANCE, 0.25),
        distance: Option<Distance> = maybe_or(
            "distance",
            "What potentials measure the way along: `straight`, by itself, or the `path` that the base would drive.",
            DISTANCE,
            Distance::Straight
        ),
        robot: Option<Start> = wanted("robot", "Where the robot starts.", Map::<Start>::new()),
        places: Vec<(Name, Option<Place>)> = wanted_all(
            "places",
            "Where the robot stands and things lie.",
            Each("a map of places", Map::<Place>::new())
        ),
        objects: Vec<(Name, Option<Object>)> =
            maybe_all("objects", "What can be taken.", Each("a map of objects", Map::<Object>::new())),
        walls: Vec<Obstacle> = maybe_all("walls", "Straight walls.", List("a list of walls", WALL)),
        obstacles: Vec<Obstacle> =
            maybe_all("obstacles", "What else the base must not drive into.", List("a list of boxes", OBSTACLE)),
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
        at: Written<[f64; 2]> = required("at", "Its position on the map.", At(ON_THE_MAP)),
        heading: f64 = or("heading", "Its direction, counterclockwise from x; 0.", &HEADING, 0.0),
    }
}

described! {
    /// An entry of `objects`.
    pub(crate) struct Object: "an object", "A thing that can be taken." {
        start: StartOf = one(StartOf),
        offset: Option<([f64; 2], Option<f64>)> = optional(
            "offset",
            "Where it lies, from the middle of the surface, in the frame of the stand; without one the objects lie side by \
             side. Put down on a table it comes to a free spot.",
            TwoOrThree(&NEAR)
        ),
        heading: f64 = or(
            "heading",
            "Where its front is turned, counterclockwise from that of the stand: at 0 it faces who stands there.",
            &HEADING,
            0.0
        ),
        shape: Option<Shape> = optional("shape", "Its body; without one it is a point.", BODY),
        grasps: Vec<Side> = maybe_all(
            "grasps",
            "From where a hand may come to it, if not from anywhere: `above`, `front`, `back`, `left`, `right` of it, as who \
             faces its front sees it.",
            List("a list of sides", SIDE)
        ),
    }
}

described! {
    /// `shape` of an object.
    pub(crate) enum Body: "a shape", "The body of an object, which stands upright." {
        Box([f64; 3]) = ("box", "Along its x, along its y, and how high.", Vector::<3>(&EXTENT)),
        Cylinder(Cylinder) = ("cylinder", "An upright cylinder.", Map::<Cylinder>::new()),
    }
}

described! {
    /// `cylinder` of a shape.
    pub(crate) struct Cylinder: "a cylinder", "An upright cylinder." {
        radius_m: f64 = required("radius", "Of its circle.", &EXTENT),
        height_m: f64 = required("height", "From bottom to top.", &EXTENT),
    }
}

/// `shape` of an object.
const BODY: Custom<Shape> = Custom(
    || Form::Map(OneShape::shape),
    |item, reading| {
        Some(match OneShape::read(item, reading)?.body {
            Body::Box(size) => Shape::Box(size.into()),
            Body::Cylinder(Cylinder { radius_m, height_m }) => Shape::Cylinder { radius_m, height_m },
        })
    },
);

described! {
    /// A map with one shape in it.
    struct OneShape: "a shape", "The body of an object." {
        body: Body = one(Body),
    }
}

/// An entry of `grasps`.
const SIDE: Custom<Side> = Custom(
    || Form::Words(&SIDES),
    |item, reading| {
        let written = Word("a side").read(item, reading)?;
        let found = Register::of("side", SIDES).find(&written, reading.faults)?;
        Some([Side::Above, Side::Front, Side::Back, Side::Left, Side::Right][found])
    },
);
const SIDES: [&str; 5] = ["above", "front", "back", "left", "right"];

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

/// The names of the world; known even where what they name is wrong.
#[derive(Debug, Clone)]
pub(crate) struct WorldNames {
    pub(crate) places: Register,
    /// What the stands of each place are called; none where no place has several.
    pub(crate) stands: Vec<Vec<String>>,
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

impl Built {
    /// A world as it is at the start.
    pub(crate) fn of(spec: WorldSpec, start: WorldState, tolerance_m: f64) -> Self {
        Self { starts: start.objects.iter().map(place_of).collect(), spec, start, tolerance_m }
    }
}

impl WorldNames {
    /// The names in the order of the file.
    pub(crate) fn of(raw: &World) -> Self {
        let stands: Vec<_> = raw.places.iter().map(|(_, place)| room::stand_names(place.as_ref())).collect();
        Self {
            places: Register::of_entries("place", &raw.places),
            stands: if stands.iter().all(Vec::is_empty) { Vec::new() } else { stands },
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
    let mut objects = Vec::new();
    let object_names: Vec<Name> = raw.objects.iter().map(|(name, _)| name.clone()).collect();
    for (index, (name, object)) in raw.objects.into_iter().enumerate() {
        let Some(object) = object else { continue };
        starts.add(&name, &object.start, faults);
        let offset = object.offset.map(|([x, y], z)| Vector3::new(x, y, z.unwrap_or(0.0)));
        objects.push(ObjectSpec {
            is_offset_told: offset.is_some(),
            offset: offset.unwrap_or_else(|| spread(index, count)),
            heading: object.heading,
            shape: object.shape,
            grasps: object.grasps,
        });
    }
    let place_names: Vec<Name> = raw.places.iter().map(|(name, _)| name.clone()).collect();
    // Of a robot with faults nobody knows how wide it is.
    let radius_m = robot.map_or(0.0, |(robot, _)| robot.radius_m);
    let places: Vec<_> = raw.places.into_iter().map(|(_, found)| found?.spec(radius_m, count, faults)).collect();
    let places: Option<Vec<_>> = places.into_iter().collect();
    let facts: Option<Vec<Fact>> = raw.facts.into_iter().map(|(_, fact)| fact).collect();
    let facts = facts?;
    let outside = facts.iter().map(|fact| fact.is_outside).collect();
    let facts = facts.iter().map(|fact| fact.holds).collect();
    let Start { at, heading } = raw.robot?;
    let base = Pose::new(at.value[0], at.value[1], heading);
    let start = WorldState::new(base, starts.found, facts);
    let obstacles = [raw.walls, raw.obstacles].concat();
    let spec = WorldSpec { places: places?, objects, obstacles, distance: raw.distance?, outside };
    if let Some((robot, _)) = robot.filter(|_| start.objects.len() == count && spec.objects.len() == count) {
        let spans = Spans { start: &at, places: &place_names, objects: &object_names };
        room::check(&spec, &start, &spans, robot, faults);
    }
    let built = Built::of(spec, start, raw.tolerance_m?);
    (built.starts.len() == count).then_some(built)
}

/// What distances are measured along.
const DISTANCE: Custom<Distance> = Custom(
    || Form::Words(&DISTANCES),
    |item, reading| {
        let written = Word("`straight` or `path`").read(item, reading)?;
        let found = Register::of("distance", DISTANCES).find(&written, reading.faults)?;
        Some([Distance::Straight, Distance::Path][found])
    },
);
const DISTANCES: [&str; 2] = ["straight", "path"];

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
