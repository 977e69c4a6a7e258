//! What an audit came to, as text.

use std::fmt::Write;

use ambidex_record::LeafState;
use ambidex_record::audit::{AuditReport, LookedAt, Rule};
use strum::VariantArray;

use crate::Palette;
use crate::text::{MIN_WIDTH, count, hang, mark};

/// Most findings of one rule that are told one by one.
const MOST_TOLD: usize = 10;

/// A line for each rule, below it what does not hold; each line with its end.
pub fn text(report: &AuditReport, has_records: bool, width: usize, palette: &Palette) -> String {
    let width = width.max(MIN_WIDTH);
    let mut text = String::new();
    for rule in Rule::VARIANTS {
        if *rule == Rule::Records && !has_records {
            continue;
        }
        let found: Vec<_> = report.findings.iter().filter(|finding| finding.rule == *rule).collect();
        let state = if found.is_empty() { LeafState::Done } else { LeafState::Failed };
        let mark = Palette::paint(palette.of(state), mark(state));
        text += &hang(&format!("{mark} {:<10} ", rule.word()), 13, rule.sentence(), width);
        for finding in found.iter().take(MOST_TOLD) {
            let line = finding.line.map(|line| format!("line {line}: ")).unwrap_or_default();
            let at = finding.at.map(|at| format!(" ({at})")).unwrap_or_default();
            text += &hang("    ", 4, &format!("{line}{}{at}", finding.said), width);
        }
        if found.len() > MOST_TOLD {
            let _ = writeln!(text, "    and {} more", found.len() - MOST_TOLD);
        }
    }
    text.push('\n');
    text += &looked_at(report.records, &report.looked_at, has_records, width);
    if let Some(open) = &report.open {
        text += &hang("not ended: ", 11, open, width);
    }
    text
}

/// How much there was to be looked at.
pub(crate) fn looked_at(records: u64, all: &LookedAt, has_own: bool, width: usize) -> String {
    let parts = [
        count(records, "record"),
        count(all.grants, "grant"),
        count(all.refusals, "refusal"),
        count(all.commands, "command"),
        count(all.goals, "goal"),
        count(all.moves, "move") + " of objects",
    ];
    let own = has_own.then(|| count(all.own, "line") + " of controllers");
    let all: Vec<String> = parts.into_iter().chain(own).collect();
    hang("looked at ", 10, &all.join(", "), width)
}
