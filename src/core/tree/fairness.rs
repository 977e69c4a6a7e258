//! Fairness between tasks: one that waits for long comes before those that came after it (`semantics` 6, "Fairness").

use std::collections::{BTreeMap, BTreeSet};

use super::Verdict;
use super::reasons::{Reasons, task_of};
use ambidex_model::state::State;
use ambidex_model::{NodeId, TreeSpec};

/// How many grants to later tasks each task that waits has seen.
#[derive(Debug, Default)]
pub(super) struct Fairness {
    seen: BTreeMap<NodeId, u32>,
}

/// The task that comes before a behavior of another one that is as urgent and holds nothing.
pub(super) fn barred_by(tree: &TreeSpec, state: &State, leaf: NodeId) -> Option<NodeId> {
    if state.overdue().is_empty() {
        return None;
    }
    let own = task_of(tree, leaf)?;
    if state.overdue().contains(&own) || holds(state, own) {
        return None;
    }
    state.overdue().iter().copied().find(|task| tree.priority(*task) == tree.priority(own))
}

/// Tasks that hold something.
pub(super) fn holding(tree: &TreeSpec, state: &State) -> BTreeSet<NodeId> {
    state.table().leases().filter_map(|(_, lease)| task_of(tree, lease.holder)).collect()
}

/// Whether something of a task holds anything.
fn holds(state: &State, task: NodeId) -> bool {
    state.table().leases().any(|(_, lease)| state.topology().is_within(lease.holder, task))
}

impl Fairness {
    /// How many grants to later tasks each task that waits has seen.
    pub(super) fn seen(&self) -> &BTreeMap<NodeId, u32> {
        &self.seen
    }

    pub(super) fn restore(&mut self, seen: BTreeMap<NodeId, u32>) {
        self.seen = seen;
    }

    /// A task is gone.
    pub(super) fn forget(&mut self, task: NodeId) {
        self.seen.remove(&task);
    }

    /// The tasks that are overdue once some grants are made; none where they are the same as before.
    pub(super) fn overdue(
        &mut self,
        tree: &TreeSpec,
        state: &State,
        reasons: &Reasons,
        verdict: &Verdict,
    ) -> Option<Vec<NodeId>> {
        if tree.tasks.len() < 2 {
            return None;
        }
        let mut served: BTreeMap<NodeId, u32> = BTreeMap::new();
        for task in verdict.granted.keys().filter_map(|leaf| task_of(tree, *leaf)) {
            *served.entry(task).or_default() += 1;
        }
        let mut later: u32 = served.values().sum();
        let is_idle = state.running().is_empty() && verdict.granted.is_empty();
        for &task in &tree.tasks {
            let own = served.get(&task).copied().unwrap_or_default();
            later -= own;
            let waits = reasons.waits(task);
            let is_lifted = is_idle && state.overdue().contains(&task);
            if own > 0 || !waits || is_lifted {
                self.seen.remove(&task);
            } else if later > 0 {
                *self.seen.entry(task).or_default() += later;
            }
        }
        let overdue =
            tree.tasks.iter().copied().filter(|task| self.seen.get(task).is_some_and(|seen| *seen >= tree.bypass));
        let overdue: Vec<NodeId> = overdue.collect();
        let is_same = overdue.iter().eq(state.overdue().iter());
        (!is_same).then_some(overdue)
    }
}
