//! What goes wrong on purpose in goals: attempts are counted, and what is to come of each is said. Pure.

use std::collections::BTreeMap;
use std::time::Duration;

use ambidex_model::{Flaw, FlawKind, NodeId, ObjectId};

/// What behaviors do wrong on purpose, and how often each has begun.
#[derive(Debug, Clone, Default)]
pub struct Script {
    flaws: Vec<Flaw>,
    attempts: BTreeMap<NodeId, u32>,
}

/// What is to come of one attempt; nothing wrong by itself.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Plan {
    /// A controller gives up once all is achieved.
    pub(super) fails: bool,
    /// It does not end by itself.
    pub(super) hangs: bool,
    /// How much longer than it needs it takes at least.
    pub(super) late: Duration,
    /// What grippers lose as it begins; none is all that its grippers hold.
    pub(super) drops: Vec<Option<ObjectId>>,
}

impl Script {
    /// One in which no behavior has begun yet.
    pub fn new(flaws: Vec<Flaw>) -> Self {
        Self { flaws, attempts: BTreeMap::new() }
    }

    /// One thing more goes wrong.
    pub fn add(&mut self, flaw: Flaw) {
        self.flaws.push(flaw);
    }

    /// The next attempt of a behavior begins.
    pub(super) fn begin(&mut self, leaf: NodeId) -> Plan {
        let mut plan = Plan::default();
        if self.flaws.is_empty() {
            return plan;
        }
        let attempt = self.attempts.entry(leaf).or_default();
        *attempt += 1;
        for flaw in self.flaws.iter().filter(|flaw| flaw.is_of(leaf, *attempt)) {
            match flaw.kind {
                FlawKind::Fails => plan.fails = true,
                FlawKind::Hangs => plan.hangs = true,
                FlawKind::Late(by) => plan.late += by,
                FlawKind::Drops(object) => plan.drops.push(object),
            }
        }
        plan
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attempts_are_counted_by_behavior() {
        let flaw = |leaf, attempt, kind| Flaw { leaf: NodeId(leaf), attempt, kind };
        let mut script = Script::new(vec![
            flaw(1, Some(2), FlawKind::Fails),
            flaw(2, None, FlawKind::Hangs),
            flaw(2, Some(1), FlawKind::Drops(None)),
            flaw(3, None, FlawKind::Late(Duration::from_secs(2))),
        ]);
        let hangs = Plan { hangs: true, ..Plan::default() };
        let rows = [
            (1, Plan::default()),
            (2, Plan { drops: vec![None], ..hangs.clone() }),
            (1, Plan { fails: true, ..Plan::default() }),
            (1, Plan::default()),
            (2, hangs),
            (3, Plan { late: Duration::from_secs(2), ..Plan::default() }),
            (4, Plan::default()),
        ];
        for (leaf, expected) in rows {
            assert_eq!(script.begin(NodeId(leaf)), expected, "{leaf}");
        }
    }
}
