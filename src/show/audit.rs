//! What an audit came to, as text.

use std::fmt::Write;

use ambidex_record::LeafState;
use ambidex_record::audit::{AuditReport, Rule};
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
    let looked_at = report.looked_at;
    let parts = [
        count(report.records, "record"),
        count(looked_at.grants, "grant"),
        count(looked_at.refusals, "refusal"),
        count(looked_at.commands, "command"),
        count(looked_at.goals, "goal"),
        count(looked_at.moves, "move") + " of objects",
    ];
    let own = has_records.then(|| count(looked_at.own, "line") + " of controllers");
    let all: Vec<String> = parts.into_iter().chain(own).collect();
    let _ = write!(text, "\n{}", hang("looked at ", 10, &all.join(", "), width));
    if let Some(open) = &report.open {
        text += &hang("not ended: ", 11, open, width);
    }
    text
}
