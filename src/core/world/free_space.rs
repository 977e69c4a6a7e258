//! Where the base can drive: the boxes of a world in an index, made once per mission.

use std::cell::Cell;

use nalgebra::Point2;
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};

use super::footprint::{Footprint, TURNS};
use ambidex_model::{MissionSpec, Obstacle, Pose, RobotSpec};

/// How far a base may be off the way that it follows, meters.
const OFF_M: f64 = 0.05;
/// How far the first look along a leg goes, meters; each further one goes twice as far.
const LOOK_M: f64 = 2.0;

/// The obstacles of a world for a base of some radius.
#[derive(Debug)]
pub struct FreeSpace {
    radius_m: f64,
    footprints: Vec<Footprint>,
    index: RTree<Indexed>,
}

/// Counts boxes, and groups of boxes, that were held against a leg: the measure of work.
#[derive(Debug, Default)]
pub(super) struct Steps(Cell<u32>);

#[derive(Debug)]
struct Indexed {
    obstacle: usize,
    footprint: Footprint,
}

impl FreeSpace {
    /// Of the room and the base of a mission.
    pub fn of(mission: &MissionSpec) -> Self {
        Self::with(mission, &[])
    }

    /// The same with what has come to stand in it.
    pub fn with(mission: &MissionSpec, more: &[Obstacle]) -> Self {
        Self::new(&[&mission.world.solids(), more].concat(), mission.robot.radius_m)
    }

    /// Of what has come to stand in a room alone, for a base that may be a little off its way.
    pub fn of_what_came(robot: &RobotSpec, came: &[Obstacle]) -> Self {
        Self::new(came, (robot.radius_m - OFF_M).max(0.0))
    }

    /// Whether the base can follow a way to its end from where it is, which is somewhere on it.
    pub fn is_free(&self, from: Point2<f64>, way: &[Pose]) -> bool {
        let legs = way.windows(2).enumerate().map(|(index, leg)| (off_m(leg[0].at, leg[1].at, from), index + 1));
        let next = legs.min_by(|one, other| one.0.total_cmp(&other.0)).map_or(0, |(_, next)| next);
        let steps = Steps::default();
        let mut begin = from;
        way[next..].iter().all(|pose| {
            let leg = (std::mem::replace(&mut begin, pose.at), pose.at);
            self.stopped_by(leg.0, leg.1, &steps).is_none()
        })
    }

    /// Heights do not matter: whatever stands somewhere is in the way.
    pub fn new(obstacles: &[Obstacle], radius_m: f64) -> Self {
        let footprints: Vec<_> = obstacles.iter().map(Footprint::of).collect();
        let indexed = footprints.iter().enumerate().map(|(obstacle, &footprint)| Indexed { obstacle, footprint });
        let index = RTree::bulk_load(indexed.collect());
        Self { radius_m, footprints, index }
    }

    /// What stops the base first, or nearly so, on a straight leg; none where it is free.
    pub(super) fn stopped_by(&self, a: Point2<f64>, b: Point2<f64>, steps: &Steps) -> Option<usize> {
        let length_m = nalgebra::distance(&a, &b);
        let (mut begin, mut look_m, mut looked_m) = (a, LOOK_M, 0.0);
        loop {
            looked_m += look_m;
            let end = if looked_m < length_m { a + (b - a) * (looked_m / length_m) } else { b };
            let swept = Swept { radius_m: self.radius_m, a: begin, b: end, steps };
            let stopping = self.index.locate_with_selection_function(swept);
            let entry = |indexed: &Indexed| indexed.footprint.entry(self.radius_m, begin, end).unwrap_or(1.0);
            let first = stopping.map(|indexed| (entry(indexed), indexed.obstacle));
            let first = first.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            if first.is_some() || end == b {
                return first.map(|(_, obstacle)| obstacle);
            }
            (begin, look_m) = (end, 2.0 * look_m);
        }
    }

    /// What a base would touch that stands there, first in their order; none where it stands free.
    pub fn taken_by(&self, at: Point2<f64>) -> Option<usize> {
        let steps = Steps::default();
        let swept = Swept { radius_m: self.radius_m, a: at, b: at, steps: &steps };
        self.index.locate_with_selection_function(swept).map(|indexed| indexed.obstacle).min()
    }

    /// Way points around an obstacle, counterclockwise.
    pub(super) fn turns(&self, obstacle: usize) -> [Point2<f64>; TURNS] {
        self.footprints[obstacle].turns(self.radius_m)
    }
}

/// How far a point is from a leg, meters.
fn off_m(a: Point2<f64>, b: Point2<f64>, point: Point2<f64>) -> f64 {
    let leg = b - a;
    let share = if leg.norm_squared() > 0.0 { (point - a).dot(&leg) / leg.norm_squared() } else { 0.0 };
    nalgebra::distance(&(a + leg * share.clamp(0.0, 1.0)), &point)
}

impl Steps {
    pub(super) fn count(&self) -> u32 {
        self.0.get()
    }

    pub(super) fn add(&self, more: u32) {
        self.0.set(self.0.get().saturating_add(more));
    }
}

impl RTreeObject for Indexed {
    type Envelope = AABB<[f64; 2]>;

    fn envelope(&self) -> Self::Envelope {
        let (min, max) = self.footprint.bounds();
        AABB::from_corners(min.into(), max.into())
    }
}

/// Selects what a disc touches on a straight leg.
struct Swept<'a> {
    radius_m: f64,
    a: Point2<f64>,
    b: Point2<f64>,
    steps: &'a Steps,
}

impl SelectionFunction<Indexed> for Swept<'_> {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 2]>) -> bool {
        self.steps.add(1);
        let around = Footprint::along_axes(envelope.lower().into(), envelope.upper().into());
        around.entry(self.radius_m, self.a, self.b).is_some()
    }

    fn should_unpack_leaf(&self, leaf: &Indexed) -> bool {
        self.steps.add(1);
        leaf.footprint.stops(self.radius_m, self.a, self.b)
    }
}
