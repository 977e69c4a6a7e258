//! What bars, signs and lines mean that occur, and what is not drawn.

use std::collections::BTreeSet;

use ambidex_model::LeaseKind;

use super::lanes::{self, Place};
use super::panel::Panel;
use super::rows::{self, Bar};
use crate::svg::fit::{self, NOTE};
use crate::svg::marks::{Mark, mark};
use crate::svg::page::{Frame, MARGIN, PAGE_WIDTH, Shape};

/// Height of a line.
const LINE: f64 = 15.0;
/// Width of a sample.
const SAMPLE: f64 = 18.0;
/// Between two entries.
const GAP: f64 = 14.0;

/// What an entry shows.
#[derive(Debug, Clone, Copy)]
enum Sample {
    Bar(Bar),
    Sign(Mark),
    Lease(LeaseKind),
    Channel,
    Unavailable,
    Step,
    Round,
}

/// The legend from a height on, and the height where it ends.
pub(super) fn draw(panels: &[Panel], is_thinned: bool, top: f64) -> (Shape, f64) {
    let mut shapes = Vec::new();
    let mut y = top + 10.0 - LINE;
    for line in lines(&samples(panels)) {
        let mut x = MARGIN;
        y += LINE;
        for sample in line {
            shapes.push(sample.shape(x, y - 3.3));
            shapes.push(Shape::text("note", (x + SAMPLE, y), sample.word()));
            x += sample.width() + GAP;
        }
    }
    let mut notes: BTreeSet<&str> = panels.iter().flat_map(|panel| &panel.notes).map(String::as_str).collect();
    if is_thinned {
        notes.insert("of what lies too near together to be told apart only some is drawn");
    }
    for note in notes {
        y += LINE;
        let note = fit::clip(note, NOTE, PAGE_WIDTH - 2.0 * MARGIN);
        shapes.push(Shape::text("note", (MARGIN, y), &note));
    }
    (Shape::group("legend", shapes), y)
}

/// The samples in as few lines as they take, and none of them much shorter than the others.
fn lines(samples: &[Sample]) -> Vec<Vec<Sample>> {
    let broken = |room: f64| {
        let mut lines: Vec<Vec<Sample>> = Vec::new();
        let mut used = f64::INFINITY;
        for &sample in samples {
            if used + sample.width() > room {
                lines.push(Vec::new());
                used = 0.0;
            }
            used += sample.width() + GAP;
            lines.last_mut().expect("a line was begun").push(sample);
        }
        lines
    };
    let rooms = (0..).map(|step| PAGE_WIDTH - 2.0 * MARGIN - f64::from(step) * GAP).take_while(|room| *room > 0.0);
    let widest = broken(PAGE_WIDTH - 2.0 * MARGIN);
    let fewest = widest.len();
    rooms.map(broken).take_while(|lines| lines.len() == fewest).last().unwrap_or(widest)
}

/// Bars, signs, leases and lines that occur.
fn samples(panels: &[Panel]) -> Vec<Sample> {
    let leaves = panels.iter().flat_map(|panel| panel.leaves.iter().map(|leaf| (panel.history, *leaf)));
    let signs: BTreeSet<Mark> = leaves.clone().flat_map(|(history, leaf)| rows::signs(history, leaf)).collect();
    let lanes = || panels.iter().flat_map(|panel| &panel.lanes);
    let holds: BTreeSet<LeaseKind> = lanes().flat_map(Place::holds).collect();
    let bars: BTreeSet<Bar> = leaves.clone().flat_map(|(history, leaf)| rows::bars(history, leaf)).collect();
    let bars = bars.into_iter().map(Sample::Bar);
    let signs = signs.into_iter().map(Sample::Sign);
    // What runs is active, as everywhere.
    let kept = holds.into_iter().filter(|hold| *hold != LeaseKind::Running).map(Sample::Lease);
    let channel = lanes().any(Place::is_shared).then_some(Sample::Channel);
    let outage = lanes().any(Place::is_ever_out).then_some(Sample::Unavailable);
    let has = |any: &dyn Fn(&Panel) -> bool| panels.iter().any(any);
    let step = has(&|panel| !panel.history.steps().is_empty()).then_some(Sample::Step);
    let round = has(&|panel| !panel.history.round_times().is_empty()).then_some(Sample::Round);
    bars.chain(signs).chain(kept).chain(channel).chain(outage).chain(step).chain(round).collect()
}

impl Sample {
    fn width(self) -> f64 {
        SAMPLE + fit::width(self.word(), NOTE)
    }

    fn word(self) -> &'static str {
        match self {
            Self::Bar(Bar::Waiting) => "inactive",
            Self::Bar(Bar::Active) => "active, uses the resource",
            Self::Bar(Bar::Done) => "done",
            Self::Sign(sign) => match sign {
                Mark::Waiting => "waiting",
                Mark::Active => "active",
                Mark::Done => "done",
                Mark::Skipped => "skipped",
                Mark::Failed => "failed",
                Mark::Canceled => "canceled",
                Mark::NotAsked => "not asked",
                Mark::NotNeeded => "not needed",
                Mark::Left => "way left",
                Mark::Reopened => "not done any more",
                Mark::Interrupted => "interrupted",
                Mark::Again => "done once more",
                Mark::RunsOn => "active when the log ends",
            },
            Self::Lease(LeaseKind::Running) => "used",
            Self::Lease(LeaseKind::Physical) => "kept: an object is in it",
            Self::Lease(LeaseKind::Intention) => "kept for what comes next",
            Self::Channel => "shared on a channel",
            Self::Unavailable => "unavailable",
            Self::Step => "step begins",
            Self::Round => "round",
        }
    }

    /// The sample, its left side and its middle given.
    fn shape(self, x: f64, y: f64) -> Shape {
        let wide = |class: &str, height: f64, round: f64| {
            Shape::rect(class, Frame { x, y: y - height / 2.0, width: SAMPLE - 4.0, height }, round)
        };
        let middle = x + SAMPLE / 2.0 - 2.0;
        match self {
            Self::Bar(bar) => wide(bar.class(), bar.height(), 0.0),
            Self::Sign(sign) => mark(sign, (middle, y), 4.2),
            Self::Lease(hold) => wide(lanes::class(hold), 9.0, 1.5),
            Self::Channel => Shape::line("channel", (x, y), (x + SAMPLE - 4.0, y)),
            Self::Unavailable => wide(lanes::UNAVAILABLE, 9.0, 1.5),
            Self::Step => Shape::line("step", (middle, y - 5.5), (middle, y + 5.5)),
            Self::Round => Shape::line("round", (middle, y - 3.5), (middle, y + 3.5)),
        }
    }
}
