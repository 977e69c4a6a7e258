//! When an intention lapses and when something is done again (`semantics` 2).

use ambidex::model::{
    Blocked, Cause, Condition, EffectTerm, LeaseKind, NodeId, NodeKind, Reason, Reopened, ResourceId, Task,
};

use super::{Decision, Held, Model, Refusal};

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
        Some(Reopened::new(leaf, holder, cause))
    }

    /// Whether no heir runs and none waits for anything that runs.
    fn is_hopeless(&self, holder: NodeId, decision: &Decision) -> bool {
        let below = self.below(holder);
        let mut refused = decision.refused.range(below.from..below.to);
        !self.runs_below(holder) && !refused.any(|(_, refusal)| self.helps_waiting(refusal))
    }

    fn helps_waiting(&self, refusal: &Refusal) -> bool {
        let waits_for_anybody =
            matches!(refusal.reason, Reason::Reserved { .. } | Reason::TooEarly { .. } | Reason::WouldDeadlock { .. });
        refusal.waits
            || (waits_for_anybody && !self.running.is_empty())
            || refusal.resources.iter().any(|&id| self.is_run(id))
            || refusal.behaviors.iter().any(|leaf| self.running.contains_key(leaf))
    }

    /// The first leaf that is helped by what others did, or by sending somebody back; true if others did it.
    pub(super) fn help_blocked(&mut self, decision: &Decision) -> (bool, Option<Reopened>) {
        for (&leaf, refusal) in &decision.refused {
            let Some((condition, reason)) = self.lacking(leaf).filter(|(_, reason)| *reason == refusal.reason) else {
                continue;
            };
            // Where the base will stand nobody knows.
            if matches!(reason, Reason::Driving { .. }) {
                continue;
            }
            if self.overtake(leaf) {
                return (true, None);
            }
            if matches!(reason, Reason::NoPath { .. }) {
                continue;
            }
            if let Some(reopened) = self.send_back(leaf, &condition) {
                return (false, Some(reopened));
            }
        }
        (false, None)
    }

    /// The nearest earlier behavior that would make so what a leaf lacks.
    pub(super) fn send_back(&mut self, leaf: NodeId, condition: &Condition) -> Option<Reopened> {
        let (maker, then) = self.maker(leaf, condition)?;
        let below = self.below(then);
        let was = self.redone.get(&maker).is_some_and(|(progress, _)| *progress == self.progress);
        if self.runs_below(then) || self.waits_below(then) || was {
            return None;
        }
        self.undo(then, maker);
        self.silent.remove(&maker);
        self.redone.insert(maker, (self.progress, Some(leaf)));
        for index in 0..self.rows.len() {
            let kept = self.rows[index].leases.clone();
            let is_below =
                |held: &&Held| held.kind == LeaseKind::Intention && held.holder != then && below.contains(held.holder);
            for held in kept.iter().filter(is_below) {
                self.end_intention(ResourceId::from(index), held.holder);
                self.undo(held.holder, held.behavior);
            }
        }
        let cause = Cause::Redo { leaf };
        Some(Reopened::new(maker, then, cause))
    }

    /// Upwards through the THENs above a leaf, backwards through what stands before it in each.
    fn maker(&self, leaf: NodeId, condition: &Condition) -> Option<(NodeId, NodeId)> {
        for pair in self.within(leaf).windows(2) {
            let [child, node] = *pair else { unreachable!() };
            if self.kind(node) != &NodeKind::Then {
                continue;
            }
            let before = (node.0 + 1..child.0).rev().map(NodeId);
            let leaves = before.filter(|node| matches!(self.kind(*node), NodeKind::Behavior(_)));
            let mut done = leaves.filter(|leaf| self.done.contains(leaf));
            let chosen = |leaf: &NodeId| {
                let path = self.upward(*leaf);
                let below = path.windows(2).take_while(|pair| pair[0] != node);
                let mut ors = below.filter(|pair| self.kind(pair[1]) == &NodeKind::Or);
                ors.all(|pair| self.committed.get(&pair[1]) == Some(&pair[0]))
            };
            if let Some(maker) = done.find(|leaf| self.promises(*leaf, condition) && chosen(leaf)) {
                return Some((maker, node));
            }
        }
        None
    }

    /// Whether a behavior's effects make a single condition true.
    pub(super) fn promises(&self, leaf: NodeId, condition: &Condition) -> bool {
        let spec = self.behavior(leaf);
        let drives = spec.commands.iter().any(|term| match (&term.task, condition) {
            (Task::DriveTo(_, goal), Condition::At { stands, tolerance_m, .. }) => {
                stands.iter().any(|stand| (goal.at.x - stand.at.x).hypot(goal.at.y - stand.at.y) <= *tolerance_m)
            }
            (Task::Grasp(_) | Task::GraspFrom(..) | Task::Put(..) | Task::PutInto(..), _) => false,
            (Task::DriveTo(..) | Task::Stand | Task::LookAt(_) | Task::Call(_), _) => false,
        });
        drives
            || spec.effects.iter().any(|effect| match (effect, condition) {
                (EffectTerm::Fact(a, x), Condition::Fact(b, y)) => (a, x) == (b, y),
                (EffectTerm::Lies(a, x), Condition::Lies(b, y)) => (a, x) == (b, y),
                (EffectTerm::Lies(a, _), Condition::Free(b)) => a == b,
                (EffectTerm::Taken(a, _), Condition::Held(hold)) => *a == hold.object,
                (EffectTerm::Stands(pose), Condition::At { stands, tolerance_m, .. }) => {
                    stands.iter().any(|stand| (pose.at.x - stand.at.x).hypot(pose.at.y - stand.at.y) <= *tolerance_m)
                }
                (EffectTerm::Taken(..) | EffectTerm::LetGo(..) | EffectTerm::Lies(..), _) => false,
                (EffectTerm::Fact(..) | EffectTerm::Stands(_), _) => false,
            })
    }

    /// The behavior and all between it and the holder are not done.
    pub(super) fn undo(&mut self, holder: NodeId, leaf: NodeId) {
        for node in self.upward(leaf).into_iter().take_while(|&node| node != holder) {
            self.done.remove(&node);
        }
    }

    /// An OR with nothing done and nothing held below its child is free again.
    pub(super) fn let_choose_again(&mut self, leaf: NodeId) {
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
