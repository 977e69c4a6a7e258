//! The paper's Fig. 7 in a terminal: one row per behavior, robot time from left to right.

use std::collections::BTreeSet;
use std::fmt::Write;

use ambidex_model::{NodeId, Tally, Time};

use super::axis::Axis;
use super::course::Course;
use super::text::{MIN_WIDTH, clip, columns, count, fit, flow};
use super::{LeafState, Palette};

/// Most leaves that are all drawn; of more, those that ran.
const MAX_ROWS: usize = 60;

/// What stands in one cell; none where there is nothing more to say.
type Cell = (char, Option<LeafState>);

/// The timing diagram of a run: when each behavior was waiting, active, done or skipped (Fig. 7).
///
/// Steps are numbered above the bars where they begin, seconds of robot time stand below them.
pub fn timing(tally: &Tally, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let course = Course::new(tally);
    let (leaves, left_out) = rows(&course);
    let label_width =
        leaves.iter().map(|&leaf| columns(course.name(leaf))).chain([4]).max().unwrap_or_default().min(width / 3);
    let axis = axis(tally, width - label_width - 3);
    let label = |label: &str| format!(" {} ", fit(label, label_width));
    let mut text = String::new();
    let faint = |line: &str| Palette::paint(palette.faint, line.trim_end());
    let _ = writeln!(text, "{}", faint(&(label("step") + &steps(&course, &axis))));
    let mut shown = BTreeSet::new();
    for leaf in leaves {
        let cells = bar(&course.stretches(leaf), &axis);
        shown.extend(cells.iter().filter_map(|&(_, state)| state));
        let _ = writeln!(text, "{}{}", label(course.name(leaf)), painted(&cells, palette));
    }
    let [ruler, seconds] = axis.ruler();
    let _ = writeln!(text, "{}", faint(&(label("") + &ruler)));
    let unit = if label_width < 7 { "s" } else { "seconds" };
    let unit = format!(" {unit:>label_width$} ");
    let _ = writeln!(text, "{}", faint(&(unit + &seconds)));
    text.push_str(&legend(&shown, width, palette));
    if left_out > 0 {
        let note = format!(" {} that did not run left out", count(left_out, "behavior"));
        let _ = writeln!(text, "{}", faint(&clip(&note, width)));
    }
    text
}

/// The leaves to draw and how many are left out.
fn rows(course: &Course) -> (Vec<NodeId>, usize) {
    let mut leaves = course.leaves();
    let all = leaves.len();
    if all > MAX_ROWS {
        leaves.retain(|&leaf| course.has_run(leaf));
    }
    let left_out = all - leaves.len();
    (leaves, left_out)
}

/// From the first grant, since waiting for controllers says nothing of the task.
fn axis(tally: &Tally, cells: usize) -> Axis {
    let first = tally.intervals.iter().map(|run| run.from).min();
    let last = tally.intervals.iter().filter_map(|run| run.to).max();
    let runs_on = tally.intervals.iter().any(|run| run.to.is_none());
    let end = last.filter(|_| !runs_on).unwrap_or(tally.now);
    Axis::new(first.unwrap_or_default(), end, cells)
}

/// The number of each step where it begins, where there is room for it.
fn steps(course: &Course, axis: &Axis) -> String {
    let starts: Vec<usize> = course.step_times().iter().map(|&at| axis.cell(at)).collect();
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
                fill(&mut cells[start..], state.glyph(), Some(state));
            }
            LeafState::Skipped => {
                let mark = start.min(axis.cells - 1);
                fill(&mut cells[mark..], LeafState::Done.glyph(), Some(LeafState::Done));
                cells[mark] = (state.glyph(), Some(state));
            }
            LeafState::Failed | LeafState::Canceled => {
                fill(&mut cells[start..], ' ', None);
                cells[start.saturating_sub(1)] = (state.glyph(), Some(state));
            }
        }
        least = if state == LeafState::Active { start + 1 } else { start };
    }
    cells
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
    let entry = |state: LeafState| format!("{} {} ", state.glyph(), state.word());
    let entries: Vec<String> = shown.iter().map(|&state| entry(state)).collect();
    let mut text = String::new();
    for line in flow(entries.iter().map(String::as_str), width - 2) {
        let line = format!(" {}", line.trim_end());
        let _ = writeln!(text, "{}", colored(&line, palette));
    }
    text
}

/// Glyphs of a legend line in the style that they have in the bars.
fn colored(line: &str, palette: &Palette) -> String {
    let paint = |glyph: char| {
        let state = LeafState::ALL.into_iter().find(|state| state.glyph() == glyph);
        match state {
            Some(state) => Palette::paint(palette.of(state), glyph),
            None => glyph.to_string(),
        }
    };
    line.chars().map(paint).collect()
}
