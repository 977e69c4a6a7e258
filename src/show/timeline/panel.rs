//! One run: its head where there are two, steps, rows, lanes, rounds.

use ambidex_model::{NodeId, ResourceId};

use ambidex_record::History;

use super::bounds::{self, MAX_LANES, MAX_TRACKS, apart};
use super::lanes::Place;
use super::outside;
use super::rows::{self, ROW};
use crate::svg::fit::{self, NOTE, SMALL, TEXT};
use crate::svg::page::{MARGIN, PAGE_WIDTH, Shape};
use crate::svg::scale::Scale;
use crate::text::count;

/// Height of the head of one of two runs.
const HEAD: f64 = 20.0;
/// Height of the numbers of steps.
const STEPS: f64 = 15.0;
/// Between rows and lanes.
const GAP: f64 = 8.0;
/// Height of the ticks of rounds.
const ROUNDS: f64 = 14.0;
/// Least distance of the lines of two steps, and of the ticks of two rounds.
const STEP_APART: f64 = 10.0;
const ROUND_APART: f64 = 2.0;

/// Most changes from outside that are told.
const MAX_CHANGES: usize = 4;

/// A run and what of it is drawn.
#[derive(Debug)]
pub(super) struct Panel<'a> {
    pub(super) history: &'a History,
    head: Option<[String; 2]>,
    pub(super) leaves: Vec<NodeId>,
    pub(super) lanes: Vec<Place<'a>>,
    /// What is not drawn, and what others changed.
    pub(super) notes: Vec<String>,
}

/// A panel as it is drawn.
#[derive(Debug)]
pub(super) struct Drawn {
    pub(super) shape: Shape,
    pub(super) bottom: f64,
    /// Some of it could not be told apart and was left out.
    pub(super) is_thinned: bool,
}

impl<'a> Panel<'a> {
    pub(super) fn new(history: &'a History, head: Option<[String; 2]>) -> Self {
        let (leaves, left_out) = bounds::rows(history);
        let mut notes: Vec<String> = left_out.into_iter().collect();
        let end = history.last_moment();
        let lanes = history.lanes().iter().enumerate().take(MAX_LANES);
        let lanes: Vec<Place> =
            lanes.map(|(index, lane)| Place { resource: ResourceId::from(index), lane, end }).collect();
        let more = history.lanes().len() - lanes.len();
        if more > 0 {
            notes.push(format!("{} more left out", count(more, "resource")));
        }
        notes.extend(outside::notes(history, MAX_CHANGES));
        if lanes.iter().any(Place::is_crowded) {
            notes.push(format!("more than {MAX_TRACKS} leases of one resource at once are left out"));
        }
        Self { history, head, leaves, lanes, notes }
    }

    /// Everything that is written at the left.
    pub(super) fn labels(&self) -> impl Iterator<Item = &'a str> {
        let names = self.history.names();
        let leaves = self.leaves.iter().map(|&leaf| names.node(leaf));
        leaves.chain(self.lanes.iter().map(|lane| names.resource(lane.resource)))
    }

    /// The run from a height on.
    pub(super) fn draw(&self, scale: &Scale, top: f64) -> Drawn {
        let mut shapes = Vec::new();
        let mut y = top;
        if let Some(head) = &self.head {
            y += HEAD;
            shapes.extend(self.head(head, y - 6.0));
        }
        y += STEPS;
        let steps_at = y;
        let mut body = Vec::new();
        let mut is_thinned = self.rows(scale, &mut y, &mut body);
        y += GAP;
        is_thinned |= self.lanes(scale, &mut y, &mut body);
        shapes.push(grid(scale, steps_at, y + ROUNDS));
        shapes.push(self.steps(scale, steps_at, y));
        shapes.extend(body);
        shapes.push(self.rounds(scale, y));
        Drawn { shape: Shape::group("run", shapes), bottom: y + ROUNDS, is_thinned }
    }

    fn head(&self, [name, figures]: &[String; 2], y: f64) -> [Shape; 2] {
        let after = MARGIN + fit::width(name, TEXT) * 1.2 + 6.0;
        let figures = fit::clip(figures, NOTE, PAGE_WIDTH - MARGIN - after);
        [Shape::text("head", (MARGIN, y), name), Shape::text("note", (after, y), &figures)]
    }

    fn rows(&self, scale: &Scale, y: &mut f64, shapes: &mut Vec<Shape>) -> bool {
        let names = self.history.names();
        let mut is_thinned = false;
        for &leaf in &self.leaves {
            let (stretches, is_less) = rows::shown(self.history, leaf, scale);
            is_thinned |= is_less;
            shapes.push(label(names.node(leaf), scale, *y + ROW / 2.0));
            shapes.push(rows::draw(self.history, leaf, &stretches, scale, *y + ROW / 2.0));
            *y += ROW;
        }
        is_thinned
    }

    fn lanes(&self, scale: &Scale, y: &mut f64, shapes: &mut Vec<Shape>) -> bool {
        let header = self.history.header();
        let mut is_thinned = false;
        for place in &self.lanes {
            let (lane, is_less) = place.draw(header, scale, *y);
            is_thinned |= is_less;
            shapes.push(label(header.names.resource(place.resource), scale, *y + place.middle()));
            shapes.push(lane);
            *y += place.height();
        }
        is_thinned
    }

    /// A line where each step begins, with its number where there is room.
    fn steps(&self, scale: &Scale, top: f64, bottom: f64) -> Shape {
        let starts: Vec<f64> = self.history.steps().iter().map(|step| scale.x(step.at)).collect();
        let lines = apart(starts.iter().copied(), STEP_APART);
        let mut shapes: Vec<Shape> = lines.iter().map(|x| Shape::line("step", (*x, top - 3.0), (*x, bottom))).collect();
        let mut free = scale.left - 20.0;
        for (index, &x) in starts.iter().enumerate() {
            let number = (index + 1).to_string();
            let half = fit::width(&number, SMALL) / 2.0;
            if x - half >= free {
                shapes.push(Shape::text("small middle", (x, top - 5.0), &number));
                free = x + half + 2.0;
            }
        }
        shapes.push(Shape::text("small end", (scale.left - 8.0, top - 5.0), "step"));
        Shape::group("steps", shapes)
    }

    fn rounds(&self, scale: &Scale, top: f64) -> Shape {
        let ticks = apart(self.history.round_times().iter().map(|at| scale.x(*at)), ROUND_APART);
        let mut shapes: Vec<Shape> =
            ticks.iter().map(|x| Shape::line("round", (*x, top + 3.0), (*x, top + 10.0))).collect();
        shapes.push(Shape::text("small end", (scale.left - 8.0, top + 10.0), "rounds"));
        Shape::group("rounds", shapes)
    }
}

/// Faint lines at the ticks.
fn grid(scale: &Scale, top: f64, bottom: f64) -> Shape {
    Shape::group("grid", scale.ticks().iter().map(|(x, _)| Shape::line("grid-line", (*x, top), (*x, bottom))))
}

/// A name at the left, whole where a pointer rests.
fn label(name: &str, scale: &Scale, middle: f64) -> Shape {
    let room = scale.left - 8.0 - MARGIN;
    let text = Shape::text("text end", (scale.left - 8.0, middle + 3.5), &fit::clip(name, TEXT, room + 0.1));
    Shape::group("label", [text]).titled(name)
}
