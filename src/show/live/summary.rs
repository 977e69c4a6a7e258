//! The text at the end of a run: how it ended, its steps, what was skipped, and why where it did not get to its end.

use std::borrow::Cow;
use std::fmt::Write;

use ambidex_model::{MissionEnd, NodeId, ResourceId};
use ambidex_record::{History, LeafState};

use crate::Palette;
use crate::text::phrase::{did_it, part};
use crate::text::{MIN_WIDTH, clip, columns, count, ending, fit, flow, hang, mark};

/// Most causes that are told.
const MAX_REASONS: usize = 60;

/// What came of a run, in words.
pub fn summary(history: &History, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let (state, word, why) = ending(history);
    let mission = Palette::paint(palette.strong, clip(&history.header().mission, width / 2));
    let mut text = format!("{mission}: {}\n", Palette::paint(palette.of(state), word));
    text.extend(why.map(|why| hang("  ", 2, &why, width)));
    text.push_str(&figures(history, width));
    if history.end().is_some_and(|end| end != MissionEnd::Done) {
        text.push_str(&held(history, width));
    }
    text.push('\n');
    text.push_str(&steps(history, width, palette));
    text.push_str(&skipped(history, width, palette));
    text.push_str(&not_needed(history, width, palette));
    match history.end() {
        None | Some(MissionEnd::Done) => {}
        Some(MissionEnd::Stalled) => text.push_str(&causes("what cannot run, and why", history, width, palette)),
        Some(_) => text.push_str(&causes("what was waiting, and why", history, width, palette)),
    }
    text
}

fn figures(history: &History, width: usize) -> String {
    let steps = count(history.step_count(), "step");
    let (rounds, messages) = (count(history.rounds(), "round"), count(history.messages(), "message"));
    let said = format!("{steps} in {:.1} s of robot time, {rounds}, {messages} between nodes", history.makespan_s());
    hang("  ", 2, &said, width)
}

/// The steps with their numbers.
fn steps(history: &History, width: usize, palette: &Palette) -> String {
    let digits = history.steps().len().to_string().len().max(2);
    let mut text = String::new();
    for (index, step) in history.steps().iter().enumerate() {
        let mut names: Vec<&str> = step.leaves.iter().map(|&leaf| history.names().node(leaf)).collect();
        names.sort_unstable();
        let last = names.pop().unwrap_or_default();
        let items: Vec<String> = names.iter().map(|name| format!("{name} +")).chain([last.to_owned()]).collect();
        let number = Palette::paint(palette.faint, format!("{:>digits$}", index + 1));
        text += &flow(&format!("  {number}  "), digits + 4, items.iter().map(String::as_str), width);
    }
    text
}

/// What was done without running, with its moment.
fn skipped(history: &History, width: usize, palette: &Palette) -> String {
    let names = history.names();
    let said = |(leaf, at): &(NodeId, _)| (names.node(*leaf).into(), format!("its goal was met already ({at})"));
    let rows: Vec<_> = history.skipped().iter().map(said).collect();
    section("skipped", LeafState::Skipped, &rows, width, palette)
}

/// The ways that an OR did not need, each with the one that did it.
fn not_needed(history: &History, width: usize, palette: &Palette) -> String {
    let names = history.names();
    let left = history.ways_left().into_iter().map(|(way, by)| (part(way, names), did_it(by, names)));
    section("not needed", LeafState::NotNeeded, &left.collect::<Vec<_>>(), width, palette)
}

/// Every leaf that waits, or waited at the end, for a reason of its own.
fn causes(head: &str, history: &History, width: usize, palette: &Palette) -> String {
    let names = history.names();
    let causes = history.causes();
    let rows = causes.iter().take(MAX_REASONS);
    let rows: Vec<_> = rows.map(|(leaf, reason)| (names.node(*leaf).into(), reason.sentence(names))).collect();
    let mut text = section(head, LeafState::Waiting, &rows, width, palette);
    if rows.len() < causes.len() {
        let _ = writeln!(text, "  {} more", count(causes.len() - rows.len(), "behavior"));
    }
    text
}

/// What is in the robot's hands where the mission did not get to its end.
fn held(history: &History, width: usize) -> String {
    let names = history.names();
    let resources = (0..names.resources.len()).map(ResourceId::from);
    let held = resources.filter_map(|resource| {
        let object = history.world().held_by(resource)?;
        Some(format!("{} still holds {}", names.resource(resource), names.object(object)))
    });
    held.map(|said| hang("  ", 2, &said, width)).collect()
}

/// A head and a table below it; nothing of nothing.
fn section(head: &str, state: LeafState, rows: &[(Cow<'_, str>, String)], width: usize, palette: &Palette) -> String {
    match rows {
        [] => String::new(),
        rows => {
            let mark = Palette::paint(palette.of(state), mark(state));
            format!("\n{}\n{}", Palette::paint(palette.strong, head), table(rows, &mark, width))
        }
    }
}

/// Names at the left, wrapped sentences at the right.
fn table(rows: &[(Cow<'_, str>, String)], mark: &str, width: usize) -> String {
    let longest = rows.iter().map(|(name, _)| columns(name)).max();
    let name_width = longest.unwrap_or_default().min(width / 3);
    let row = |(name, sentence): &(Cow<'_, str>, String)| {
        hang(&format!("  {mark} {}  ", fit(name, name_width)), name_width + 6, sentence, width)
    };
    rows.iter().map(row).collect()
}
