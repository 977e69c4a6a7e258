//! Whose turn it is among tasks (`semantics` 6, "Fairness between tasks").

use ambidex::model::{NodeId, Reason};

use super::{Decision, Model, Refusal};

/// The page says that requests of an overdue task come first and that it has wishes; the core does not do so yet.
const COMES_FIRST: bool = false;

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
        COMES_FIRST && self.task_of(leaf).is_some_and(|task| self.overdue.contains(&task))
    }

    /// The task before which a behavior is granted nothing.
    pub(super) fn too_early(&self, leaf: NodeId) -> Option<Refusal> {
        let own = self.task_of(leaf)?;
        let below = self.below(own);
        let holds = self.rows.iter().flat_map(|row| &row.leases).any(|held| below.contains(held.holder));
        if holds || self.overdue.contains(&own) {
            return None;
        }
        let mut overdue = self.tasks().iter().filter(|task| self.overdue.contains(task));
        let task = *overdue.find(|task| self.told_priority(**task) == self.told_priority(own))?;
        Some(Reason::TooEarly { task }.into())
    }

    /// What a round came to for those that wait; all that are overdue, if that is different now.
    pub(super) fn note_fairness(&mut self, decision: &Decision, was_idle: bool) -> Option<Vec<NodeId>> {
        let tasks = self.tasks().to_vec();
        let granted = |task: &NodeId| decision.granted.keys().filter(|leaf| self.below(*task).contains(**leaf)).count();
        let mut overdue = Vec::new();
        let mut seen = self.seen.clone();
        for (index, task) in tasks.iter().enumerate() {
            let later: usize = tasks[index + 1..].iter().map(granted).sum();
            let below = self.below(*task);
            let mut refused = decision.refused.range(below.from..below.to);
            let waits = refused.any(|(_, refusal)| refusal.reason.is_of_others());
            let count = seen.entry(*task).or_default();
            // Where nothing goes on the bar is lifted, and it has to wait as long again.
            let is_lifted = was_idle && decision.granted.is_empty() && self.overdue.contains(task);
            *count = if granted(task) > 0 || !waits || is_lifted { 0 } else { *count + later as u32 };
            if *count >= self.mission.tree.bypass {
                overdue.push(*task);
            }
        }
        self.seen = seen;
        let is_different = self.overdue.iter().ne(&overdue);
        self.overdue = overdue.iter().copied().collect();
        is_different.then_some(overdue)
    }
}
