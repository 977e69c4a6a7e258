//! Attempts of behaviors, from the grant to the end.

use std::collections::BTreeMap;

use ambidex_model::{End, Grant, NodeId, Reason, Record, Time};
use ambidex_record::History;

/// An attempt of a behavior.
#[derive(Debug, Clone)]
pub(super) struct Attempt {
    /// What was granted.
    pub(super) grant: Grant,
    /// Which attempt of the behavior it is, from 1.
    pub(super) number: u32,
    /// The round that granted it.
    pub(super) round: u32,
    /// When it was granted, since the mission began.
    pub(super) granted: Time,
    /// What it had waited for until then.
    pub(super) waited_for: Option<Reason>,
    /// When and how it ended; none where it goes on when the log ends.
    pub(super) ended: Option<(Time, End)>,
}

/// What begins and ends with a record.
#[derive(Debug, Default)]
pub(super) struct Turnover {
    /// What ended.
    pub(super) ended: Vec<Attempt>,
    /// What began.
    pub(super) begun: Vec<Attempt>,
}

/// The attempts that are under way, and how many there were of each behavior.
#[derive(Debug, Default)]
pub(super) struct Attempts {
    open: BTreeMap<NodeId, Attempt>,
    counts: BTreeMap<NodeId, u32>,
}

impl Attempts {
    /// Takes the next record, which the history has not taken yet: it still knows what was waited for.
    pub(super) fn take(&mut self, before: &History, record: &Record) -> Turnover {
        let now = before.moment(record.at());
        let mut turnover = Turnover::default();
        if let Record::Decided { granted, round, .. } = record {
            for grant in granted {
                let count = self.counts.entry(grant.leaf()).or_default();
                *count += 1;
                let attempt = Attempt {
                    grant: grant.clone(),
                    number: *count,
                    round: *round,
                    granted: now,
                    waited_for: before.leaf(grant.leaf()).and_then(|leaf| leaf.reason()).cloned(),
                    ended: None,
                };
                turnover.ended.extend(self.open.insert(grant.leaf(), attempt.clone()));
                turnover.begun.push(attempt);
            }
        }
        if let Record::Released { leaf, end, .. } = record {
            let ended = self.open.remove(leaf);
            turnover.ended.extend(ended.map(|attempt| Attempt { ended: Some((now, *end)), ..attempt }));
        }
        turnover
    }

    /// Whether a behavior has an attempt under way.
    pub(super) fn is_open(&self, leaf: NodeId) -> bool {
        self.open.contains_key(&leaf)
    }

    /// What goes on.
    pub(super) fn into_open(self) -> impl Iterator<Item = Attempt> {
        self.open.into_values()
    }
}

/// The task that a node belongs to: the part of the mission just below its top, or what it is itself where it is no part
/// of one.
pub(super) fn task_of(history: &History, node: NodeId) -> NodeId {
    history.task_of(node)
}
