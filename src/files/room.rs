//! What stands in the room: places with a table or without, walls and obstacles, and what of it cannot be.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Point2, Point3, Vector2, Vector3};

use ambidex_core::world::{FreeSpace, overlap};

use crate::describe::{At, Custom, Described, Each, Map, Point, Reads, TwoOrThree, Vector, Word, described};
use crate::fault::Faults;
use crate::names::Register;
use crate::quantity::{COORDINATE, EXTENT, HEADING, NEAR};
use crate::reader::{Item, Name, Written};
use crate::scope::Reading;
use crate::shape::Form;
use ambidex_model::{Location, ObjectId, Obstacle, PlaceId, PlaceSpec, Pose, RobotSpec, TALL_M, WorldSpec, WorldState};

/// Middle of a surface when none is given, in the frame of the stand, meters.
const SURFACE: Point3<f64> = Point3::new(0.5, 0.0, 0.75);
/// How far the base keeps from a table that it stands at, meters.
const GAP_M: f64 = 0.05;
/// How far from the edge of a table its things lie, meters.
const INSET_M: f64 = 0.2;
/// How much two things may be into each other, meters: files are written with two digits.
const SLACK_M: f64 = 0.01;
/// How far apart the first and the last of the objects without an offset lie on a surface, meters.
const SPREAD_M: f64 = 0.4;
/// How far apart things are put down on a table, and how far from its edge, meters.
const SPOT_M: f64 = 0.15;
const EDGE_M: f64 = 0.1;
/// How many things lie side by side on a surface of which nothing is known but its middle, and in how many rows: as far as
/// arms reach.
const IN_A_ROW: usize = 4;
const MOST_ROWS: usize = 3;
/// How many spots a table has, about.
const MAX_SPOTS: f64 = 60.0;
/// Most stands of a table.
const MAX_STANDS: usize = 16;
/// How thick a wall is.
const WALL_M: f64 = 0.1;

/// A position no farther from the origin than a coordinate may be.
pub(crate) const ON_THE_MAP: Custom<[f64; 2]> = Custom(
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
    /// An entry of `places`.
    pub(crate) struct Place: "a place", "A place: where the robot stands, and where things lie." {
        at: PlaceAt = one(PlaceAt),
        heading: Option<f64> = optional(
            "heading",
            "Where the base faces there, counterclockwise from x; 0, or towards the table.",
            &HEADING
        ),
        surface: Option<Point3<f64>> = optional(
            "surface",
            "The middle of the surface in the frame of the stand; 0.5 m ahead, 0.75 m high, or on the table.",
            Point(&NEAR)
        ),
    }
}

described! {
    /// Where a place is.
    pub(crate) enum PlaceAt: "a place", "Where it is." {
        Stand([f64; 2]) = ("stand", "Where the base stands, on the map.", ON_THE_MAP),
        Table(Box<Table>) = (
            "table",
            "What things lie on: a box on the floor, before which the base stands and which it must not drive into.",
            TABLE
        ),
    }
}

const TABLE: Custom<Box<Table>> =
    Custom(|| Form::Map(Table::shape), |item, reading| Table::read(item, reading).map(Box::new));

described! {
    /// `table` of a place.
    pub(crate) struct Table: "the table of a place", "A box on the floor." {
        at: [f64; 2] = required("at", "Its middle, on the map.", ON_THE_MAP),
        heading: f64 = or("heading", "Where its x points, counterclockwise from x of the map; 0.", &HEADING, 0.0),
        size: [f64; 3] = required("size", "Along its x, along its y, and how high.", Vector::<3>(&EXTENT)),
        side: Option<Name> = optional(
            "side",
            "From where the base reaches over it, in its own frame: `front` faces its x, and is so by itself; `back`, \
             `left` (of who stands in front) or `right`.",
            Word("a side")
        ),
        stands: Option<Written<Vec<(Name, Option<TableStand>)>>> = optional(
            "stands",
            "Where else than at one side it can be reached over from: the first is the one in whose frame things lie.",
            At(Each("a map of stands", Map::<TableStand>::new()))
        ),
    }
}

described! {
    /// A stand before a table.
    pub(crate) struct TableStand: "a stand of a table", "Where the base may stand before a table." {
        side: Name = required("side", "At which side: `front`, `back`, `left` or `right`.", Word("a side")),
        along_m: f64 = or("along", "How far to the left of the middle of that side, as the base faces it; 0.", &COORDINATE, 0.0),
    }
}

described! {
    /// An entry of `walls`.
    struct Wall: "a wall", "A straight wall." {
        from: [f64; 2] = required("from", "Where its middle line begins, on the map.", ON_THE_MAP),
        to: [f64; 2] = required("to", "Where it ends.", ON_THE_MAP),
        thickness_m: f64 = or("thickness", "How thick it is; 0.1 m.", &EXTENT, WALL_M),
    }
}

/// An entry of `walls` as a box.
pub(crate) const WALL: Custom<Obstacle> = Custom(
    || Form::Map(Wall::shape),
    |item, reading| {
        let fields = item.fields(Wall::shape(), reading.faults)?;
        let Wall { from, to, thickness_m } = Wall::from_map(&fields, reading)?;
        let (from, to) = (Point2::from(from), Point2::from(to));
        let way: Vector2<f64> = to - from;
        if way.norm() < *EXTENT.range.start() {
            reading.faults.push((fields.span(), item.key), "`to` is not 1 cm away from `from`");
            return None;
        }
        // Walls that meet at a corner leave no notch.
        let size = Vector3::new(way.norm() + thickness_m, thickness_m, TALL_M);
        Some(Obstacle::on_floor(nalgebra::center(&from, &to), size, way.y.atan2(way.x)))
    },
);

described! {
    /// An entry of `obstacles`.
    struct Solid: "an obstacle", "An upright box on the map: by two corners, or by middle and size." {
        min: Option<([f64; 2], Option<f64>)> = optional("min", "Its lower corner.", CORNER),
        max: Option<([f64; 2], Option<f64>)> =
            optional("max", "Its upper corner; without a height as tall as a robot.", CORNER),
        at: Option<[f64; 2]> = optional("at", "Its middle, with `size`.", ON_THE_MAP),
        size: Option<([f64; 2], Option<f64>)> = optional(
            "size",
            "Along its x, along its y, and how high; without a height as tall as a robot.",
            TwoOrThree(&EXTENT)
        ),
        heading: Option<f64> =
            optional("heading", "Where its x points, counterclockwise from x of the map; 0; with `size`.", &HEADING),
    }
}

/// An entry of `obstacles` as a box that has an inside.
pub(crate) const OBSTACLE: Custom<Obstacle> = Custom(|| Form::Map(Solid::shape), obstacle);

fn obstacle(item: Item<'_>, reading: &mut Reading<'_>) -> Option<Obstacle> {
    let fields = item.fields(Solid::shape(), reading.faults)?;
    let Solid { min, max, at, size, heading } = Solid::from_map(&fields, reading)?;
    let here = (fields.span(), item.key);
    match (min, max, at, size, heading) {
        (Some(min), Some(max), None, None, None) => {
            let corner = |([x, y], z): ([f64; 2], Option<f64>), tall_m| Point3::new(x, y, z.unwrap_or(tall_m));
            let (min, max) = (corner(min, 0.0), corner(max, TALL_M));
            if (max - min).min() < *EXTENT.range.start() {
                reading.faults.push(here, "`max` is not beyond `min` by 1 cm in every direction");
                return None;
            }
            Some(Obstacle::between(min, max))
        }
        (None, None, Some([x, y]), Some(([along, across], height)), heading) => {
            let size = Vector3::new(along, across, height.unwrap_or(TALL_M));
            Some(Obstacle::on_floor(Point2::new(x, y), size, heading.unwrap_or(0.0)))
        }
        _ => {
            let help = "`min` and `max`, or `at` and `size` (and `heading`)";
            reading.faults.push_with(here, "it is not told where this obstacle is", help);
            None
        }
    }
}

impl Place {
    /// Where the base stands and things lie, for a base of a radius and a world of so many objects.
    pub(crate) fn spec(self, radius_m: f64, objects: usize, faults: &mut Faults) -> Option<PlaceSpec> {
        let (mut stands, on_table, table) = match self.at {
            PlaceAt::Stand([x, y]) => (vec![Pose::new(x, y, 0.0)], None, None),
            PlaceAt::Table(written) => {
                let table = Obstacle::on_floor(written.at.into(), written.size.into(), written.heading);
                let sides = written.sides(faults)?;
                let stands = sides.iter().map(|(turn, along_m)| before(&table, *turn, *along_m, radius_m).0);
                let &(turn, along_m) = sides.first()?;
                (stands.collect(), Some(before(&table, turn, along_m, radius_m).1), Some(table))
            }
        };
        if let Some(heading) = self.heading {
            stands.iter_mut().for_each(|stand| stand.heading = heading);
        }
        let stand = stands.remove(0);
        let by_itself = on_table.map_or(SURFACE, |point| stand.to_local(point));
        let is_surface_told = self.surface.is_some() || table.is_some();
        let surface = self.surface.unwrap_or(by_itself);
        let count = if is_surface_told { objects.clamp(1, IN_A_ROW * MOST_ROWS) } else { IN_A_ROW };
        let spots = table.as_ref().map_or_else(|| side_by_side(&stand, surface, count), spots);
        Some(PlaceSpec { stand, others: stands, surface, is_surface_told, table, spots })
    }
}

impl Table {
    /// At which sides the base may stand, and how far along them.
    fn sides(&self, faults: &mut Faults) -> Option<Vec<(f64, f64)>> {
        let Some(written) = &self.stands else {
            let turn = self.side.as_ref().map_or(Some(0.0), |side| turn_of(side, faults))?;
            return Some(vec![(turn, 0.0)]);
        };
        if let Some(side) = &self.side {
            faults.push_with(side, "`side` and `stands` both tell where the base stands", "leave one of them out");
        }
        let stands = &written.value;
        if stands.is_empty() {
            faults.push_with(written, "no stands, where a table has at least one", "such as `{front: {side: front}}`");
        }
        let (most, found) = (MAX_STANDS, stands.len());
        if let Some((name, _)) = stands.get(most) {
            faults.push(name, format!("{found} stands, where a table has at most {most}"));
        }
        let sides = stands.iter().map(|(_, stand)| {
            let stand = stand.as_ref()?;
            Some((turn_of(&stand.side, faults)?, stand.along_m))
        });
        let sides: Option<Vec<_>> = sides.collect::<Vec<_>>().into_iter().collect();
        sides.filter(|_| !stands.is_empty() && found <= most)
    }
}

/// Where so many things are put down on a surface of which nothing is known but its middle: side by side as they lie at the
/// start, and in rows behind each other.
fn side_by_side(stand: &Pose, surface: Point3<f64>, count: usize) -> Vec<Point3<f64>> {
    let in_row = |index| spread(index % IN_A_ROW, count.min(IN_A_ROW));
    let behind = |index: usize| Vector3::new((index / IN_A_ROW) as f64 * SPOT_M, 0.0, 0.0);
    (0..count).map(|index| stand.to_map(surface + in_row(index) + behind(index))).collect()
}

/// Where things are put down on a table, row by row: as far apart as hands need, from edge to edge.
fn spots(table: &Obstacle) -> Vec<Point3<f64>> {
    let room = |side_m: f64| (side_m - 2.0 * EDGE_M).max(0.0);
    let (x, y) = (room(table.size.x), room(table.size.y));
    // A large table has its spots farther apart, so that there are not more of them than anybody looks through.
    let pitch_m = SPOT_M.max((x * y / MAX_SPOTS).sqrt()).max(x.max(y) / MAX_SPOTS);
    let along = |room_m: f64| {
        // As many on either side of the middle, so that what is as large as the table has one too.
        let count = ((room_m / pitch_m) as u32).next_multiple_of(2);
        let step_m = if count > 0 { room_m / f64::from(count) } else { 0.0 };
        (0..=count).map(move |index| (f64::from(index) - f64::from(count) / 2.0) * step_m)
    };
    let top_m = table.top_m();
    let rows = along(x).flat_map(|x| along(y).map(move |y| Point3::new(x, y, top_m)));
    rows.map(|local| table.pose().to_map(local)).collect()
}

/// What the stands of a place are called; none where it has only one.
pub(crate) fn stand_names(place: Option<&Place>) -> Vec<String> {
    let stands = place.and_then(|place| match &place.at {
        PlaceAt::Table(table) => table.stands.as_ref().map(|stands| &stands.value),
        PlaceAt::Stand(_) => None,
    });
    let several = stands.filter(|stands| stands.len() > 1);
    several.into_iter().flatten().map(|(name, _)| name.value.clone()).collect()
}

/// Which way the base faces that stands at a side of a table, in the table's frame, radians.
fn turn_of(side: &Name, faults: &mut Faults) -> Option<f64> {
    let sides = Register::of("side", ["front", "back", "left", "right"]);
    let turns = [0.0, PI, -FRAC_PI_2, FRAC_PI_2];
    sides.find(side, faults).map(|side| turns[side])
}

/// Where the base stands before a side of a table, so far to the left of its middle, and the point of the table before it;
/// map frame, meters.
fn before(table: &Obstacle, turn: f64, along_m: f64, radius_m: f64) -> (Pose, Point3<f64>) {
    let half_m = if turn.cos().abs() > 0.5 { table.size.x } else { table.size.y } / 2.0;
    let (middle, heading) = (table.middle.xy(), table.heading + turn);
    let (back, left) = (Vector2::new(-heading.cos(), -heading.sin()), Vector2::new(-heading.sin(), heading.cos()));
    let stand = middle + back * (half_m + GAP_M + radius_m) + left * along_m;
    let point = middle + back * (half_m - INSET_M).max(0.0) + left * along_m;
    (Pose { at: stand, heading }, Point3::new(point.x, point.y, table.top_m()))
}

/// What is written, for faults.
pub(crate) struct Spans<'a> {
    pub(crate) start: &'a Written<[f64; 2]>,
    pub(crate) places: &'a [Name],
    pub(crate) objects: &'a [Name],
}

/// What of a room cannot be: two things in one spot, a base in a wall, an object beside its table.
pub(crate) fn check(spec: &WorldSpec, start: &WorldState, spans: &Spans<'_>, robot: &RobotSpec, faults: &mut Faults) {
    let solids = spec.solids();
    let name = |solid: usize| name_of(spec, spans, solid);
    let space = FreeSpace::new(&solids, robot.radius_m);
    if let Some(solid) = space.taken_by(start.base.at) {
        faults.push(spans.start, format!("the robot starts in {}", name(solid)));
    }
    for (place, written) in std::iter::zip(&spec.places, spans.places) {
        let is_several = !place.others.is_empty();
        for (stand, solid) in
            place.stands().enumerate().filter_map(|(index, stand)| Some((index, space.taken_by(stand.at)?)))
        {
            let which = if is_several { format!(" at its stand {}", stand + 1) } else { String::new() };
            let message = format!("the base cannot stand there{which}: {} is in the way", name(solid));
            faults.push_with(written, message, format!("it needs {:.2} m around its stand", robot.radius_m));
        }
    }
    for one in 0..solids.len() {
        let Some(place) = spec.table_of(one) else { continue };
        if let Some(other) = (0..one).find(|other| overlap(&solids[*other], &solids[one], SLACK_M)) {
            let message = format!("its table stands in {}", name(other));
            faults.push(&spans.places[place.index()], message);
        }
    }
    check_objects(spec, start, spans, faults);
}

fn check_objects(spec: &WorldSpec, start: &WorldState, spans: &Spans<'_>, faults: &mut Faults) {
    let solids = spec.solids();
    let mut lying: Vec<Lying> = Vec::new();
    for (index, written) in spans.objects.iter().enumerate() {
        let Some(Location::At(place)) = start.objects.get(index).copied() else { continue };
        let object = ObjectId::from(index);
        let spot = spec.own_spot(object, place);
        let thing = Lying { object, place, solid: spec.thing(object, place, spot) };
        if let Some(table) = spec.places[place.index()].table {
            check_on_table(spec, &thing, &table, (written, &spans.places[place.index()].value), faults);
        }
        let others = (0..solids.len()).filter(|solid| spec.table_of(*solid) != Some(place));
        if let Some(solid) =
            others.into_iter().find(|solid| !thing.is_point() && overlap(&solids[*solid], &thing.solid, SLACK_M))
        {
            let message = format!("it lies in {}", name_of(spec, spans, solid));
            faults.push_with(written, message, "see its `offset` and its `shape`");
        }
        if let Some(other) = lying.iter().find(|other| thing.meets(other, spec)) {
            let message = format!("it lies in the same spot as {}", spans.objects[other.object.index()].value);
            faults.push_with(written, message, "give one of them another `offset`");
        }
        lying.push(thing);
    }
}

/// What of an object on a table cannot be.
fn check_on_table(
    spec: &WorldSpec,
    thing: &Lying,
    table: &Obstacle,
    (written, place_name): (&Name, &str),
    faults: &mut Faults,
) {
    let solid = &thing.solid;
    let own = table.pose().to_local(solid.middle);
    if own.x.abs() > table.size.x / 2.0 + SLACK_M || own.y.abs() > table.size.y / 2.0 + SLACK_M {
        let message = format!("it floats beside the table of {place_name}");
        faults.push_with(written, message, "see its `offset`, and `size` of the table");
    }
    let above_m = solid.middle.z - solid.size.z / 2.0 - table.top_m();
    if above_m.abs() > SLACK_M {
        let how = if above_m > 0.0 { "floats above" } else { "is sunk into" };
        let message = format!("it {how} the table of {place_name}, by {:.2} m", above_m.abs());
        let is_of_place = spec.objects[thing.object.index()].offset.z.abs() <= SLACK_M;
        let help = if is_of_place { "see `surface` of the place" } else { "leave out the height of its `offset`" };
        faults.push_with(written, message, help);
    }
    let sides = |size: Vector3<f64>| (size.x.min(size.y), size.x.max(size.y));
    let ((short, long), (own_short, own_long)) = (sides(table.size), sides(solid.size));
    if own_short > short + SLACK_M || own_long > long + SLACK_M {
        let message = format!("it is larger than the table of {place_name}");
        faults.push_with(written, message, format!("the table is {short:.2} m by {long:.2} m"));
    }
}

/// An object as a mission begins.
struct Lying {
    object: ObjectId,
    place: PlaceId,
    solid: Obstacle,
}

impl Lying {
    fn is_point(&self) -> bool {
        self.solid.size.max() <= 0.0
    }

    /// Whether two things are into each other. A point is in whatever is where it is, if somebody told where one of them is: what
    /// lies side by side by itself may lie close.
    fn meets(&self, other: &Self, spec: &WorldSpec) -> bool {
        if !self.is_point() && !other.is_point() {
            return overlap(&self.solid, &other.solid, SLACK_M);
        }
        let is_told = |thing: &Self| spec.objects[thing.object.index()].is_offset_told;
        self.place == other.place
            && (is_told(self) || is_told(other))
            && (self.solid.middle - other.solid.middle).xy().norm() < SLACK_M
    }
}

/// What one of the solids of a room is called.
fn name_of(spec: &WorldSpec, spans: &Spans<'_>, solid: usize) -> String {
    match spec.table_of(solid) {
        Some(place) => format!("the table of {}", spans.places[place.index()].value),
        None => "a wall or an obstacle".to_owned(),
    }
}

/// Side by side from right to left, so that two arms can take two objects from one surface.
pub(crate) fn spread(index: usize, count: usize) -> Vector3<f64> {
    let share = match count {
        0 | 1 => 0.5,
        several => index as f64 / (several - 1) as f64,
    };
    Vector3::new(0.0, (share - 0.5) * SPREAD_M, 0.0)
}
