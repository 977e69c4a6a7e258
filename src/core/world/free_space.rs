//! Where the base can drive: the boxes of a world in an index, made once per mission.

use std::cell::Cell;

use nalgebra::Point2;
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};

use super::footprint::{Footprint, TURNS};
use ambidex_model::Obstacle;

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

    /// Way points around an obstacle, counterclockwise.
    pub(super) fn turns(&self, obstacle: usize) -> [Point2<f64>; TURNS] {
        self.footprints[obstacle].turns(self.radius_m)
    }

    pub(super) fn middle(&self, obstacle: usize) -> Point2<f64> {
        self.footprints[obstacle].middle()
    }
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
        AABB::from_corners(self.footprint.min.into(), self.footprint.max.into())
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
        let around = Footprint { min: envelope.lower().into(), max: envelope.upper().into() };
        around.entry(self.radius_m, self.a, self.b).is_some()
    }

    fn should_unpack_leaf(&self, leaf: &Indexed) -> bool {
        self.steps.add(1);
        leaf.footprint.stops(self.radius_m, self.a, self.b)
    }
}
