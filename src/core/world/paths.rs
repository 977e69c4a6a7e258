//! Free paths of the base among upright boxes: a straight line, else A* over legs between the corners that stand in the way.
//!
//! A state of the search is a leg that nobody has tested. Tested and free it leads on from its corner; stopped by a box it
//! leads to the legs past that box on both sides. So a corner is asked for only when its box stops a leg, and a leg is
//! tested only when it would lead to the shortest path: work grows with what lies between two poses, and not with what lies
//! elsewhere. It is counted and bounded.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point2;
use pathfinding::directed::astar::astar;

use super::footprint::{TURNS, outermost};
use super::free_space::{FreeSpace, Legs, Steps};
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
    let legs = Legs { space, start: from.at, steps: &steps };
    let mut expansions = 0;
    let corners = if legs.stopped_by(from.at, to.at).is_none() {
        Ok(Vec::new())
    } else if space.is_covered(from.at) || space.taken_by(to.at).is_some() {
        Err(NoPath::Closed)
    } else {
        from_both_ends(legs, to.at, &mut expansions)
    };
    let path = corners.map(|corners| {
        let poses = corners.into_iter().map(|at| Pose { at, heading: to.heading });
        poses.chain([to]).collect()
    });
    Found { path, steps: steps.count(), expansions }
}

/// Searches by turns from either end, each time with more steps: where one end is shut in, that is soon known.
fn from_both_ends(legs: Legs<'_>, to: Point2<f64>, expansions: &mut u32) -> Result<Vec<Point2<f64>>, NoPath> {
    let Legs { start: from, steps, .. } = legs;
    let mut share = FIRST_STEPS;
    loop {
        for is_reversed in [false, true] {
            let limit = steps.count().saturating_add(share).min(MOST_STEPS);
            let (begin, end) = if is_reversed { (to, from) } else { (from, to) };
            let mut search = Search::new(legs, (begin, end), limit);
            let corners = search.run();
            *expansions += search.expansions;
            match corners {
                Ok(mut corners) => {
                    if is_reversed {
                        corners.reverse();
                    }
                    return Ok(tighten(legs, corners, to));
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
fn tighten(legs: Legs<'_>, mut corners: Vec<Point2<f64>>, to: Point2<f64>) -> Vec<Point2<f64>> {
    let mut at = 0;
    while at < corners.len() {
        let before = if at == 0 { legs.start } else { corners[at - 1] };
        let after = corners.get(at + 1).copied().unwrap_or(to);
        if legs.stopped_by(before, after).is_none() {
            corners.remove(at);
            at = at.saturating_sub(1);
        } else {
            at += 1;
        }
    }
    corners
}

/// Where a leg begins or ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum End {
    Begin,
    Goal,
    Corner { obstacle: usize, turn: usize },
}

/// What A* goes over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Step {
    /// A leg; to get there costs what it costs to come to its beginning.
    Leg(End, End),
    Arrived,
}

impl End {
    fn obstacle(&self) -> Option<usize> {
        match *self {
            Self::Corner { obstacle, .. } => Some(obstacle),
            Self::Begin | Self::Goal => None,
        }
    }
}

impl Step {
    fn begins(self) -> Option<End> {
        match self {
            Self::Leg(from, _) => Some(from),
            Self::Arrived => None,
        }
    }
}

struct Search<'a> {
    legs: Legs<'a>,
    begin: Point2<f64>,
    goal: Point2<f64>,
    limit: u32,
    /// Way points around the obstacles that were asked for.
    turns: BTreeMap<usize, [Point2<f64>; TURNS]>,
    /// What stops the legs that were tested.
    tested: BTreeMap<(End, End), Option<usize>>,
    /// The cheapest way so far to what was reached, micrometers.
    reached: BTreeMap<End, u64>,
    /// Obstacles whose corners are asked for from everywhere: what stands in the way of one leg may be the way round for
    /// another.
    asked: BTreeSet<usize>,
    /// Those that are asked for from one corner.
    asked_from: BTreeMap<End, BTreeSet<usize>>,
    expansions: u32,
}

impl<'a> Search<'a> {
    fn new(legs: Legs<'a>, (begin, goal): (Point2<f64>, Point2<f64>), limit: u32) -> Self {
        let (turns, tested, reached) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        let (asked, asked_from) = (BTreeSet::new(), BTreeMap::new());
        Self { legs, begin, goal, limit, turns, tested, reached, asked, asked_from, expansions: 0 }
    }

    /// The corners between both ends. What stands in the way of one leg may be the way round for another: the obstacles that
    /// the way turns at are asked for from everywhere, until it turns at no others; where there is none, all that were seen.
    fn run(&mut self) -> Result<Vec<Point2<f64>>, NoPath> {
        loop {
            self.reached = BTreeMap::from([(End::Begin, 0)]);
            let found = self.search();
            if self.is_over() {
                return Err(NoPath::Beyond(self.limit));
            }
            let is_all_asked = match &found {
                Some(ends) => !self.ask_along(ends),
                None => {
                    let seen: BTreeSet<usize> = self.turns.keys().copied().collect();
                    std::mem::replace(&mut self.asked, seen) == self.asked
                }
            };
            if is_all_asked {
                let ends = found.ok_or(NoPath::Closed)?;
                return Ok(ends.into_iter().map(|end| self.at(end)).collect());
            }
        }
    }

    /// Asks from each corner of a way for the obstacles at which it turns later; whether one of them was not asked for.
    fn ask_along(&mut self, ends: &[End]) -> bool {
        let mut is_new = false;
        for (index, end) in [End::Begin].iter().chain(ends).enumerate() {
            let later = ends[index..].iter().filter_map(End::obstacle);
            let asked = self.asked_from.entry(*end).or_default();
            later.for_each(|obstacle| is_new |= asked.insert(obstacle));
        }
        is_new
    }

    /// The corners of the shortest way there is with what is asked for; none where there is none.
    fn search(&mut self) -> Option<Vec<End>> {
        let goal = self.goal;
        let search = RefCell::new(self);
        let least = |step: &Step| match *step {
            Step::Leg(from, to) => {
                let search = search.borrow();
                let (from, to) = (search.at(from), search.at(to));
                micrometers(from, to) + micrometers(to, goal)
            }
            Step::Arrived => 0,
        };
        let first = Step::Leg(End::Begin, End::Goal);
        let next = |step: &Step| search.borrow_mut().next(step);
        let (steps, _) = astar(&first, next, least, |step| *step == Step::Arrived)?;
        let mut ends: Vec<End> = steps.into_iter().filter_map(Step::begins).collect();
        ends.dedup();
        ends.retain(|end| *end != End::Begin);
        Some(ends)
    }

    /// What a leg leads to, and what more that costs.
    fn next(&mut self, step: &Step) -> Vec<(Step, u64)> {
        let Step::Leg(from, to) = *step else { return Vec::new() };
        let length = micrometers(self.at(from), self.at(to));
        let come = self.reached.get(&from).map_or(u64::MAX, |come| come.saturating_add(length));
        if self.is_over() || self.reached.get(&to).is_some_and(|known| *known <= come) {
            return Vec::new();
        }
        match self.stopped_by(from, to) {
            Some(obstacle) if (from, to) == (End::Begin, End::Goal) => {
                let all = self.asked_at(from).into_iter().chain([obstacle]);
                all.flat_map(|obstacle| self.past(from, obstacle)).collect()
            }
            Some(obstacle) => self.past(from, obstacle),
            None if to == End::Goal => vec![(Step::Arrived, length)],
            None => {
                self.reached.insert(to, come);
                self.expansions += 1;
                let mut next = vec![(Step::Leg(to, End::Goal), length)];
                for obstacle in self.asked_at(to) {
                    let past = self.past(to, obstacle).into_iter();
                    next.extend(past.map(|(step, _)| (step, length)));
                }
                next
            }
        }
    }

    /// The obstacles that are asked for from a corner, whether they stop a leg of it or not.
    fn asked_at(&self, end: End) -> BTreeSet<usize> {
        let own = self.asked_from.get(&end).into_iter().flatten();
        self.asked.iter().chain(own).copied().collect()
    }

    /// The legs past an obstacle on both sides.
    fn past(&mut self, from: End, obstacle: usize) -> Vec<(Step, u64)> {
        self.legs.steps.add(TURNS as u32);
        let turns = *self.turns.entry(obstacle).or_insert_with(|| self.legs.space.turns(obstacle));
        let corners = outermost(&turns, self.at(from)).into_iter();
        let legs = corners.map(|turn| Step::Leg(from, End::Corner { obstacle, turn }));
        legs.filter(|leg| !matches!(leg, Step::Leg(from, to) if from == to)).map(|leg| (leg, 0)).collect()
    }

    fn stopped_by(&mut self, from: End, to: End) -> Option<usize> {
        if let Some(known) = self.tested.get(&(from, to)) {
            return *known;
        }
        let found = self.legs.stopped_by(self.at(from), self.at(to));
        self.tested.insert((from, to), found);
        found
    }

    fn at(&self, end: End) -> Point2<f64> {
        match end {
            End::Begin => self.begin,
            End::Goal => self.goal,
            End::Corner { obstacle, turn } => self.turns[&obstacle][turn],
        }
    }

    fn is_over(&self) -> bool {
        self.legs.steps.count() >= self.limit
    }
}

fn micrometers(from: Point2<f64>, to: Point2<f64>) -> u64 {
    (nalgebra::distance(&from, &to) * 1e6).round() as u64
}
