//! The ground that an upright box covers, and how a disc gets past it.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point2, Rotation2, Vector2};

use ambidex_model::Obstacle;

/// Way points around one corner of a box: the arc that the disc's middle would drive lies within their edges.
const FAN: usize = 4;
/// Way points around a box.
pub(super) const TURNS: usize = 4 * FAN;
/// How much farther from a box than it must a way point lies, so that a leg along the box touches nothing, meters.
const CLEARANCE_M: f64 = 1e-4;

/// What is no farther than this is touched, meters: a sum of coordinates is not exact.
const TOUCH_M: f64 = 1e-9;

/// A rectangle, upright in a frame that is the map's turned about its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Footprint {
    /// None where that frame is the map's.
    turn: Option<Rotation2<f64>>,
    min: Point2<f64>,
    max: Point2<f64>,
}

impl Footprint {
    pub(super) fn of(obstacle: &Obstacle) -> Self {
        let turn = (obstacle.heading != 0.0).then(|| Rotation2::new(obstacle.heading));
        let middle = obstacle.middle.xy();
        let middle = turn.map_or(middle, |turn| turn.inverse() * middle);
        let half = obstacle.size.xy() / 2.0;
        Self { turn, min: middle - half, max: middle + half }
    }

    /// A rectangle along the axes of the map.
    pub(super) fn along_axes(min: Point2<f64>, max: Point2<f64>) -> Self {
        Self { turn: None, min, max }
    }

    /// Lower and upper corner of the smallest rectangle along the axes of the map around it.
    pub(super) fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let corners = self.corners().map(|corner| self.to_map(corner));
        let first = corners[0];
        corners.iter().fold((first, first), |(min, max), corner| (min.inf(corner), max.sup(corner)))
    }

    /// Whether a disc that moves straight from `a` to `b` touches it.
    pub(super) fn stops(&self, radius_m: f64, a: Point2<f64>, b: Point2<f64>) -> bool {
        let (radius_m, a, b) = (radius_m + TOUCH_M, self.to_own(a), self.to_own(b));
        if self.own_entry(radius_m, a, b).is_none() {
            return false;
        }
        let is_near = |distance_squared: f64| distance_squared <= radius_m * radius_m;
        self.own_entry(0.0, a, b).is_some()
            || [a, b].iter().any(|end| is_near((end - self.nearest(*end)).norm_squared()))
            || self.corners().iter().any(|&corner| is_near((corner - nearest_of_leg(a, b, corner)).norm_squared()))
    }

    /// How far a point is from it, meters; 0 within it.
    pub(super) fn distance_m(&self, point: Point2<f64>) -> f64 {
        let own = self.to_own(point);
        (own - self.nearest(own)).norm()
    }

    /// Whether one who moves straight from `a` to `b` comes no nearer to it on the way.
    pub(super) fn is_left_behind(&self, a: Point2<f64>, b: Point2<f64>) -> bool {
        let (a, b) = (self.to_own(a), self.to_own(b));
        // The distance from what is convex is convex along a line.
        (a - self.nearest(a)).dot(&(b - a)) >= 0.0
    }

    /// The share of the way from `a` to `b` at which the way enters the rectangle, made wider by a margin on every side.
    pub(super) fn entry(&self, margin_m: f64, a: Point2<f64>, b: Point2<f64>) -> Option<f64> {
        self.own_entry(margin_m + TOUCH_M, self.to_own(a), self.to_own(b))
    }

    fn own_entry(&self, margin_m: f64, a: Point2<f64>, b: Point2<f64>) -> Option<f64> {
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let (low, high) = (self.min[axis] - margin_m, self.max[axis] + margin_m);
            let way = b[axis] - a[axis];
            if way == 0.0 {
                if a[axis] < low || a[axis] > high {
                    return None;
                }
            } else {
                let (first, second) = ((low - a[axis]) / way, (high - a[axis]) / way);
                enters = enters.max(first.min(second));
                leaves = leaves.min(first.max(second));
            }
        }
        (enters <= leaves).then_some(enters)
    }

    /// Way points around it, counterclockwise: a convex polygon that keeps a disc clear of it.
    pub(super) fn turns(&self, radius_m: f64) -> [Point2<f64>; TURNS] {
        let step = FRAC_PI_2 / FAN as f64;
        let out_m = (radius_m + CLEARANCE_M) / (step / 2.0).cos();
        let corners = self.corners();
        std::array::from_fn(|turn| {
            let angle = (turn as f64 + 0.5) * step;
            self.to_map(corners[turn / FAN] + Vector2::new(angle.cos(), angle.sin()) * out_m)
        })
    }

    fn to_own(self, point: Point2<f64>) -> Point2<f64> {
        self.turn.map_or(point, |turn| turn.inverse() * point)
    }

    fn to_map(self, point: Point2<f64>) -> Point2<f64> {
        self.turn.map_or(point, |turn| turn * point)
    }

    /// In its own frame, counterclockwise, the upper right one first: so is the first quadrant.
    fn corners(&self) -> [Point2<f64>; 4] {
        let (min, max) = (self.min, self.max);
        [max, Point2::new(min.x, max.y), min, Point2::new(max.x, min.y)]
    }

    fn nearest(&self, to: Point2<f64>) -> Point2<f64> {
        to.sup(&self.min).inf(&self.max)
    }
}

/// The outermost of a polygon's points as seen from a point; all of them from within it.
pub(super) fn outermost(polygon: &[Point2<f64>; TURNS], from: Point2<f64>) -> Vec<usize> {
    let is_left = |a: Point2<f64>, b: Point2<f64>| (a - from).perp(&(b - from)) > 0.0;
    if (0..TURNS).all(|turn| is_left(polygon[turn], polygon[(turn + 1) % TURNS])) {
        return (0..TURNS).collect();
    }
    let others = || (0..TURNS).filter(|&turn| polygon[turn] != from);
    let left = others().reduce(|best, turn| if is_left(polygon[best], polygon[turn]) { turn } else { best });
    let right = others().reduce(|best, turn| if is_left(polygon[turn], polygon[best]) { turn } else { best });
    left.into_iter().chain(right).collect()
}

fn nearest_of_leg(a: Point2<f64>, b: Point2<f64>, to: Point2<f64>) -> Point2<f64> {
    let way = b - a;
    let length_squared = way.norm_squared();
    if length_squared == 0.0 {
        return a;
    }
    a + way * ((to - a).dot(&way) / length_squared).clamp(0.0, 1.0)
}
