//! Free paths of the base among upright boxes: a straight line, else A* over the corners that stand in the way.
//!
//! A corner is asked for only when its box stops a leg, and a leg is tested only when it would lead to the shortest
//! path; so work grows with what lies between two poses, and not with what lies elsewhere. It is counted and bounded.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use nalgebra::Point2;

use super::footprint::{TURNS, outermost};
use super::free_space::{FreeSpace, Steps};
use ambidex_model::Pose;

/// Steps after which a search is given up: some 50 ms. Thousands of boxes on open ground take an eighth.
const MOST_STEPS: u32 = 2_000_000;
/// How many steps each of the first two searches has, one from either end.
const FIRST_STEPS: u32 = 4_000;
/// How many times as many the next two have.
const MORE_STEPS: u32 = 8;

/// Why no path was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoPath {
    /// None leads there.
    Closed,
    /// None was found within so many steps of search.
    Beyond(u32),
}

/// A search and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Way points, the goal last, each with the goal's heading.
    pub path: Result<Vec<Pose>, NoPath>,
    /// Boxes, and groups of boxes, that were held against a leg, and way points around boxes that were looked at.
    pub steps: u32,
    /// Way points from which it went on.
    pub expansions: u32,
}

/// Searches a path of the base between two poses: the straight line where it is free, else nearly the shortest one.
/// Between two corners of boxes it takes a few millimeters more than the base's width.
pub fn find_path(space: &FreeSpace, from: Pose, to: Pose) -> Found {
    let steps = Steps::default();
    let mut expansions = 0;
    let corners = if space.stopped_by(from.at, to.at, &steps).is_none() {
        Ok(Vec::new())
    } else if [from.at, to.at].iter().any(|&at| space.stopped_by(at, at, &steps).is_some()) {
        Err(NoPath::Closed)
    } else {
        from_both_ends(space, from.at, to.at, &steps, &mut expansions)
    };
    let path = corners.map(|corners| {
        let poses = corners.into_iter().map(|at| Pose { at, heading: to.heading });
        poses.chain([to]).collect()
    });
    Found { path, steps: steps.count(), expansions }
}

/// Searches by turns from either end, each time with more steps: where one end is shut in, that is soon known.
fn from_both_ends(
    space: &FreeSpace,
    from: Point2<f64>,
    to: Point2<f64>,
    steps: &Steps,
    expansions: &mut u32,
) -> Result<Vec<Point2<f64>>, NoPath> {
    let mut share = FIRST_STEPS;
    loop {
        for is_reversed in [false, true] {
            let limit = steps.count().saturating_add(share).min(MOST_STEPS);
            let (begin, end) = if is_reversed { (to, from) } else { (from, to) };
            let mut search = Search::new(space, begin, end, steps);
            let corners = search.run(limit);
            *expansions += search.expansions;
            match corners {
                Ok(mut corners) => {
                    if is_reversed {
                        corners.reverse();
                    }
                    return Ok(tighten(space, from, corners, to, steps));
                }
                Err(NoPath::Closed) => return Err(NoPath::Closed),
                Err(NoPath::Beyond(_)) if limit == MOST_STEPS => return Err(NoPath::Beyond(MOST_STEPS)),
                Err(NoPath::Beyond(_)) => {}
            }
        }
        share = share.saturating_mul(MORE_STEPS);
    }
}

/// Leaves out what a leg can pass by.
fn tighten(
    space: &FreeSpace,
    from: Point2<f64>,
    mut corners: Vec<Point2<f64>>,
    to: Point2<f64>,
    steps: &Steps,
) -> Vec<Point2<f64>> {
    let mut at = 0;
    while at < corners.len() {
        let before = if at == 0 { from } else { corners[at - 1] };
        let after = corners.get(at + 1).copied().unwrap_or(to);
        if space.stopped_by(before, after, steps).is_none() {
            corners.remove(at);
            at = at.saturating_sub(1);
        } else {
            at += 1;
        }
    }
    corners
}

struct Search<'a> {
    space: &'a FreeSpace,
    to: Point2<f64>,
    steps: &'a Steps,
    stops: Vec<Stop>,
    /// Of the corners that were reached.
    known: BTreeMap<Target, usize>,
    legs: BinaryHeap<Reverse<Leg>>,
    expansions: u32,
}

/// A point that free legs lead to.
struct Stop {
    at: Point2<f64>,
    target: Option<Target>,
    cost_m: f64,
    before: Option<usize>,
    /// Obstacles whose outermost corners were asked for from here.
    passed: BTreeSet<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    Goal,
    Corner { obstacle: usize, turn: usize },
}

/// A leg that has not been tested.
struct Leg {
    /// No path that begins with it is shorter, meters.
    least_m: f64,
    from: usize,
    target: Target,
    at: Point2<f64>,
}

impl<'a> Search<'a> {
    fn new(space: &'a FreeSpace, from: Point2<f64>, to: Point2<f64>, steps: &'a Steps) -> Self {
        let (known, legs) = (BTreeMap::new(), BinaryHeap::new());
        let mut search = Self { space, to, steps, stops: Vec::new(), known, legs, expansions: 0 };
        search.stops.push(Stop { at: from, target: None, cost_m: 0.0, before: None, passed: BTreeSet::new() });
        search.expand(0);
        search
    }

    /// The corners between both ends.
    fn run(&mut self, limit: u32) -> Result<Vec<Point2<f64>>, NoPath> {
        loop {
            while let Some(Reverse(leg)) = self.legs.pop() {
                if self.steps.count() >= limit {
                    return Err(NoPath::Beyond(limit));
                }
                if !self.is_shorter(&leg, leg.from) {
                    continue;
                }
                match self.space.stopped_by(self.stops[leg.from].at, leg.at, self.steps) {
                    Some(obstacle) => self.pass(leg.from, obstacle),
                    None if leg.target == Target::Goal => return Ok(self.corners_to(leg.from)),
                    None => self.reach(&leg),
                }
            }
            if !self.pass_all(limit) {
                return Err(if self.steps.count() >= limit { NoPath::Beyond(limit) } else { NoPath::Closed });
            }
        }
    }

    /// A free leg: it becomes the way to its corner, but from an earlier stop where that can be seen from the corner.
    fn reach(&mut self, leg: &Leg) {
        let mut from = leg.from;
        while let Some(before) = self.stops[from].before
            && !self.is_taut(before, from, leg.at)
        {
            match self.space.stopped_by(self.stops[before].at, leg.at, self.steps) {
                Some(obstacle) => {
                    self.pass(before, obstacle);
                    break;
                }
                None => from = before,
            }
        }
        if !self.is_shorter(leg, from) {
            return;
        }
        let cost_m = self.cost_m(from, leg.at);
        let next = self.stops.len();
        let id = *self.known.entry(leg.target).or_insert(next);
        if id == next {
            let (at, target) = (leg.at, Some(leg.target));
            self.stops.push(Stop { at, target, cost_m, before: Some(from), passed: BTreeSet::new() });
            self.expand(id);
        } else {
            let stop = &mut self.stops[id];
            (stop.cost_m, stop.before) = (cost_m, Some(from));
            let passed = std::mem::take(&mut stop.passed);
            self.expand(id);
            for obstacle in passed {
                self.pass(id, obstacle);
            }
        }
    }

    fn expand(&mut self, id: usize) {
        self.expansions += 1;
        self.push(id, Target::Goal, self.to);
    }

    /// Asks for the ways past an obstacle on both sides.
    fn pass(&mut self, from: usize, obstacle: usize) {
        if !self.stops[from].passed.insert(obstacle) {
            return;
        }
        self.steps.add(TURNS as u32);
        let turns = self.space.turns(obstacle);
        for turn in outermost(&turns, self.stops[from].at) {
            self.push(from, Target::Corner { obstacle, turn }, turns[turn]);
        }
    }

    /// Asks for every obstacle from everywhere: what stands in the way of one leg may be the way round for another.
    /// False where all that has been asked for.
    fn pass_all(&mut self, limit: u32) -> bool {
        let all: BTreeSet<_> = self.stops.iter().flat_map(|stop| &stop.passed).copied().collect();
        for from in 0..self.stops.len() {
            let others: Vec<_> = all.difference(&self.stops[from].passed).copied().collect();
            for obstacle in others {
                if self.steps.count() >= limit {
                    return false;
                }
                self.pass(from, obstacle);
            }
        }
        !self.legs.is_empty()
    }

    fn push(&mut self, from: usize, target: Target, at: Point2<f64>) {
        let least_m = self.cost_m(from, at) + nalgebra::distance(&at, &self.to);
        let leg = Leg { least_m, from, target, at };
        if self.is_shorter(&leg, from) {
            self.legs.push(Reverse(leg));
        }
    }

    /// Whether the leg's end is farther by all legs so far than from there.
    fn is_shorter(&self, leg: &Leg, from: usize) -> bool {
        match self.known.get(&leg.target) {
            Some(&known) => self.cost_m(from, leg.at) < self.stops[known].cost_m,
            None => true,
        }
    }

    /// Whether a string from one stop to the next and on to a point would be held by the corner between.
    fn is_taut(&self, before: usize, corner: usize, after: Point2<f64>) -> bool {
        let (a, b) = (self.stops[before].at, self.stops[corner].at);
        match self.stops[corner].target {
            Some(Target::Corner { obstacle, .. }) => {
                let inward = self.space.middle(obstacle) - b;
                (b - a).perp(&(after - b)) * (b - a).perp(&inward) > 0.0
            }
            Some(Target::Goal) | None => true,
        }
    }

    fn cost_m(&self, from: usize, to: Point2<f64>) -> f64 {
        self.stops[from].cost_m + nalgebra::distance(&self.stops[from].at, &to)
    }

    fn corners_to(&self, last: usize) -> Vec<Point2<f64>> {
        let before = |id: &usize| self.stops[*id].before;
        let mut ids: Vec<_> = std::iter::successors(Some(last), before).filter(|&id| id != 0).collect();
        ids.reverse();
        ids.into_iter().map(|id| self.stops[id].at).collect()
    }
}

impl Ord for Leg {
    fn cmp(&self, other: &Self) -> Ordering {
        let ids = (self.from, self.target).cmp(&(other.from, other.target));
        self.least_m.total_cmp(&other.least_m).then(ids)
    }
}

impl PartialOrd for Leg {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Leg {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Leg {}
