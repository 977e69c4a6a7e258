//! The peer: a straight line, else A* on a grid of which every edge is tested against every box, pulled tight.

use nalgebra::Point2;
use parry3d::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d::query::intersection_test;
use parry3d::shape::{Capsule, Cuboid};
use pathfinding::prelude::astar;

use ambidex::model::{Obstacle, Pose};

/// Width of a cell, meters.
const CELL_M: f64 = 0.1;
/// How far around everything a path may lead, meters.
const MARGIN_M: f64 = 2.0;

/// Way points from `from` to `to`, the goal last, each with the goal's heading.
pub fn find(obstacles: &[Obstacle], radius_m: f64, from: Pose, to: Pose) -> Option<Vec<Pose>> {
    let room = Room { obstacles, radius_m };
    if room.is_free(from.at, to.at) {
        return Some(vec![to]);
    }
    let cells = room.search(from.at, to.at)?;
    let mut corners = room.tighten(from.at, &cells, to.at);
    corners.push(to.at);
    Some(corners.into_iter().map(|at| Pose { at, heading: to.heading }).collect())
}

struct Room<'a> {
    obstacles: &'a [Obstacle],
    radius_m: f64,
}

type Cell = (i32, i32);

impl Room<'_> {
    /// Whether the base can drive straight from one point to the other. Both lie on one level with the boxes.
    fn is_free(&self, a: Point2<f64>, b: Point2<f64>) -> bool {
        let swept = Capsule::new(flat(a), flat(b), self.radius_m as f32);
        self.obstacles.iter().all(|obstacle| {
            let half = obstacle.size * 0.5;
            let middle = obstacle.middle;
            let cuboid = Cuboid::new(ParryVector::new(half.x as f32, half.y as f32, 1.0));
            let at = ParryPose::from_translation(flat(middle.xy()));
            let test = intersection_test(&ParryPose::IDENTITY, &swept, &at, &cuboid);
            !test.expect("parry tests capsules against boxes").intersecting
        })
    }

    fn search(&self, from: Point2<f64>, to: Point2<f64>) -> Option<Vec<Cell>> {
        let (low, high) = self.bounds(from, to);
        let goal = cell(to);
        let estimate = |at: &Cell| steps(at.0 - goal.0, at.1 - goal.1);
        let next = |&(x, y): &Cell| {
            let around = (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| (dx, dy)));
            around
                .filter(|&step| step != (0, 0))
                .map(move |(dx, dy)| ((x + dx, y + dy), steps(dx, dy)))
                .filter(|&(at, _)| (low.0..=high.0).contains(&at.0) && (low.1..=high.1).contains(&at.1))
                .filter(|&(at, _)| self.is_free(middle((x, y)), middle(at)))
                .collect::<Vec<_>>()
        };
        let start = cell(from);
        if !self.is_free(from, middle(start)) || !self.is_free(middle(goal), to) {
            return None;
        }
        astar(&start, next, estimate, |at| *at == goal).map(|(path, _)| path)
    }

    fn bounds(&self, from: Point2<f64>, to: Point2<f64>) -> (Cell, Cell) {
        let boxes = self.obstacles.iter().flat_map(Obstacle::corners);
        let (mut low, mut high) = (from, from);
        for point in boxes.chain([to]) {
            low = low.inf(&point);
            high = high.sup(&point);
        }
        let margin = nalgebra::Vector2::repeat(MARGIN_M);
        (cell(low - margin), cell(high + margin))
    }

    /// The corners that a string pulled tight along the cells would touch.
    fn tighten(&self, from: Point2<f64>, cells: &[Cell], to: Point2<f64>) -> Vec<Point2<f64>> {
        let mut corners = Vec::new();
        let mut last = from;
        let points: Vec<_> = cells.iter().map(|&at| middle(at)).chain([to]).collect();
        for pair in points.windows(2) {
            if !self.is_free(last, pair[1]) {
                corners.push(pair[0]);
                last = pair[0];
            }
        }
        corners
    }
}

/// Length of a step in hundredths of a cell, so that sums are exact.
fn steps(dx: i32, dy: i32) -> u32 {
    let (long, short) = (dx.unsigned_abs().max(dy.unsigned_abs()), dx.unsigned_abs().min(dy.unsigned_abs()));
    100 * (long - short) + 141 * short
}

fn cell(at: Point2<f64>) -> Cell {
    ((at.x / CELL_M).round() as i32, (at.y / CELL_M).round() as i32)
}

fn middle(at: Cell) -> Point2<f64> {
    Point2::new(f64::from(at.0) * CELL_M, f64::from(at.1) * CELL_M)
}

/// The one place where nalgebra's numbers become parry's.
fn flat(at: Point2<f64>) -> ParryVector {
    ParryVector::new(at.x as f32, at.y as f32, 0.0)
}
