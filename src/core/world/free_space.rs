//! Where the base can drive: the boxes of a world in an index, made once per mission.

use std::cell::Cell;

use nalgebra::Point2;
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};

use super::footprint::{Footprint, TURNS};
use ambidex_model::{MissionSpec, Obstacle, Pose, TALL_M};

/// How far a base may be off the way that it follows, meters: so much more room is left to what came to stand somewhere, so
/// that who drives past it is not taken to drive into it.
const OFF_M: f64 = 0.05;
/// How far the first look along a leg goes, meters; each further one goes twice as far.
const LOOK_M: f64 = 2.0;

/// The obstacles of a world for a base of some radius.
#[derive(Debug)]
pub struct FreeSpace {
    solids: Vec<Solid>,
    index: RTree<Indexed>,
    /// The greatest of their clearances.
    reach_m: f64,
}

/// What the middle of the base is kept off.
#[derive(Debug, Clone, Copy)]
struct Solid {
    footprint: Footprint,
    clearance_m: f64,
    /// Whether it begins above everything of a robot.
    hangs: bool,
}

/// Counts boxes, and groups of boxes, that were held against a leg: the measure of work.
#[derive(Debug, Default)]
pub(super) struct Steps(Cell<u32>);

#[derive(Debug)]
struct Indexed {
    obstacle: usize,
    solid: Solid,
}

/// Straight legs of a base that stands somewhere. What it touches there it may leave, straight and for good: it was put
/// there, or is where it was stopped.
#[derive(Debug, Clone, Copy)]
pub(super) struct Legs<'a> {
    pub(super) space: &'a FreeSpace,
    pub(super) start: Point2<f64>,
    pub(super) steps: &'a Steps,
}

impl FreeSpace {
    /// Of the room and the base of a mission.
    pub fn of(mission: &MissionSpec) -> Self {
        Self::with(mission, &[])
    }

    /// The same with what has come to stand in it.
    pub fn with(mission: &MissionSpec, more: &[Obstacle]) -> Self {
        let radius_m = mission.robot.radius_m;
        let solids = mission.world.solids();
        let more = more.iter().map(|came| Solid::of(came, radius_m + OFF_M));
        Self::of_solids(solids.iter().map(|solid| Solid::of(solid, radius_m)).chain(more).collect())
    }

    /// Whatever stands somewhere is in the way, however low; what hangs above everything of a robot is not.
    pub fn new(obstacles: &[Obstacle], radius_m: f64) -> Self {
        Self::of_solids(obstacles.iter().map(|obstacle| Solid::of(obstacle, radius_m)).collect())
    }

    fn of_solids(solids: Vec<Solid>) -> Self {
        let low = solids.iter().enumerate().filter(|(_, solid)| !solid.hangs);
        let indexed = low.map(|(obstacle, &solid)| Indexed { obstacle, solid });
        let index = RTree::bulk_load(indexed.collect());
        let reach_m = solids.iter().map(|solid| solid.clearance_m).fold(0.0, f64::max);
        Self { solids, index, reach_m }
    }

    /// Whether the base can follow a way to its end from where it is, which is somewhere on it.
    pub fn is_free(&self, from: Point2<f64>, way: &[Pose]) -> bool {
        let legs = way.windows(2).enumerate().map(|(index, leg)| (off_m(leg[0].at, leg[1].at, from), index + 1));
        let next = legs.min_by(|one, other| one.0.total_cmp(&other.0)).map_or(0, |(_, next)| next);
        let legs = Legs { space: self, start: from, steps: &Steps::default() };
        let mut begin = from;
        way[next..].iter().all(|pose| {
            let leg = (std::mem::replace(&mut begin, pose.at), pose.at);
            legs.stopped_by(leg.0, leg.1).is_none()
        })
    }

    /// What a base would touch that stands there, first in their order; none where it stands free.
    pub fn taken_by(&self, at: Point2<f64>) -> Option<usize> {
        self.touched(at, at, &Steps::default()).map(|indexed| indexed.obstacle).min()
    }

    /// Whether a point lies within an obstacle.
    pub(super) fn is_covered(&self, at: Point2<f64>) -> bool {
        self.touched(at, at, &Steps::default()).any(|indexed| indexed.solid.footprint.distance_m(at) == 0.0)
    }

    fn touched<'a>(
        &'a self,
        a: Point2<f64>,
        b: Point2<f64>,
        steps: &'a Steps,
    ) -> impl Iterator<Item = &'a Indexed> + 'a {
        self.index.locate_with_selection_function(Swept { reach_m: self.reach_m, a, b, steps })
    }

    /// Way points around an obstacle, counterclockwise.
    pub(super) fn turns(&self, obstacle: usize) -> [Point2<f64>; TURNS] {
        let Solid { footprint, clearance_m, .. } = self.solids[obstacle];
        footprint.turns(clearance_m)
    }
}

impl Solid {
    fn of(obstacle: &Obstacle, clearance_m: f64) -> Self {
        let hangs = obstacle.middle.z - obstacle.size.z / 2.0 >= TALL_M;
        Self { footprint: Footprint::of(obstacle), clearance_m, hangs }
    }

    /// Whether a leg only leads away from it, from where it is touched to where it is not.
    fn is_left(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        let Self { footprint, clearance_m, .. } = self;
        footprint.distance_m(from) > 0.0 && footprint.is_left_behind(from, to) && !footprint.stops(*clearance_m, to, to)
    }
}

impl Legs<'_> {
    /// What stops the base first, or nearly so, on a straight leg; none where it is free.
    pub(super) fn stopped_by(&self, a: Point2<f64>, b: Point2<f64>) -> Option<usize> {
        let length_m = nalgebra::distance(&a, &b);
        let (mut begin, mut look_m, mut looked_m) = (a, LOOK_M, 0.0);
        loop {
            looked_m += look_m;
            let end = if looked_m < length_m { a + (b - a) * (looked_m / length_m) } else { b };
            let stopping =
                self.space.touched(begin, end, self.steps).filter(|indexed| !self.is_left(indexed.solid, a, b));
            let entry = |Solid { footprint, clearance_m, .. }| footprint.entry(clearance_m, begin, end).unwrap_or(1.0);
            let first = stopping.map(|indexed| (entry(indexed.solid), indexed.obstacle));
            let first = first.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            if first.is_some() || end == b {
                return first.map(|(_, obstacle)| obstacle);
            }
            (begin, look_m) = (end, 2.0 * look_m);
        }
    }

    /// Whether the leg begins, or ends for who searches back, where the base stands, and leaves what it touches there.
    fn is_left(&self, solid: Solid, a: Point2<f64>, b: Point2<f64>) -> bool {
        a == self.start && solid.is_left(a, b) || b == self.start && solid.is_left(b, a)
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
        let (min, max) = self.solid.footprint.bounds();
        AABB::from_corners(min.into(), max.into())
    }
}

/// Selects what the base touches on a straight leg.
struct Swept<'a> {
    reach_m: f64,
    a: Point2<f64>,
    b: Point2<f64>,
    steps: &'a Steps,
}

impl SelectionFunction<Indexed> for Swept<'_> {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 2]>) -> bool {
        self.steps.add(1);
        let around = Footprint::along_axes(envelope.lower().into(), envelope.upper().into());
        around.entry(self.reach_m, self.a, self.b).is_some()
    }

    fn should_unpack_leaf(&self, leaf: &Indexed) -> bool {
        self.steps.add(1);
        leaf.solid.footprint.stops(leaf.solid.clearance_m, self.a, self.b)
    }
}
