//! The paper's Fig. 7 in a terminal: one row per behavior, robot time from left to right.

use std::collections::BTreeSet;
use std::fmt::Write;

use ambidex_model::{NodeId, StopCause, Time};
use ambidex_record::{History, Interruption, LeafState, Phase};
use strum::VariantArray;

use super::axis::Axis;
use super::outside;
use crate::Palette;
use crate::text::{MIN_WIDTH, clip, columns, count, fit, flow, glyph, phrase};

/// Most leaves that are all drawn; of more, those that ran.
const MAX_ROWS: usize = 60;
/// Most interruptions that are told.
const MAX_NOTES: usize = 8;

/// Most changes from outside that are told.
const MAX_CHANGES: usize = 8;

/// What stands in one cell; none where there is nothing more to say.
type Cell = (char, Option<LeafState>);

/// The timing diagram of a run: when each behavior was waiting, active, done or skipped (Fig. 7).
///
/// Steps are numbered above the bars where they begin, seconds of robot time stand below them.
pub fn text(history: &History, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let (leaves, left_out) = rows(history);
    let name = |leaf| history.names().node(leaf);
    let label_width =
        leaves.iter().map(|&leaf| columns(name(leaf))).chain([4]).max().unwrap_or_default().min(width / 3);
    let axis = Axis::new(history.last_moment(), width - label_width - 3);
    let label = |label: &str| format!(" {} ", fit(label, label_width));
    let mut text = String::new();
    let faint = |line: &str| Palette::paint(palette.faint, line.trim_end());
    let _ = writeln!(text, "{}", faint(&(label("step") + &steps(history, &axis))));
    let mut shown = BTreeSet::new();
    for leaf in leaves {
        let mut cells = bar(&stretches(history, leaf), &axis);
        say_who_did_it(history, leaf, &mut cells);
        shown.extend(cells.iter().filter_map(|&(_, state)| state));
        let _ = writeln!(text, "{}{}", label(name(leaf)), painted(&cells, palette));
    }
    let [ruler, seconds] = axis.ruler();
    let _ = writeln!(text, "{}", faint(&(label("") + &ruler)));
    let unit = if label_width < 7 { "s" } else { "seconds" };
    let unit = format!(" {unit:>label_width$} ");
    let _ = writeln!(text, "{}", faint(&(unit + &seconds)));
    text.push_str(&legend(&shown, width, palette));
    interruptions(history, width, palette, &mut text);
    for note in outside::notes(history, MAX_CHANGES) {
        let _ = writeln!(text, "{}", faint(&clip(&format!(" {note}"), width)));
    }
    if left_out > 0 {
        let note = format!(" {} that did not run left out", count(left_out, "behavior"));
        let _ = writeln!(text, "{}", faint(&clip(&note, width)));
    }
    text
}

/// Who was interrupted, why and for how long, below the bars: the first of it.
fn interruptions(history: &History, width: usize, palette: &Palette, text: &mut String) {
    let names = history.names();
    let mut note = |said: String| {
        let _ = writeln!(text, "{}", Palette::paint(palette.faint, clip(&said, width)));
    };
    let interruptions = history.interruptions();
    for Interruption { at, leaf, cause } in interruptions.iter().take(MAX_NOTES) {
        let why = match cause {
            StopCause::Preempted { by } => format!("preempted by {}", names.node(*by)),
            StopCause::Broken(reason) => format!("interrupted, since {}", reason.sentence(names)),
            StopCause::Ends => "interrupted".to_owned(),
        };
        let phases = history.leaf(*leaf).map_or(&[][..], |leaf| leaf.phases());
        let again = phases.iter().find(|(when, phase)| when >= at && *phase == Phase::Active);
        let how_long = again.map(|(when, _)| format!(", {:.1} s", (*when - *at).as_secs_f64())).unwrap_or_default();
        note(format!(" {:>7.2} s  {} {why}{how_long}", at.seconds(), names.node(*leaf)));
    }
    if interruptions.len() > MAX_NOTES {
        note(format!(" {}", count(interruptions.len() - MAX_NOTES, "further interruption")));
    }
}

/// The leaves to draw and how many are left out.
fn rows(history: &History) -> (Vec<NodeId>, usize) {
    let mut leaves: Vec<NodeId> = history.leaves().collect();
    let all = leaves.len();
    if all > MAX_ROWS {
        leaves.retain(|&leaf| history.leaf(leaf).is_some_and(|leaf| leaf.has_run()));
    }
    let left_out = all - leaves.len();
    (leaves, left_out)
}

/// From when on a leaf was what: what it tries again waits behind its failure.
fn stretches(history: &History, leaf: NodeId) -> Vec<(Time, LeafState)> {
    let phases = history.leaf(leaf).map_or(&[][..], |leaf| leaf.phases());
    let mut stretches = vec![(Time::ZERO, LeafState::Waiting)];
    for (index, &(at, phase)) in phases.iter().enumerate() {
        let is_last = index + 1 == phases.len();
        match phase {
            Phase::Failed { is_final: false, .. } => {
                stretches.extend([(at, LeafState::Failed), (at, LeafState::Waiting)]);
            }
            Phase::Preempted { .. } | Phase::Broken => {
                stretches.extend([(at, LeafState::Canceled), (at, LeafState::Waiting)]);
            }
            Phase::Canceled if !is_last => stretches.extend([(at, LeafState::Canceled), (at, LeafState::Waiting)]),
            Phase::Waiting
            | Phase::Active
            | Phase::Done
            | Phase::Skipped
            | Phase::Failed { .. }
            | Phase::Canceled
            | Phase::Reopened
            | Phase::Again
            | Phase::Infeasible
            | Phase::Overtaken
            | Phase::Left
            | Phase::NotAsked
            | Phase::NotNeeded => stretches.push((at, phase.state())),
        }
    }
    stretches
}

/// The number of each step where it begins, where there is room for it.
fn steps(history: &History, axis: &Axis) -> String {
    let starts: Vec<usize> = history.steps().iter().map(|step| axis.cell(step.at)).collect();
    let mut line = vec![' '; axis.cells];
    for (index, &start) in starts.iter().enumerate() {
        let end = starts.get(index + 1).map_or(axis.cells, |&next| next);
        let number = format!("╷{}", index + 1);
        if start < axis.cells {
            line[start] = '╷';
        }
        if start + columns(&number) <= end {
            for (cell, glyph) in line[start..].iter_mut().zip(number.chars()) {
                *cell = glyph;
            }
        }
    }
    line.into_iter().collect()
}

fn bar(stretches: &[(Time, LeafState)], axis: &Axis) -> Vec<Cell> {
    let mut cells: Vec<Cell> = vec![(' ', None); axis.cells];
    let mut least = 0;
    for &(from, state) in stretches {
        let start = axis.cell(from).max(least).min(axis.cells);
        let fill = |cells: &mut [Cell], glyph: char, state| cells.fill((glyph, state));
        match state {
            LeafState::Waiting | LeafState::Active | LeafState::Done => {
                fill(&mut cells[start..], glyph(state), Some(state));
            }
            LeafState::Skipped => {
                let mark = start.min(axis.cells - 1);
                fill(&mut cells[mark..], glyph(LeafState::Done), Some(LeafState::Done));
                cells[mark] = (glyph(state), Some(state));
            }
            LeafState::NotAsked => fill(&mut cells[start..], ' ', None),
            LeafState::NotNeeded => {
                let mark = start.min(axis.cells - 1);
                fill(&mut cells[mark..], ' ', None);
                cells[mark] = (glyph(state), Some(state));
            }
            LeafState::Failed | LeafState::Canceled => {
                fill(&mut cells[start..], ' ', None);
                cells[start.saturating_sub(1)] = (glyph(state), Some(state));
            }
        }
        least = if state == LeafState::Active { start + 1 } else { start };
    }
    cells
}

/// What did it instead, where there is room for it behind the sign.
fn say_who_did_it(history: &History, leaf: NodeId, cells: &mut [Cell]) {
    let Some(way) = history.instead_of(leaf).filter(|_| history.state(leaf) == LeafState::NotNeeded) else { return };
    let from = cells.iter().rposition(|cell| cell.1.is_some()).map_or(0, |last| last + 2);
    let said = phrase::did_it(way, history.names());
    let room = cells.len().saturating_sub(from);
    if columns(&said) <= room && said.chars().count() == columns(&said) {
        for (cell, letter) in cells[from..].iter_mut().zip(said.chars()) {
            *cell = (letter, None);
        }
    }
}

fn painted(cells: &[Cell], palette: &Palette) -> String {
    let runs = cells.chunk_by(|one, next| one.1 == next.1).map(|run| {
        let glyphs: String = run.iter().map(|&(glyph, _)| glyph).collect();
        match run[0].1 {
            Some(state) => Palette::paint(palette.of(state), glyphs),
            None => glyphs,
        }
    });
    runs.collect::<String>().trim_end().to_owned()
}

/// What the glyphs mean that occur, in as many lines as it takes.
fn legend(shown: &BTreeSet<LeafState>, width: usize, palette: &Palette) -> String {
    let entries: Vec<String> = shown.iter().map(|&state| format!("{} {} ", glyph(state), state.word())).collect();
    let text = flow("", 0, entries.iter().map(String::as_str), width - 2);
    let paint = |letter: char| match LeafState::VARIANTS.iter().find(|state| glyph(**state) == letter) {
        Some(state) => Palette::paint(palette.of(*state), letter),
        None => letter.to_string(),
    };
    text.lines().map(|line| format!(" {}\n", line.trim_end().chars().map(paint).collect::<String>())).collect()
}
