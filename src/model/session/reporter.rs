//! What a controller has told of the world, so that it says at once what is new and now and then all of it.

use super::REPEAT_EVERY;
use crate::Report;

/// Most facts and objects that one controller tells of; what is beyond is not told.
const SUBJECTS_MAX: usize = 64;

/// A report with the attachment in which it is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reported {
    /// The daemon that is told.
    pub epoch: u64,
    /// The attachment.
    pub generation: u32,
    /// What it is told.
    pub report: Report,
}

/// What was told, and when.
#[derive(Debug, Clone, Default)]
pub(super) struct Reporter {
    told: Vec<(Report, u64)>,
}

impl Reporter {
    /// What is to be told of all that is seen.
    pub(super) fn due(&mut self, mut seen: Vec<Report>, now_ns: u64) -> Vec<Report> {
        seen.retain(|report| self.is_due(*report, now_ns));
        seen
    }

    /// Nothing of it has been told.
    pub(super) fn forget(&mut self, report: &Report) {
        self.told.retain(|(told, _)| told != report);
    }

    pub(super) fn forget_all(&mut self) {
        self.told.clear();
    }

    /// Whether it tells of anything.
    pub(super) fn is_used(&self) -> bool {
        !self.told.is_empty()
    }

    fn is_due(&mut self, report: Report, now_ns: u64) -> bool {
        match self.told.iter().position(|(told, _)| told.is_about_that_of(&report)) {
            Some(index) => {
                let (told, at_ns) = &mut self.told[index];
                let is_old = u128::from(now_ns.saturating_sub(*at_ns)) >= REPEAT_EVERY.as_nanos();
                let is_due = *told != report || is_old;
                if is_due {
                    (*told, *at_ns) = (report, now_ns);
                }
                is_due
            }
            None if self.told.len() == SUBJECTS_MAX => false,
            None => {
                self.told.push((report, now_ns));
                true
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn what_is_new_is_told_at_once_and_the_rest_every_second() {
        let mut reporter = Reporter::default();
        let (open, shut, mug) =
            (Report::fact("open", true), Report::fact("open", false), Report::object("mug", Some("table")));
        let rows = [
            (0, vec![shut, mug], vec![shut, mug]),
            (100, vec![shut, mug], vec![]),
            (200, vec![open, mug], vec![open]),
            (1_000, vec![open, mug], vec![mug]),
            (1_200, vec![open, mug], vec![open]),
            (1_300, vec![], vec![]),
        ];
        for (now_ms, seen, expected) in rows {
            assert_eq!(reporter.due(seen, now_ms * MS), expected, "{now_ms} ms");
        }
        reporter.forget(&open);
        assert_eq!(reporter.due(vec![open, mug], 1_400 * MS), [open], "it could not be sent");
        let many: Vec<Report> = (0..100).map(|fact| Report::fact(&format!("fact {fact}"), true)).collect();
        assert_eq!(reporter.due(many, 1_500 * MS).len(), SUBJECTS_MAX - 2);
    }
}
