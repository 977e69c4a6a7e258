//! Where meters of the map lie on the page.

use nalgebra::Point2;

use crate::svg::page::{MARGIN, PAGE_WIDTH};

/// Height of title and note above the room.
pub(super) const HEAD: f64 = 44.0;
/// Room left of and below the room for the meters, user units.
const AXIS: f64 = 22.0;
/// Most height of the room on the page, user units.
const MOST_HEIGHT: f64 = 720.0;
/// Most user units that a meter gets.
const MOST_SCALE: f64 = 140.0;
/// Free around everything, meters.
const AROUND_M: f64 = 0.4;

/// A part of the map on the page; up on the page is y of the map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    min: Point2<f64>,
    max: Point2<f64>,
    /// User units per meter.
    pub(super) scale: f64,
    left: f64,
}

impl Plan {
    /// Of all these points.
    pub(super) fn around(points: impl IntoIterator<Item = Point2<f64>>) -> Self {
        let mut points = points.into_iter();
        let first = points.next().unwrap_or_default();
        let (min, max) = points.fold((first, first), |(min, max), point| (min.inf(&point), max.sup(&point)));
        let around = nalgebra::Vector2::repeat(AROUND_M);
        let (min, max) = (min - around, max + around);
        let (width, height) = (max.x - min.x, max.y - min.y);
        let room = PAGE_WIDTH - 2.0 * MARGIN - AXIS;
        let scale = (room / width).min(MOST_HEIGHT / height).min(MOST_SCALE);
        let left = MARGIN + AXIS + (room - width * scale) / 2.0;
        Self { min, max, scale, left }
    }

    pub(super) fn at(&self, point: Point2<f64>) -> (f64, f64) {
        (self.left + (point.x - self.min.x) * self.scale, HEAD + (self.max.y - point.y) * self.scale)
    }

    /// Left, top, right and bottom of the room on the page.
    pub(super) fn frame(&self) -> (f64, f64, f64, f64) {
        let ((left, bottom), (right, top)) = (self.at(self.min), self.at(self.max));
        (left, top, right, bottom)
    }

    /// Size of the page.
    pub(super) fn page(&self) -> (f64, f64) {
        (PAGE_WIDTH, self.frame().3 + AXIS + MARGIN)
    }

    /// Round meters along x, then along y, each with its place on the page.
    pub(super) fn ticks(&self) -> [Vec<(f64, f64)>; 2] {
        let widest_m = (self.max - self.min).max();
        let step_m = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 1000.0, 10_000.0, 100_000.0];
        let step_m = step_m.into_iter().find(|step_m| widest_m / step_m <= 14.0).unwrap_or(1e6);
        let along = |from: f64, to: f64| {
            let first = (from / step_m).ceil() as i64;
            let last = (to / step_m).floor() as i64;
            (first..=last).map(move |tick| tick as f64 * step_m)
        };
        let x = along(self.min.x, self.max.x).map(|x| (x, self.at(Point2::new(x, self.min.y)).0));
        let y = along(self.min.y, self.max.y).map(|y| (y, self.at(Point2::new(self.min.x, y)).1));
        [x.collect(), y.collect()]
    }
}
