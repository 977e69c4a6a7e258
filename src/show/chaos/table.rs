//! The runs as tables.

use std::collections::BTreeMap;
use std::fmt::Write;

use ambidex_record::LeafState;
use ambidex_record::audit::LookedAt;
use strum::VariantArray;

use super::{ChaosReport, ChaosRun, Outcome};
use crate::Palette;
use crate::audit;
use crate::text::{MIN_WIDTH, columns, count, fit, hang, mark};

/// Most findings that are told one by one.
const MOST_TOLD: usize = 40;

/// All of it, each line with its end.
pub fn text(report: &ChaosReport, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    missions(report, palette) + &deeds(report, palette) + &looked_at(report, width) + &findings(report, width, palette)
}

/// How the runs of each mission ended.
fn missions(report: &ChaosReport, palette: &Palette) -> String {
    let mut missions: BTreeMap<&str, BTreeMap<Outcome, usize>> = BTreeMap::new();
    let mut all: BTreeMap<Outcome, usize> = BTreeMap::new();
    for run in &report.runs {
        *missions.entry(&run.mission).or_default().entry(run.outcome).or_default() += 1;
        *all.entry(run.outcome).or_default() += 1;
    }
    let shown: Vec<Outcome> = Outcome::VARIANTS.iter().copied().filter(|outcome| all.contains_key(outcome)).collect();
    let name_width = missions.keys().map(|name| columns(name)).max().unwrap_or_default().clamp(7, 30);
    let head = shown.iter().map(|outcome| format!("  {}", word(*outcome))).collect::<String>();
    let mut text = format!("{}\n", Palette::paint(palette.strong, fit("mission", name_width) + "    runs" + &head));
    let row = |name: &str, ends: &BTreeMap<Outcome, usize>| {
        let runs: usize = ends.values().sum();
        let mut row = format!("{}  {runs:>6}", fit(name, name_width));
        for outcome in &shown {
            let times = ends.get(outcome).copied().unwrap_or_default();
            let _ = write!(
                row,
                "  {:>1$}",
                if times == 0 { "·".into() } else { times.to_string() },
                columns(word(*outcome))
            );
        }
        row + "\n"
    };
    missions.iter().for_each(|(name, ends)| text += &row(name, ends));
    if missions.len() > 1 {
        text += &row("all", &all);
    }
    text
}

fn word(outcome: Outcome) -> &'static str {
    outcome.into()
}

/// What was done to them.
fn deeds(report: &ChaosReport, palette: &Palette) -> String {
    let mut done: BTreeMap<&str, (u32, usize)> = BTreeMap::new();
    for run in &report.runs {
        for (deed, times) in &run.done {
            let (all, runs) = done.entry(deed).or_default();
            *all += times;
            *runs += 1;
        }
    }
    if done.is_empty() {
        return String::new();
    }
    let longest = done.keys().map(|deed| columns(deed)).max().unwrap_or_default();
    let mut text = format!("\n{}\n", Palette::paint(palette.strong, "what was done"));
    for (deed, (times, runs)) in done {
        let _ = writeln!(text, "  {}  {times:>6} in {}", fit(deed, longest), count(runs, "run"));
    }
    text
}

fn looked_at(report: &ChaosReport, width: usize) -> String {
    let records = report.runs.iter().map(|run| run.records).sum();
    let all: LookedAt = report.runs.iter().map(|run| run.looked_at).sum();
    format!("\n{}", audit::looked_at(records, &all, true, width))
}

fn findings(report: &ChaosReport, width: usize, palette: &Palette) -> String {
    let of = |run: &'_ ChaosRun| -> Vec<(u64, String)> {
        run.findings.iter().map(|finding| (run.seed, format!("{}: {finding}", run.mission))).collect()
    };
    let found: Vec<(u64, String)> = report.runs.iter().flat_map(of).collect();
    if found.is_empty() {
        let mark = Palette::paint(palette.of(LeafState::Done), mark(LeafState::Done));
        return format!("{mark} nothing was found in {}\n", count(report.runs.len(), "run"));
    }
    let mark = Palette::paint(palette.of(LeafState::Failed), mark(LeafState::Failed));
    let mut text = format!("\n{}\n", Palette::paint(palette.strong, "what was found"));
    for (seed, said) in found.iter().take(MOST_TOLD) {
        text += &hang(&format!("  {mark} seed {seed:<6} "), 16, said, width);
    }
    if found.len() > MOST_TOLD {
        let _ = writeln!(text, "  and {} more", found.len() - MOST_TOLD);
    }
    text
}
