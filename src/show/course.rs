//! What became of each leaf and when, read from a tally.

use std::collections::BTreeMap;

use serde::Serialize;

use ambidex_model::{End, Interval, NodeId, Tally, Time};

/// What a leaf is at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LeafState {
    /// It has not run, or is to run again.
    Waiting,
    /// It runs.
    Active,
    /// It ran and is done.
    Done,
    /// It is done without having run.
    Skipped,
    /// It failed.
    Failed,
    /// It was told to end.
    #[serde(rename = "cancelled")]
    Canceled,
}

impl LeafState {
    /// All of them, in the order of a legend.
    pub(super) const ALL: [Self; 6] =
        [Self::Waiting, Self::Active, Self::Done, Self::Skipped, Self::Failed, Self::Canceled];

    /// What a person calls it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Active => "active",
            Self::Done => "done",
            Self::Skipped => "skipped",
            Self::Failed => "failed",
            Self::Canceled => "cancelled",
        }
    }

    /// The glyph that stands before a name.
    pub fn mark(self) -> char {
        match self {
            Self::Waiting => '○',
            Self::Active => '●',
            Self::Done => '✓',
            Self::Skipped | Self::Failed | Self::Canceled => self.glyph(),
        }
    }

    /// The glyph that bars are made of, with and without color.
    pub fn glyph(self) -> char {
        match self {
            Self::Waiting => '·',
            Self::Active => '█',
            Self::Done => '─',
            Self::Skipped => '◇',
            Self::Failed => '✗',
            Self::Canceled => '⊘',
        }
    }
}

impl From<End> for LeafState {
    fn from(end: End) -> Self {
        match end {
            End::Succeeded => Self::Done,
            End::Failed(_) => Self::Failed,
            End::Canceled => Self::Canceled,
        }
    }
}

/// A tally by leaf.
pub(super) struct Course<'a> {
    pub(super) tally: &'a Tally,
    runs: BTreeMap<NodeId, Vec<Interval>>,
    skips: BTreeMap<NodeId, Time>,
}

impl<'a> Course<'a> {
    pub(super) fn new(tally: &'a Tally) -> Self {
        let mut runs: BTreeMap<NodeId, Vec<Interval>> = BTreeMap::new();
        for run in &tally.intervals {
            runs.entry(run.leaf).or_default().push(*run);
        }
        let skips = tally.skipped.iter().copied().collect();
        Self { tally, runs, skips }
    }

    /// Every leaf in tree order; without a header those that are known.
    pub(super) fn leaves(&self) -> Vec<NodeId> {
        match &self.tally.header {
            Some(header) => (0..header.nodes.len())
                .filter(|&node| header.nodes[node].kind.is_behavior())
                .map(NodeId::from)
                .collect(),
            None => {
                let mut known: Vec<NodeId> = self.runs.keys().chain(self.skips.keys()).copied().collect();
                known.sort();
                known.dedup();
                known
            }
        }
    }

    pub(super) fn name(&self, node: NodeId) -> &'a str {
        let header = self.tally.header.as_ref();
        header.map_or("?", |header| header.names.node(node))
    }

    pub(super) fn has_run(&self, leaf: NodeId) -> bool {
        self.runs.contains_key(&leaf)
    }

    /// Whether a leaf is done, and whether it has begun.
    pub(super) fn standing(&self, leaf: NodeId) -> (bool, bool) {
        let is_done = matches!(self.state(leaf), LeafState::Done | LeafState::Skipped);
        (is_done, is_done || self.has_run(leaf))
    }

    /// How a leaf ended when it ran, first to last.
    pub(super) fn runs(&self, leaf: NodeId) -> &[Interval] {
        self.runs.get(&leaf).map_or(&[], Vec::as_slice)
    }

    /// What the leaf is now.
    pub(super) fn state(&self, leaf: NodeId) -> LeafState {
        if self.skips.contains_key(&leaf) {
            return LeafState::Skipped;
        }
        match self.runs(leaf).last() {
            None => LeafState::Waiting,
            Some(run) if run.reopened.is_some() => LeafState::Waiting,
            Some(run) => self.after(run, true),
        }
    }

    /// From when on the leaf was what; the first from the beginning.
    pub(super) fn stretches(&self, leaf: NodeId) -> Vec<(Time, LeafState)> {
        let mut stretches = vec![(Time::ZERO, LeafState::Waiting)];
        let runs = self.runs(leaf);
        for (index, run) in runs.iter().enumerate() {
            stretches.push((run.from, LeafState::Active));
            let Some(to) = run.to else { continue };
            stretches.extend(run.end.map(|end| (to, end.into())));
            let next = self.after(run, index + 1 == runs.len());
            if stretches.last().is_some_and(|&(_, state)| state != next) {
                stretches.push((to, next));
            }
            stretches.extend(run.reopened.map(|at| (at, LeafState::Waiting)));
        }
        if let Some(&at) = self.skips.get(&leaf) {
            stretches.push((at, LeafState::Skipped));
        }
        stretches
    }

    /// What a run leaves behind until it is reopened or runs again, or in the end.
    fn after(&self, run: &Interval, is_last: bool) -> LeafState {
        let is_final = run.is_final || self.tally.end.is_some();
        match run.end {
            None => LeafState::Active,
            Some(End::Succeeded) => LeafState::Done,
            Some(_) if !is_last => LeafState::Waiting,
            Some(End::Failed(_)) if is_final => LeafState::Failed,
            Some(End::Failed(_)) => LeafState::Waiting,
            Some(End::Canceled) => LeafState::Canceled,
        }
    }

    /// When each step began.
    pub(super) fn step_times(&self) -> Vec<Time> {
        let mut before = 0;
        let mut times = Vec::with_capacity(self.tally.steps.len());
        for step in &self.tally.steps {
            times.extend(self.tally.intervals.get(before).map(|run| run.from));
            before += step.len();
        }
        times
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{self, decided, grant, header, named, released, seconds};
    use ambidex_model::{Blocked, Consequences, Fault, Reason, Record, Reopened};

    fn refused(mut record: Record, name: &str, why: Reason) -> Record {
        if let Record::Decided { refused, .. } = &mut record {
            refused.push(Blocked { leaf: named(name), reason: why });
        }
        record
    }

    fn drive(at_s: f64, round: u32) -> Record {
        decided(at_s, round, vec![grant("move 1-1", &[], &[0], &[])])
    }

    fn reopen(at_s: f64, round: u32) -> Record {
        let why = Reopened { holder: named("object 1"), leaf: named("move 1-1"), lapsed: None, lacks: None };
        match decided(at_s, round, Vec::new()) {
            Record::Decided { at, round, granted, refused, .. } => {
                Record::Decided { at, round, granted, refused, reopened: Some(why) }
            }
            other => other,
        }
    }

    fn check(records: Vec<Record>, name: &str, expected: &[(f64, LeafState)]) {
        let head = Record::Header(Box::new(header()));
        let tally = sample::tally(&[vec![head], records].concat());
        let course = Course::new(&tally);
        let expected: Vec<_> = expected.iter().map(|&(at_s, state)| (seconds(at_s), state)).collect();
        assert_eq!(course.stretches(named(name)), expected);
        assert_eq!(course.state(named(name)), expected.last().expect("it begins with waiting").1);
    }

    #[test]
    fn what_is_done_stays_done_whatever_it_is_refused_for() {
        use LeafState::{Active, Done, Waiting};
        let done = vec![drive(0.0, 1), released(4.0, "move 1-1", End::Succeeded)];
        let done_then = |record| [done.clone(), vec![record]].concat();
        let expected = [(0.0, Waiting), (0.0, Active), (4.0, Done)];
        for why in [Reason::Ending { failed: named("object 2") }, Reason::Alternative { chosen: named("object 2") }] {
            check(done_then(refused(decided(5.0, 2, Vec::new()), "move 1-1", why)), "move 1-1", &expected);
        }
        let reopened = [(0.0, Waiting), (0.0, Active), (4.0, Done), (9.0, Waiting)];
        check(done_then(reopen(9.0, 2)), "move 1-1", &reopened);
        let met = refused(decided(9.5, 3, Vec::new()), "move 1-1", Reason::Satisfied);
        check([done_then(reopen(9.0, 2)), vec![met]].concat(), "move 1-1", &reopened);
        let again = [done_then(reopen(9.0, 2)), vec![drive(10.0, 3)]].concat();
        check(again, "move 1-1", &[&reopened[..], &[(10.0, Active)]].concat());
        let skip = decided(10.0, 3, vec![grant("pick 1", &[], &[2], &["move 1-1"])]);
        let skipped = [done_then(reopen(9.0, 2)), vec![skip]].concat();
        check(skipped, "move 1-1", &[&reopened[..], &[(10.0, LeafState::Skipped)]].concat());
    }

    #[test]
    fn a_last_failure_is_told_before_the_mission_is_over() {
        use LeafState::{Active, Failed, Waiting};
        let end = End::Failed(Fault::TimedOut);
        let fail = |failed| {
            let consequences = Consequences { completed: None, failed };
            Record::Released { at: seconds(2.0), leaf: named("move 1-1"), end, consequences, changes: Vec::new() }
        };
        let tried = [(0.0, Waiting), (0.0, Active), (2.0, Failed)];
        check(vec![drive(0.0, 1), fail(Some(named("object 1")))], "move 1-1", &tried);
        check(vec![drive(0.0, 1), fail(None)], "move 1-1", &[&tried[..], &[(2.0, Waiting)]].concat());
    }

    #[test]
    fn a_skip_is_no_longer_than_the_tree() {
        let mut endless = grant("pick 1", &[], &[2], &["move 1-1"]);
        std::sync::Arc::make_mut(&mut endless.request).skips[0].to = NodeId(u32::MAX);
        check(vec![decided(1.0, 1, vec![endless])], "place 4", &[(0.0, LeafState::Waiting), (1.0, LeafState::Skipped)]);
    }
}
