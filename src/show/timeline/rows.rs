//! One row per behavior. What it is shows in color, in the height of the bar, and in signs.

use std::collections::BTreeSet;

use crate::text::phrase::did_it;
use ambidex_model::{Names, NodeId, Time};

use super::bounds::thinned;
use crate::svg::fit::{self, INNER};
use crate::svg::marks::{Mark, mark};
use crate::svg::page::{Frame, Shape};
use crate::svg::scale::Scale;
use ambidex_record::History;
use ambidex_record::Phase;

/// Height of a row.
pub(super) const ROW: f64 = 14.0;
/// Size of a sign.
const SIGN: f64 = 4.2;

/// A kind of bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Bar {
    Waiting,
    Active,
    Done,
}

impl Bar {
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Active => "active",
            Self::Done => "done",
        }
    }

    pub(super) fn height(self) -> f64 {
        match self {
            Self::Waiting => 3.0,
            Self::Active => 10.0,
            Self::Done => 6.0,
        }
    }
}

/// The bar of a phase, if it has one.
fn bar(phase: Phase) -> Option<Bar> {
    match phase {
        Phase::Waiting | Phase::Reopened | Phase::Left | Phase::Failed { is_final: false, .. } => Some(Bar::Waiting),
        Phase::Preempted { .. } | Phase::Broken | Phase::Again => Some(Bar::Waiting),
        Phase::Active => Some(Bar::Active),
        Phase::Done | Phase::Skipped | Phase::Overtaken => Some(Bar::Done),
        Phase::Failed { is_final: true, .. }
        | Phase::Infeasible
        | Phase::Canceled
        | Phase::NotAsked
        | Phase::NotNeeded => None,
    }
}

/// The sign with which a phase begins, if it has one.
fn sign(phase: Phase) -> Option<Mark> {
    match phase {
        Phase::Skipped | Phase::Overtaken => Some(Mark::Skipped),
        Phase::Failed { .. } | Phase::Infeasible => Some(Mark::Failed),
        Phase::Left => Some(Mark::Left),
        Phase::Canceled => Some(Mark::Canceled),
        Phase::Reopened => Some(Mark::Reopened),
        Phase::Preempted { .. } | Phase::Broken => Some(Mark::Interrupted),
        Phase::Again => Some(Mark::Again),
        Phase::NotNeeded => Some(Mark::NotNeeded),
        Phase::Waiting | Phase::Active | Phase::Done | Phase::NotAsked => None,
    }
}

/// A phase from its beginning to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    pub(super) phase: Phase,
    pub(super) from: Time,
    to: Time,
    /// It lasts when the records end.
    is_open: bool,
}

/// What a behavior was, from the beginning to the end.
pub(super) fn stretches(history: &History, leaf: NodeId) -> impl Iterator<Item = Stretch> {
    let phases = history.leaf(leaf).map_or(&[][..], |leaf| leaf.phases());
    let end = history.last_moment();
    let nexts = phases.iter().map(|(next, _)| Some(*next)).chain([None]);
    std::iter::once(&(Time::ZERO, Phase::Waiting)).chain(phases).zip(nexts).map(move |(&(from, phase), next)| Stretch {
        phase,
        from,
        to: next.unwrap_or(end).max(from),
        is_open: next.is_none(),
    })
}

/// The stretches of a row that are drawn, and whether some are not.
pub(super) fn shown(history: &History, leaf: NodeId, scale: &Scale) -> (Vec<Stretch>, bool) {
    let place = |stretch: &Stretch| {
        let track = usize::from(stretch.phase == Phase::Active);
        (scale.x(stretch.from), scale.x(stretch.to), track)
    };
    thinned(stretches(history, leaf).collect(), place)
}

/// Bars that occur in a row.
pub(super) fn bars(history: &History, leaf: NodeId) -> BTreeSet<Bar> {
    stretches(history, leaf)
        .filter(|stretch| stretch.to > stretch.from)
        .filter_map(|stretch| bar(stretch.phase))
        .collect()
}

/// Signs that occur in a row.
pub(super) fn signs(history: &History, leaf: NodeId) -> BTreeSet<Mark> {
    stretches(history, leaf).flat_map(|stretch| [sign(stretch.phase), runs_on(&stretch)]).flatten().collect()
}

fn runs_on(stretch: &Stretch) -> Option<Mark> {
    (stretch.phase == Phase::Active && stretch.is_open).then_some(Mark::RunsOn)
}

/// The row of a behavior around a height.
pub(super) fn draw(history: &History, leaf: NodeId, stretches: &[Stretch], scale: &Scale, middle: f64) -> Shape {
    let names = history.names();
    let name = names.node(leaf);
    let (mut bars, mut signs) = (Vec::new(), Vec::new());
    for stretch in stretches {
        let (from, to) = (scale.x(stretch.from), scale.x(stretch.to));
        let said = said(name, stretch, history.instead_of(leaf), names);
        if let Some(bar) = bar(stretch.phase).filter(|_| to > from) {
            let frame = Frame { x: from, y: middle - bar.height() / 2.0, width: to - from, height: bar.height() };
            bars.push(Shape::rect(bar.class(), frame, 0.0).titled(&said));
        }
        let begins = sign(stretch.phase).map(|sign| (sign, from));
        let lasts = runs_on(stretch).map(|sign| (sign, to));
        for (sign, x) in begins.into_iter().chain(lasts) {
            let x = x.clamp(scale.left + SIGN, scale.right() - SIGN);
            // A ground of its own: no sign stands out on every bar.
            let ground = Shape::circle("paper", (x, middle), SIGN + 1.2);
            signs.push(Shape::group("sign", [ground, mark(sign, (x, middle), SIGN)]).titled(&said));
        }
    }
    let left = stretches.last().filter(|last| last.phase == Phase::NotNeeded);
    if let Some((last, way)) = left.zip(history.instead_of(leaf)) {
        let x = scale.x(last.from).clamp(scale.left + SIGN, scale.right() - SIGN) + SIGN + 4.0;
        let said = fit::clip(&did_it(way, names), INNER, scale.right() - x);
        if said.chars().count() > 3 {
            signs.push(Shape::text("inner", (x, middle + 3.0), &said));
        }
    }
    bars.extend(signs);
    Shape::group("row", bars)
}

/// What is said where a pointer rests on a bar or a sign.
fn said(name: &str, stretch: &Stretch, way: Option<NodeId>, names: &Names) -> String {
    let Stretch { phase, from, to, is_open } = *stretch;
    let until = if is_open { "the end".to_owned() } else { to.to_string() };
    match phase {
        Phase::Waiting => format!("{name}: waiting until {until}"),
        Phase::Active if is_open => format!("{name}: active from {from}, still when the log ends"),
        Phase::Active => format!("{name}: active from {from} to {to}, {:.2} s", (to - from).as_secs_f64()),
        Phase::Done => format!("{name}: done at {from}"),
        Phase::Skipped => format!("{name}: skipped at {from}, its goal was met already"),
        Phase::Failed { fault, is_final: true } => {
            format!("{name}: failed at {from}: {}", fault.sentence(names))
        }
        Phase::Failed { fault, is_final: false } => {
            format!("{name}: failed at {from} and is to run again: {}", fault.sentence(names))
        }
        Phase::Infeasible => format!("{name}: failed at {from}, since it can never run"),
        Phase::Overtaken => format!("{name}: done by others at {from}"),
        Phase::Left => format!("{name}: its way was left at {from}"),
        Phase::Canceled => format!("{name}: canceled at {from}"),
        Phase::Reopened => format!("{name}: not done any more from {from} on, waiting until {until}"),
        Phase::Preempted { by } => format!("{name}: preempted by {} at {from}, {}", names.node(by), lasting(stretch)),
        Phase::Broken => format!("{name}: interrupted at {from}, {}", lasting(stretch)),
        Phase::Again => format!("{name}: to be done once more from {from} on, {}", lasting(stretch)),
        Phase::NotAsked => format!("{name}: no longer wanted from {from} on"),
        Phase::NotNeeded => {
            let why = way.map_or(String::new(), |way| format!(": {}", did_it(way, names)));
            format!("{name}: not needed from {from} on{why}")
        }
    }
}

/// How long it waits after that.
fn lasting(stretch: &Stretch) -> String {
    match stretch.is_open {
        true => "waiting until the end".to_owned(),
        false => format!("waiting {:.2} s", (stretch.to - stretch.from).as_secs_f64()),
    }
}
