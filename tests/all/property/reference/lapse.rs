//! When an intention lapses and when a THEN goes back (`semantics` 2).

use ambidex::model::{Blocked, Cause, Grant, LeaseKind, NodeId, NodeKind, Reason, Reopened, ResourceId};

use super::{Decision, Model, Refusal, Row};

impl Model<'_> {
    pub(super) fn lapse(&mut self, decision: &Decision) -> Option<Reopened> {
        let mut last: Option<(NodeId, NodeId, ResourceId)> = None;
        for (index, row) in self.rows.iter().enumerate() {
            for held in row.leases.iter().filter(|held| held.kind == LeaseKind::Intention) {
                let key = (held.holder, held.behavior, ResourceId::from(index));
                if self.is_hopeless(held.holder, decision) && last.is_none_or(|last| last < key) {
                    last = Some(key);
                }
            }
        }
        let (holder, leaf, resource) = last?;
        let below = self.below(holder);
        let heirs = || decision.refused.range(below.from..below.to);
        let lacking = heirs().find(|(_, refusal)| refusal.reason != Reason::Satisfied);
        let (&heir, refusal) = lacking.or(heirs().next())?;
        let lacks = Blocked { leaf: heir, reason: refusal.reason.clone() };
        self.end_intention(resource, holder);
        self.undo(holder, leaf);
        let cause = lacks.reason.root_cause().clone();
        self.silent.insert(leaf, (self.progress, heir, cause));
        self.let_choose_again(leaf);
        let cause = Cause::Lapse { resource, heir: Box::new(lacks) };
        Some(Reopened { node: leaf, up_to: holder, cause, undecided: Vec::new() })
    }

    /// Whether no heir runs and none waits for anything that runs.
    fn is_hopeless(&self, holder: NodeId, decision: &Decision) -> bool {
        let below = self.below(holder);
        let mut refused = decision.refused.range(below.from..below.to);
        !self.runs_below(holder) && !refused.any(|(_, refusal)| self.helps_waiting(refusal))
    }

    fn helps_waiting(&self, refusal: &Refusal) -> bool {
        refusal.waits
            || refusal.resources.iter().any(|&id| self.is_run(id))
            || refusal.behaviors.iter().any(|leaf| self.running.contains_key(leaf))
    }

    /// The first THEN with a behavior before its current child that kept an intention and is not so any more; of
    /// several behaviors the one nearest to the current child.
    pub(super) fn go_back(&mut self, decision: &Decision) -> Option<Reopened> {
        if !self.running.is_empty() || !self.waits.is_empty() {
            return None;
        }
        let is_before = |holder: NodeId, leaf: NodeId| {
            let below = self.below(holder);
            let activated = decision.refused.range(below.from..below.to).next();
            activated.is_some_and(|(&first, _)| leaf < first)
        };
        let mut lost: Vec<_> = self.keepers.iter().copied().collect();
        lost.retain(|&(holder, leaf)| is_before(holder, leaf) && !self.is_satisfied(leaf, &[]));
        let (first, _) = *lost.first()?;
        let of_first = lost.into_iter().filter(|(holder, _)| *holder == first);
        let (holder, leaf) = of_first.max()?;
        self.undo(holder, leaf);
        self.silent.remove(&leaf);
        Some(Reopened { node: leaf, up_to: holder, cause: Cause::Redo, undecided: Vec::new() })
    }

    /// What was kept for a skipped node is kept for the THEN that skipped it.
    pub(super) fn keep_skipped(&mut self, grant: &Grant, rows: &[Row]) {
        for skip in &grant.request.skips {
            let leases = rows.iter().flat_map(|row| &row.leases);
            let inside = leases.filter(|held| held.kind == LeaseKind::Intention && skip.contains(held.holder));
            let then = self.parent(skip.from);
            self.keepers.extend(inside.map(|held| (then, held.behavior)));
        }
    }

    /// The behavior and all between it and the holder are not done.
    fn undo(&mut self, holder: NodeId, leaf: NodeId) {
        self.keepers.remove(&(holder, leaf));
        for node in self.upward(leaf).into_iter().take_while(|&node| node != holder) {
            self.done.remove(&node);
        }
    }

    /// An OR with nothing done and nothing held below its child is free again.
    fn let_choose_again(&mut self, leaf: NodeId) {
        for node in self.upward(leaf) {
            let Some(&child) = self.committed.get(&node) else {
                continue;
            };
            assert_eq!(self.kind(node), &NodeKind::Or, "only an OR commits itself");
            let below = self.below(child);
            let is_done = self.done.iter().any(|&node| below.contains(node));
            let mut leases = self.rows.iter().flat_map(|row| &row.leases);
            let is_held = leases.any(|held| {
                let is_kept = held.kind == LeaseKind::Intention && below.contains(held.behavior);
                is_kept || below.contains(held.holder)
            });
            if !is_done && !is_held && !self.runs_below(child) {
                self.committed.remove(&node);
                self.rechoices += 1;
            }
        }
    }
}
