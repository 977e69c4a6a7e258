//! Whose turn it is among tasks (`semantics` 6, "Fairness between tasks").

use ambidex::model::{NodeId, Reason};

use super::{Decision, Model, Refusal};

impl Model<'_> {
    fn tasks(&self) -> &[NodeId] {
        match self.mission.tree.tasks.as_slice() {
            [] | [_] => &[],
            tasks => tasks,
        }
    }

    fn task_of(&self, node: NodeId) -> Option<NodeId> {
        self.tasks().iter().copied().find(|task| self.below(*task).contains(node))
    }

    /// Whether the task of a behavior has waited for so long that it is its turn.
    pub(super) fn is_overdue(&self, leaf: NodeId) -> bool {
        self.task_of(leaf).is_some_and(|task| self.overdue.contains(&task))
    }

    /// The task before which a behavior is granted nothing.
    pub(super) fn too_early(&self, leaf: NodeId) -> Option<Refusal> {
        let own = self.task_of(leaf)?;
        let below = self.below(own);
        let holds = self.rows.iter().flat_map(|row| &row.leases).any(|held| below.contains(held.holder));
        if holds || self.is_bar_lifted || self.overdue.contains(&own) {
            return None;
        }
        let mut overdue = self.tasks().iter().filter(|task| self.overdue.contains(task));
        let task = *overdue.find(|task| self.told_priority(**task) == self.told_priority(own))?;
        Some(Reason::TooEarly { task }.into())
    }

    /// What a round came to for those that wait; all that are overdue, if that is different now.
    pub(super) fn note_fairness(&mut self, decision: &Decision) -> Option<Vec<NodeId>> {
        let tasks = self.tasks().to_vec();
        let granted = |task: &NodeId| decision.granted.keys().filter(|leaf| self.below(*task).contains(**leaf)).count();
        let mut overdue = Vec::new();
        let mut seen = self.seen.clone();
        for (index, task) in tasks.iter().enumerate() {
            let later: usize = tasks[index + 1..].iter().map(granted).sum();
            let count = seen.entry(*task).or_default();
            *count = if granted(task) > 0 { 0 } else { *count + later as u32 };
            let below = self.below(*task);
            let mut refused = decision.refused.range(below.from..below.to);
            let waits = refused.any(|(_, refusal)| refusal.reason.is_of_others());
            if waits && *count >= self.mission.tree.bypass {
                overdue.push(*task);
            }
        }
        self.seen = seen;
        let is_different = self.overdue.iter().ne(&overdue);
        self.overdue = overdue.iter().copied().collect();
        is_different.then_some(overdue)
    }

    /// Where nothing was granted while nothing runs the next round has no bar; true if there was one.
    pub(super) fn lift_bar(&mut self, decision: &Decision) -> bool {
        let is_early = |refusal: &Refusal| matches!(refusal.reason, Reason::TooEarly { .. });
        let is_barred = decision.refused.values().any(is_early);
        self.is_bar_lifted = is_barred && decision.granted.is_empty() && self.running.is_empty();
        self.is_bar_lifted
    }
}
