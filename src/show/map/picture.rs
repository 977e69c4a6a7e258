//! The room from above as a picture.

use nalgebra::{Point2, Point3, Vector2};

use ambidex_model::{ObjectId, Obstacle, PlaceId, Pose, ResourceId};

use super::plan::Plan;
use super::scene::{Drive, Scene};
use crate::svg::fit::{self, NOTE, SMALL, TITLE};
use crate::svg::page::{MARGIN, PAGE_WIDTH, Shape, page};
use crate::text::count;
use crate::text::phrase::listed;

/// Half the side of a surface of which only the middle is known, meters.
const SURFACE_M: f64 = 0.12;
/// Radius of an object, user units.
const OBJECT: f64 = 3.2;
/// Least distance of two numbers of steps, user units.
const APART: f64 = 15.0;

/// The room from above: obstacles, places with stand and surface, objects, the robot with what its arms reach at the height
/// of a surface, and the drives of a run, numbered by step.
pub fn picture(scene: &Scene) -> String {
    let plan = Plan::around(extent(scene));
    let mut shapes = head(scene);
    shapes.extend(grid(&plan));
    let (left, top, right, bottom) = plan.frame();
    shapes.extend(obstacles(scene, &plan));
    shapes.extend(reaches(scene, &plan));
    shapes.extend(scene.drives.iter().map(|drive| way(drive, scene, &plan)));
    shapes.extend(places(scene, &plan));
    shapes.extend(objects(scene, &plan));
    shapes.push(robot(scene, &plan));
    shapes.extend(numbers(scene, &plan));
    let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
    shapes.push(Shape::path("line", &corners, true));
    let mission = &scene.mission.name;
    let description = format!("The room of the mission {mission} from above: {}.", figures(scene));
    page(&format!("{mission}: map"), &description, plan.page(), shapes)
}

fn figures(scene: &Scene) -> String {
    let world = &scene.mission.world;
    let objects = scene.world().objects.len();
    let all = [(world.places.len(), "place"), (objects, "object"), (world.obstacles.len(), "obstacle")];
    all.map(|(number, noun)| count(number, noun)).join(", ")
}

fn head(scene: &Scene) -> Vec<Shape> {
    let width = PAGE_WIDTH - 2.0 * MARGIN;
    let mut note = format!("robot {} · {}", scene.mission.robot.name, figures(scene));
    if let Some(now) = scene.now() {
        note += &format!(
            " · at {:.1} s: {}, {}",
            now.seconds(),
            count(scene.steps(), "step"),
            count(scene.drives.len(), "drive")
        );
    }
    vec![
        Shape::text("title", (MARGIN, MARGIN + 12.0), &fit::clip(&scene.mission.name, TITLE, width)),
        Shape::text("note", (MARGIN, MARGIN + 26.0), &fit::clip(&note, NOTE, width)),
    ]
}

/// Whatever is to be seen.
fn extent(scene: &Scene) -> Vec<Point2<f64>> {
    let (mission, world) = (&scene.mission, &scene.mission.world);
    let radius = Vector2::repeat(mission.robot.radius_m);
    let around = |at: Point2<f64>| [at - radius, at + radius];
    let mut points: Vec<_> = around(scene.base().at).into();
    points.extend(around(mission.start.base.at));
    for (index, place) in world.places.iter().enumerate() {
        points.extend(place.stands().flat_map(|stand| around(stand.at)));
        points.push(scene.mission.world.surface(PlaceId::from(index)).xy());
    }
    let of_reach = |reach: Reach| [-1.0, 1.0].map(|side| reach.middle + Vector2::repeat(reach.radius_m * side));
    points.extend(reached(scene).flat_map(of_reach));
    points.extend(world.solids().iter().chain(&scene.world().obstacles).flat_map(Obstacle::corners));
    points.extend(scene.drives.iter().flat_map(|drive| &drive.way).map(|pose| pose.at));
    points
}

fn grid(plan: &Plan) -> Vec<Shape> {
    let (left, top, right, bottom) = plan.frame();
    let [along_x, along_y] = plan.ticks();
    let mut shapes = Vec::new();
    for (meters, x) in along_x {
        shapes.push(Shape::line("grid-line", (x, top), (x, bottom)));
        shapes.push(Shape::text("small middle", (x, bottom + 11.0), &format!("{meters} m")));
    }
    for (meters, y) in along_y {
        shapes.push(Shape::line("grid-line", (left, y), (right, y)));
        shapes.push(Shape::text("small end", (left - 4.0, y + 3.0), &format!("{meters}")));
    }
    shapes
}

fn obstacles(scene: &Scene, plan: &Plan) -> Vec<Shape> {
    let drawn = |obstacle: &Obstacle, what: &str| {
        let shape = Shape::path("obstacle", &obstacle.corners().map(|corner| plan.at(corner)), true);
        shape.titled(&format!("{what}, {:.2} m high", obstacle.top_m()))
    };
    let known = scene.mission.world.obstacles.iter().map(|obstacle| drawn(obstacle, "an obstacle"));
    let came = scene.world().obstacles.iter().map(|obstacle| drawn(obstacle, "what has come to stand there"));
    known.chain(came).collect()
}

/// A stand with its direction, the surface before it, and its name.
fn places(scene: &Scene, plan: &Plan) -> Vec<Shape> {
    let places = scene.mission.world.places.iter().enumerate().map(|(index, place)| {
        let name = scene.names().place(PlaceId::from(index));
        let corner = |x: f64, y: f64| {
            let local = place.surface + nalgebra::Vector3::new(x, y, 0.0) * SURFACE_M;
            plan.at(place.stand.to_map(local).xy())
        };
        let about = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let corners = place.table.map_or(about, |table| table.corners().map(|corner| plan.at(corner)));
        let surface = scene.mission.world.surface(PlaceId::from(index));
        let middle = plan.at(surface.xy());
        let stand = plan.at(place.stand.at);
        let label = match place.table {
            Some(table) => {
                let middle = plan.at(table.middle.xy());
                let about = |of: fn(&(f64, f64)) -> f64, middle: f64| {
                    corners.iter().map(|corner| (of(corner) - middle).abs()).fold(0.0, f64::max)
                };
                let (wide_px, high_px) = (about(|at| at.0, middle.0), about(|at| at.1, middle.1));
                // At its upper or its left end: things lie about its middle.
                let half_px = fit::width(name, TITLE) / 2.0;
                let at_left = (middle.0 + (half_px + 4.0 - wide_px).min(0.0), middle.1);
                let (x, y) = if high_px > wide_px { (middle.0, middle.1 - high_px + APART) } else { at_left };
                (x, y + 4.0)
            }
            None => beyond(stand, middle, SURFACE_M * plan.scale + 12.0),
        };
        let stands = place.stands().enumerate().flat_map(|(which, stand)| {
            let own = scene.names().stands.get(index).and_then(|names| names.get(which));
            let title = own.map_or(name.to_owned(), |own| format!("{name} ({own})"));
            let ahead = plan.at(stand.to_map(Point3::new(0.18, 0.0, 0.0)).xy());
            let at = plan.at(stand.at);
            let title = format!("{title}: the robot stands at ({:.2}, {:.2})", stand.at.x, stand.at.y);
            [
                Shape::line("step", at, middle),
                Shape::circle("stand", at, 4.0).titled(&title),
                Shape::line("heading", at, ahead),
            ]
        });
        let surface = Shape::path("surface", &corners, true);
        let name = Shape::text("head middle", label, name);
        Shape::group("place", [surface].into_iter().chain(stands).chain([name]))
    });
    places.collect()
}

/// A point on the page so far behind a surface as seen from its stand, for the middle of a name.
fn beyond(stand: (f64, f64), surface: (f64, f64), by: f64) -> (f64, f64) {
    let (x, y) = (surface.0 - stand.0, surface.1 - stand.1);
    let length = x.hypot(y);
    if length < 1.0 {
        return (surface.0, surface.1 + by + 4.0);
    }
    // Names are wider than high.
    (surface.0 + x / length * (by + 14.0), surface.1 + y / length * by + 4.0)
}

fn objects(scene: &Scene, plan: &Plan) -> Vec<Shape> {
    let shown = (0..scene.world().objects.len()).map(ObjectId::from).filter_map(|object| {
        let world = &scene.mission.world;
        let middle = world.object(scene.world(), object)?;
        let place = scene.world().objects[object.index()].place()?;
        let thing = world.thing(object, place, middle);
        let (at, name) = (plan.at(middle.xy()), scene.names().object(object).to_owned());
        let round_px = thing.size.x / 2.0 * plan.scale;
        let (body, beside_px) = match world.objects[object.index()].shape {
            Some(ambidex_model::Shape::Box(_)) => {
                (Shape::path("thing", &thing.corners().map(|corner| plan.at(corner)), true), round_px)
            }
            Some(ambidex_model::Shape::Cylinder { .. }) => (Shape::circle("thing", at, round_px), round_px),
            None => (Shape::circle("thing", at, OBJECT), OBJECT),
        };
        let text = Shape::text("inner", (at.0 + beside_px + 2.0, at.1 - OBJECT), &fit::clip(&name, SMALL, 80.0));
        Some(Shape::group("object", [body, text]).titled(&name))
    });
    shown.collect()
}

/// What an arm reaches at the height of the surfaces, from where the base is.
struct Reach {
    resource: ResourceId,
    middle: Point2<f64>,
    radius_m: f64,
    height_m: f64,
}

fn reached(scene: &Scene) -> impl Iterator<Item = Reach> + '_ {
    let robot = &scene.mission.robot;
    let places = &scene.mission.world.places;
    let height_m = places.first().map_or(0.0, |place| place.surface.z);
    (0..robot.resources.len()).map(ResourceId::from).filter_map(move |resource| {
        let arm = robot.arm(resource)?;
        let rise_m = height_m - arm.shoulder.z;
        let radius_m = (arm.reach_m.powi(2) - rise_m.powi(2)).max(0.0).sqrt();
        Some(Reach { resource, middle: scene.base().to_map(arm.shoulder).xy(), radius_m, height_m })
    })
}

fn reaches(scene: &Scene, plan: &Plan) -> Vec<Shape> {
    let circle = |Reach { resource, middle, radius_m, height_m }| {
        let said = format!("{} reaches so far, {height_m:.2} m high", scene.names().resource(resource));
        Shape::circle("reach", plan.at(middle), radius_m * plan.scale).titled(&said)
    };
    reached(scene).map(circle).collect()
}

fn robot(scene: &Scene, plan: &Plan) -> Shape {
    let (base, radius_m) = (scene.base(), scene.mission.robot.radius_m);
    let middle = plan.at(base.at);
    let nose = plan.at(base.to_map(Point3::new(radius_m, 0.0, 0.0)).xy());
    let held: Vec<_> = scene.world().objects.iter().enumerate().filter(|(_, at)| !at.holders().is_empty()).collect();
    let names: Vec<_> =
        held.iter().map(|(object, _)| scene.names().object(ObjectId::from(*object)).to_owned()).collect();
    let mut shapes = Vec::new();
    if let Some(first) = scene.drives.first() {
        shapes.push(Shape::circle("start", plan.at(first.way[0].at), radius_m * plan.scale));
    }
    shapes.push(Shape::circle("robot", middle, radius_m * plan.scale));
    shapes.push(Shape::line("heading", middle, nose));
    if !names.is_empty() {
        let text = format!("holds {}", listed(&names));
        shapes.push(Shape::text("inner middle", (middle.0, middle.1 + 4.0), &fit::clip(&text, SMALL, 120.0)));
    }
    Shape::group("robot-at", shapes).titled(&scene.mission.robot.name)
}

fn way(drive: &Drive, scene: &Scene, plan: &Plan) -> Shape {
    let points: Vec<_> = drive.way.iter().map(|pose| plan.at(pose.at)).collect();
    let mut shapes = vec![Shape::path("drive", &points, false)];
    shapes.extend(arrow(&points));
    Shape::group("drive-of", shapes).titled(&format!("step {}: {}", drive.step, scene.names().node(drive.leaf)))
}

/// The tip of the last leg that is long enough to have one.
fn arrow(points: &[(f64, f64)]) -> Option<Shape> {
    let [.., from, to] = points else { return None };
    let (x, y) = (to.0 - from.0, to.1 - from.1);
    let length = x.hypot(y);
    if length < 8.0 {
        return None;
    }
    let (x, y) = (x / length, y / length);
    let back = |aside: f64| (to.0 - 9.0 * x - 4.0 * aside * y, to.1 - 9.0 * y + 4.0 * aside * x);
    Some(Shape::path("arrow", &[*to, back(1.0), back(-1.0)], true))
}

/// The numbers of the steps on their ways, apart from each other.
fn numbers(scene: &Scene, plan: &Plan) -> Vec<Shape> {
    let mut taken: Vec<(f64, f64)> = Vec::new();
    let mut shapes = Vec::new();
    for drive in &scene.drives {
        let spots = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8].map(|share| plan.at(along(&drive.way, share)));
        let is_free =
            |spot: &&(f64, f64)| taken.iter().all(|other| (other.0 - spot.0).hypot(other.1 - spot.1) >= APART);
        let (x, y) = *spots.iter().find(is_free).unwrap_or(&spots[0]);
        taken.push((x, y));
        let text = drive.step.to_string();
        let radius = (fit::width(&text, SMALL) / 2.0 + 2.0).max(6.5);
        shapes.push(Shape::circle("number", (x, y), radius));
        shapes.push(Shape::text("inner middle", (x, y + 3.0), &text));
    }
    shapes
}

/// The point at a share of a way.
fn along(way: &[Pose], share: f64) -> Point2<f64> {
    let lengths = || way.windows(2).map(|leg| leg[0].distance_m(&leg[1]));
    let mut left_m = lengths().sum::<f64>() * share;
    for (leg, length_m) in std::iter::zip(way.windows(2), lengths()) {
        if left_m <= length_m && length_m > 0.0 {
            return leg[0].at + (leg[1].at - leg[0].at) * (left_m / length_m);
        }
        left_m -= length_m;
    }
    way.last().map_or_else(Point2::origin, |pose| pose.at)
}
