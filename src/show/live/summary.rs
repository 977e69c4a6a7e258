//! The text at the end of a run: how it ended, its steps, what was skipped, and why where it did not get to its end.

use std::fmt::Write;

use ambidex_model::{MissionEnd, NodeId, Reason};
use ambidex_record::{History, LeafState};

use crate::Palette;
use crate::text::{MIN_WIDTH, clip, columns, count, ending, fit, flow, hang, mark};

/// Most reasons that are all told; of more, those of leaves that were asked.
const MAX_REASONS: usize = 60;

/// What came of a run, in words.
pub fn summary(history: &History, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let (state, word, why) = ending(history);
    let mission = Palette::paint(palette.strong, clip(&history.header().mission, width / 2));
    let mut text = format!("{mission}: {}\n", Palette::paint(palette.of(state), word));
    text.extend(why.map(|why| hang("  ", 2, &why, width)));
    text.push_str(&figures(history, width));
    text.push('\n');
    text.push_str(&steps(history, width, palette));
    text.push_str(&skipped(history, width, palette));
    if history.end() == Some(MissionEnd::Stalled) {
        text.push_str(&reasons(history, width, palette));
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
    let skipped = history.skipped();
    if skipped.is_empty() {
        return String::new();
    }
    let said = |(leaf, at): &(NodeId, _)| (history.names().node(*leaf), format!("its goal was met already ({at})"));
    let rows: Vec<(&str, String)> = skipped.iter().map(said).collect();
    let head = format!("\n{}\n", Palette::paint(palette.strong, "skipped"));
    let mark = Palette::paint(palette.skipped, mark(LeafState::Skipped));
    head + &table(&rows, &mark, width)
}

/// Every leaf that cannot run, with its last reason.
fn reasons(history: &History, width: usize, palette: &Palette) -> String {
    let names = history.names();
    let mut open: Vec<_> = history.open().collect();
    let all = open.len();
    if all > MAX_REASONS {
        open.retain(|(_, reason)| !matches!(reason, None | Some(Reason::NotItsTurn { .. })));
        open.truncate(MAX_REASONS);
    }
    let row = |(leaf, reason): &(NodeId, Option<Reason>)| {
        let sentence = reason.as_ref().map_or("it was not asked".into(), |reason| reason.sentence(names));
        (names.node(*leaf), sentence)
    };
    let rows: Vec<(&str, String)> = open.iter().map(row).collect();
    let mut text = format!("\n{}\n", Palette::paint(palette.strong, "what cannot run, and why"));
    let mark = Palette::paint(palette.waiting, mark(LeafState::Waiting));
    text.push_str(&table(&rows, &mark, width));
    if rows.len() < all {
        let _ = writeln!(text, "  {} more", count(all - rows.len(), "behavior"));
    }
    text
}

/// Names at the left, wrapped sentences at the right.
fn table(rows: &[(&str, String)], mark: &str, width: usize) -> String {
    let longest = rows.iter().map(|(name, _)| columns(name)).max();
    let name_width = longest.unwrap_or_default().min(width / 3);
    let row = |(name, sentence): &(&str, String)| {
        hang(&format!("  {mark} {}  ", fit(name, name_width)), name_width + 6, sentence, width)
    };
    rows.iter().map(row).collect()
}
