//! Things that can be seen: places, what is in the way, the robot's body, and objects where their positions are known.

use std::sync::Arc;

use ambidex_model::{Location, MissionSpec, ObjectId, Obstacle, PlaceId, ResourceId, Shape};
use ambidex_record::History;
use nalgebra::{Point3, Vector3};

use super::foxglove::{Color, Cube, Cylinder, Deletion, Entity, Pose, SceneUpdate, Stamp, Text, Vector};
use super::message::{Moment, Topic};
use super::poses::{BASE, MAP, Poses};

/// An object is shown as a box of this size, meters; what it looks like nobody has said.
const OBJECT_M: f64 = 0.08;
/// A surface is shown as a board of this size, meters.
const BOARD: Vector = Vector { x: 0.4, y: 0.8, z: 0.02 };
/// The body is shown so high, meters.
const BODY_M: f64 = 0.3;
const FONT_M: f64 = 0.08;

const OBJECT: Color = Color { r: 0.93, g: 0.54, b: 0.13, a: 1.0 };
const PLACE: Color = Color { r: 0.45, g: 0.55, b: 0.65, a: 0.6 };
const OBSTACLE: Color = Color { r: 0.4, g: 0.4, b: 0.4, a: 0.7 };
const BODY: Color = Color { r: 0.2, g: 0.5, b: 0.8, a: 0.5 };
const LETTERS: Color = Color { r: 0.5, g: 0.5, b: 0.5, a: 1.0 };

/// What was told of things.
#[derive(Debug)]
pub(super) struct Scene {
    mission: Arc<MissionSpec>,
    objects: Vec<Location>,
    /// What has come to stand in the room.
    came: Vec<Obstacle>,
}

impl Scene {
    /// Nothing was told.
    pub(super) fn new(mission: Arc<MissionSpec>) -> Self {
        Self { mission, objects: Vec::new(), came: Vec::new() }
    }

    /// Tells which objects are somewhere else now, or everything anew.
    pub(super) fn tell(&mut self, history: &History, poses: &Poses, is_anew: bool, moment: &mut Moment) {
        let (now, came) = (&history.world().objects, &history.world().obstacles);
        if *now == self.objects && *came == self.came && !is_anew {
            return;
        }
        let mut update = SceneUpdate::default();
        self.tell_obstacles(came, moment.stamp(), &mut update);
        if is_anew {
            update.entities.extend(self.fixtures(moment.stamp()));
        }
        for (index, at) in now.iter().enumerate() {
            if is_anew || self.objects.get(index) != Some(at) {
                self.tell_object(ObjectId::from(index), at, history, poses, moment.stamp(), &mut update);
            }
        }
        moment.say(Topic::Scene, &update);
        self.objects.clone_from(now);
        self.came.clone_from(came);
    }

    /// What has come to stand in the room, and what of it is gone.
    fn tell_obstacles(&self, came: &[Obstacle], timestamp: Stamp, update: &mut SceneUpdate<'_>) {
        let id = |index: usize| format!("obstacle that came {index}");
        for (index, obstacle) in came.iter().enumerate() {
            let mut entity = Entity::new(timestamp, MAP, id(index));
            entity.cubes.push(solid(obstacle, OBSTACLE));
            update.entities.push(entity);
        }
        let gone = came.len()..self.came.len();
        update.deletions.extend(gone.map(|index| Deletion { timestamp, ty: 0, id: id(index) }));
    }

    /// What never moves, and the body, which moves with its frame.
    fn fixtures<'a>(&self, timestamp: Stamp) -> Vec<Entity<'a>> {
        let MissionSpec { world, names, robot, .. } = &*self.mission;
        let places = world.places.iter().enumerate().map(move |(index, place)| {
            let name = names.place(PlaceId::from(index));
            let surface = world.surface(PlaceId::from(index));
            let mut entity = Entity::new(timestamp, MAP, format!("place {name}"));
            // Objects stand on it.
            entity.cubes.push(match place.table {
                Some(table) => solid(&table, PLACE),
                None => {
                    let pose = Pose::from(place.stand).moved_to(surface - Vector3::z() * (OBJECT_M / 2.0));
                    Cube { pose, size: BOARD, color: PLACE }
                }
            });
            entity.texts.push(label(name, surface - Vector3::z() * FONT_M * 2.0));
            entity
        });
        let obstacles = world.obstacles.iter().enumerate().map(move |(index, obstacle)| {
            let mut entity = Entity::new(timestamp, MAP, format!("obstacle {index}"));
            entity.cubes.push(solid(obstacle, OBSTACLE));
            entity
        });
        let mut body = Entity::new(timestamp, BASE, "robot".to_owned());
        let size = Vector { x: 2.0 * robot.radius_m, y: 2.0 * robot.radius_m, z: BODY_M };
        let pose = Point3::new(0.0, 0.0, BODY_M / 2.0).into();
        body.cylinders.push(Cylinder { pose, size, bottom_scale: 1.0, top_scale: 1.0, color: BODY });
        places.chain(obstacles).chain([body]).collect()
    }

    fn tell_object<'a>(
        &self,
        object: ObjectId,
        at: &Location,
        history: &'a History,
        poses: &Poses,
        timestamp: Stamp,
        update: &mut SceneUpdate<'a>,
    ) {
        let names = history.names();
        let (name, id) = (names.object(object), format!("object {}", names.object(object)));
        match self.position(object, at, history, poses) {
            Some((frame, point)) => {
                let mut entity = Entity::new(timestamp, frame, id);
                self.body(object, at.place(), point, &mut entity);
                entity.texts.push(label(name, point + Vector3::z() * OBJECT_M));
                update.entities.push(entity);
            }
            None => update.deletions.push(Deletion { timestamp, ty: 0, id }),
        }
    }

    /// What an object looks like around its middle; in a hand it is turned like that.
    fn body(&self, object: ObjectId, place: Option<PlaceId>, middle: Point3<f64>, entity: &mut Entity<'_>) {
        let shape = self.mission.world.objects.get(object.index()).and_then(|spec| spec.shape);
        let thing = place.map(|place| self.mission.world.thing(object, place, middle));
        let pose = thing.map_or(middle.into(), |thing| Pose::from(thing.pose()).moved_to(middle));
        match shape {
            None => {
                let size = Vector::all(OBJECT_M);
                entity.cubes.push(Cube { pose: middle.into(), size, color: OBJECT });
            }
            Some(Shape::Box(size)) => {
                entity.cubes.push(Cube { pose, size: Point3::from(size).into(), color: OBJECT });
            }
            Some(Shape::Cylinder { radius_m, height_m }) => {
                let size = Vector { x: 2.0 * radius_m, y: 2.0 * radius_m, z: height_m };
                entity.cylinders.push(Cylinder { pose, size, bottom_scale: 1.0, top_scale: 1.0, color: OBJECT });
            }
        }
    }

    /// The frame in which an object is, and where; none where nobody knows.
    fn position<'a>(
        &self,
        object: ObjectId,
        at: &Location,
        history: &'a History,
        poses: &Poses,
    ) -> Option<(&'a str, Point3<f64>)> {
        let names = history.names();
        match at {
            Location::At(_) => Some((MAP, self.mission.world.object(history.world(), object)?)),
            Location::In(holders) => {
                let holder: &ResourceId = holders.as_slice().iter().find(|holder| poses.has(**holder, names))?;
                Some((names.resource(*holder), Point3::origin()))
            }
            Location::Unknown => None,
        }
    }
}

fn solid(of: &Obstacle, color: Color) -> Cube {
    Cube { pose: Pose::from(of.pose()).moved_to(of.middle), size: Point3::from(of.size).into(), color }
}

fn label(text: &str, at: Point3<f64>) -> Text {
    Text {
        pose: at.into(),
        billboard: true,
        font_size: FONT_M,
        scale_invariant: false,
        color: LETTERS,
        text: text.to_owned(),
    }
}
