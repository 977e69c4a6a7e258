//! What the stalls of many trees came to, each under its line of the page.

use std::collections::BTreeMap;
use std::fmt;

use super::Verdict;
use super::flips::Cause;
use crate::property::generator::Case;
use crate::property::reference::Rule;

/// Of a hundred stalls, how many searches may be cut off.
const CUT_OFF_PERCENT: usize = 15;

/// Of a hundred stalls, how many may not be followed: in a few trees the model loses track of whom a certificate refused.
const NOT_FOLLOWED_PERCENT: usize = 1;
const NOT_FOLLOWED: &str = "not followed: the core and the reference model differ";
const UNEXPLAINED: &str = "unexplained";

#[derive(Debug, Default)]
pub struct Table {
    /// How many there are of each, with the first seed and its depth.
    lines: BTreeMap<String, (usize, u64, usize)>,
}

impl Table {
    pub fn add(&mut self, case: &Case, verdict: &Verdict) {
        let line = self.lines.entry(line(verdict)).or_insert((0, case.seed, case.depth));
        line.0 += 1;
    }

    /// Nothing is left unexplained, and few searches are cut off.
    pub fn check(&self) {
        let unexplained = self.lines.iter().find(|(name, _)| name.starts_with(UNEXPLAINED));
        if let Some((why, (_, seed, depth))) = unexplained {
            panic!("AMBIDEX_SEED={seed} AMBIDEX_DEPTH={depth}: {why}");
        }
        let all: usize = self.lines.values().map(|line| line.0).sum();
        let count = |name: &str| -> usize {
            let lines = self.lines.iter().filter(|(line, _)| line.starts_with(name));
            lines.map(|(_, line)| line.0).sum()
        };
        let (cut_off, not_followed) = (count("cut off"), count(NOT_FOLLOWED));
        assert!(not_followed * 100 <= all.max(100) * NOT_FOLLOWED_PERCENT, "{not_followed} of {all} are not followed");
        assert!(cut_off * 100 <= all.max(10) * CUT_OFF_PERCENT, "{cut_off} of {all} searches are cut off");
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all: usize = self.lines.values().map(|line| line.0).sum();
        writeln!(f, "{all} stalls, each with its first seed and depth")?;
        for (name, (count, seed, depth)) in &self.lines {
            writeln!(f, "  {count:5}  {name}  ({seed}, {depth})")?;
        }
        Ok(())
    }
}

fn line(verdict: &Verdict) -> String {
    match verdict {
        Verdict::NotFollowed => NOT_FOLLOWED.into(),
        Verdict::Unsolvable => "never solvable".into(),
        Verdict::CutOff(which) => format!("cut off: {which}"),
        Verdict::Forbidden(rules) => {
            let rules: Vec<_> = rules.iter().map(|rule| of_rule(*rule)).collect();
            format!("solvable but for: {}", rules.join("; "))
        }
        Verdict::Lost(cause) => format!("solvable until: {}", of_cause(*cause)),
        Verdict::Unexplained(why) => format!("{UNEXPLAINED}: {why}"),
    }
}

fn of_rule(rule: Rule) -> &'static str {
    match rule {
        Rule::LapsedWaits => "who lapsed waits for progress",
        Rule::RedoOnce => "sent back once in a progress",
        Rule::LeaveOnce => "a way is left once in a progress",
        Rule::RejectedWaits => "what was rejected waits for progress",
        Rule::Certificate => "would deadlock",
        Rule::SatisfiedFirst => "a satisfied way is before all",
        Rule::OwnTaskOnly => "work of another task would be done again",
    }
}

fn of_cause(cause: Cause) -> &'static str {
    match cause {
        Cause::Failed => "something failed or was interrupted",
        Cause::Otherwise => "something ended otherwise than its kind promises",
        Cause::Outside => "others changed the world",
        Cause::Away => "a controller went",
        Cause::TimeOver => "a node took too long",
        Cause::EndedFirst => "the wrong one ended first",
        Cause::Resource => "the wrong resource was granted",
        Cause::Way => "the wrong way was chosen",
        Cause::Skipped => "what was satisfied was passed over",
        Cause::World => "what came first changed what others need",
        Cause::Leases => "what came first took or gave back what others need",
        Cause::Early => "what came first would have had to come later",
        Cause::Needless => "what was granted need not have run",
        Cause::Beside => "what lapsed, was sent back, left, passed over or given up",
        Cause::WorldAndLeases => "what came first changed, and took or gave back, what others need",
    }
}
