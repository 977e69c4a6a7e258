//! What became of each leaf and when, read from a tally.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::model::{End, Interval, NodeId, Reason, Tally, Time};

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
            match run.end {
                Some(End::Failed(_)) => stretches.push((to, LeafState::Failed)),
                Some(End::Canceled) => stretches.push((to, LeafState::Canceled)),
                Some(End::Succeeded) | None => {}
            }
            let next = self.after(run, index + 1 == runs.len());
            if stretches.last().is_some_and(|&(_, state)| state != next) {
                stretches.push((to, next));
            }
        }
        if let Some(&at) = self.skips.get(&leaf) {
            stretches.push((at, LeafState::Skipped));
        }
        stretches
    }

    /// What a run leaves behind. What runs again, or is refused after it succeeded, had been reopened.
    fn after(&self, run: &Interval, is_last: bool) -> LeafState {
        let reason = self.tally.reasons.get(&run.leaf);
        let is_final = self.tally.end.is_some();
        let is_reopened = reason.is_some_and(|reason| *reason != Reason::Satisfied);
        match run.end {
            None => LeafState::Active,
            Some(_) if !is_last => LeafState::Waiting,
            Some(End::Succeeded) if is_reopened => LeafState::Waiting,
            Some(End::Succeeded) => LeafState::Done,
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
