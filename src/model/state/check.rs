//! Whether what a record says can be so: records may come from a file that anybody wrote.

use super::{Phase, State};
use crate::{
    Cause, Change, Consequences, Grant, Kept, LeaseKind, Lineage, NodeId, NodeRange, Reopened, ResourceId, Told,
};

impl State {
    /// Whether what root is told can be so: it is about what there is, and about behaviors that run or ran.
    pub fn knows_of(&self, told: &Told) -> bool {
        match told {
            Told::Begin { changes } => changes.iter().all(|change| self.knows(*change)),
            Told::World { change, .. } => self.knows(*change),
            Told::Service { changes, .. } => changes.iter().all(|change| self.knows(*change)),
            Told::Ended { leaf, outcome } => {
                let has_run = self.running.contains_key(leaf);
                has_run && outcome.changes.iter().all(|change| self.knows(*change))
            }
            Told::Resumed | Told::Woke | Told::Work { .. } | Told::End { .. } => true,
        }
    }

    pub(super) fn knows(&self, change: Change) -> bool {
        match change {
            Change::Base(_) | Change::Blocked(_) | Change::Cleared(_) => true,
            Change::Emptied(resource) => resource.index() < self.table.count(),
            Change::Object(object, at) => {
                let are_known = at.holders().iter().all(|by| by.index() < self.table.count());
                object.index() < self.world.objects.len() && are_known
            }
            Change::Laid(object, ..) => object.index() < self.world.objects.len(),
            Change::Taken(object, by) => object.index() < self.world.objects.len() && by.index() < self.table.count(),
            Change::Fact(fact, _) => fact.index() < self.world.facts.len(),
        }
    }

    /// Ids are known, the behavior does not run, and nobody stands in its way.
    pub(super) fn can_grant(&self, grant: &Grant) -> bool {
        let leaf = grant.leaf();
        if !self.has(leaf)
            || self.running.contains_key(&leaf)
            || !grant.request.skips.iter().all(|skip| self.is_skip(skip))
        {
            return false;
        }
        let line = Lineage { topology: &self.topology, node: leaf, skips: &grant.request.skips };
        let is_free = |resource: ResourceId, access| {
            let known = (resource.index() < self.table.count()).then(|| self.table.resource(resource));
            known.is_some_and(|known| known.service().is_available() && known.obstacle(&line, access).is_none())
        };
        grant.met.iter().all(|node| self.has(*node))
            && grant.bindings.iter().all(|binding| is_free(binding.resource, binding.access))
    }

    pub(super) fn can_reopen(&self, reopened: &Reopened) -> bool {
        let lapses = match reopened.cause {
            Cause::Lapse { resource, .. } if resource.index() < self.table.count() => {
                let mut leases = self.table.resource(resource).leases().iter();
                leases.any(|lease| lease.holder == reopened.up_to && lease.kind == LeaseKind::Intention)
            }
            Cause::Lapse { .. } => false,
            Cause::Redo { leaf } => self.has(leaf),
            Cause::Leave => {
                let is_child = self.has(reopened.node) && self.topology.parent(reopened.node) == reopened.up_to;
                return is_child && !self.is_busy(reopened.node);
            }
            Cause::Yield => {
                let is_kept = |kept: &Kept| self.holds_intention(kept);
                return self.has(reopened.node) && reopened.ended.iter().all(is_kept);
            }
            Cause::Repeat { .. } => {
                return self.has(reopened.node) && reopened.node.0 > 0 && !self.is_busy(reopened.node);
            }
            Cause::Retry { .. } => {
                let is_below = |node: &NodeId| self.is_above(reopened.node, *node);
                let is_known = self.has(reopened.node) && reopened.node.0 > 0 && !self.is_busy(reopened.node);
                return is_known && reopened.reset.is_sorted() && reopened.reset.iter().all(is_below);
            }
        };
        let is_kept = |kept: &Kept| {
            let is_below = self.is_above(reopened.up_to, kept.holder) && self.is_above(kept.holder, kept.behavior);
            is_below && self.holds_intention(kept)
        };
        lapses
            && reopened.ended.iter().all(is_kept)
            && self.is_above(reopened.up_to, reopened.node)
            && reopened.undecided.iter().all(|or| self.has(*or))
    }

    fn holds_intention(&self, kept: &Kept) -> bool {
        let leases = (kept.resource.index() < self.table.count()).then(|| self.table.resource(kept.resource).leases());
        let mut leases = leases.into_iter().flatten();
        leases.any(|lease| lease.holder == kept.holder && lease.kind == LeaseKind::Intention)
    }

    /// A node with body and cleanup that is not over, and of which nothing runs.
    pub(super) fn can_clean(&self, node: NodeId) -> bool {
        let is_known = node.0 > 0 && self.has(node);
        let has_cleanup = || self.topology.children(node).last().is_some_and(|last| self.topology.is_cleanup(last));
        is_known
            && has_cleanup()
            && !self.is_busy(node)
            && !matches!(self.phase(node), Phase::Done | Phase::Failed | Phase::Cleaning(_))
    }

    pub(super) fn can_release(&self, leaf: NodeId, consequences: Consequences, changes: &[Change]) -> bool {
        if !self.running.contains_key(&leaf) {
            return false;
        }
        let is_mine = |node: NodeId| node.0 > 0 && self.topology.path(leaf).any(|above| above == node);
        let is_last = |node: NodeId| self.running_below(node).all(|(other, _)| other == leaf);
        let ends = consequences.completed.map(|completed| completed.node).into_iter().chain(consequences.failed);
        ends.into_iter().all(|node| is_mine(node) && is_last(node))
            && consequences.completed.and_then(|completed| completed.heir).is_none_or(is_mine)
            && consequences.failing.is_none_or(|failing| self.has(failing.node))
            && consequences.cleaned.is_none_or(|node| self.cleaning.contains(&node) && is_mine(node))
            && changes.iter().all(|change| self.knows(*change))
    }

    /// A node that does not run, and nothing does that fails with it.
    pub(super) fn can_fail(&self, from: NodeId, consequences: Consequences) -> bool {
        let is_above = |node: NodeId| node.0 > 0 && self.is_above(node, from);
        self.has(from)
            && from.0 > 0
            && consequences.failed.is_none_or(|failed| is_above(failed) && !self.is_busy(failed))
            && consequences.failing.is_none_or(|failing| is_above(failing.node))
    }

    /// Children of one THEN from the one with the leaf up to the goal, and nothing of them runs.
    pub(super) fn can_overtake(
        &self,
        leaf: NodeId,
        skips: &[NodeRange],
        goal: NodeId,
        consequences: Consequences,
    ) -> bool {
        let contain = |node: NodeId| skips.iter().any(|skip| skip.contains(node));
        let is_idle = |skip: &NodeRange| self.running.range(skip.from..skip.to).next().is_none();
        let is_above = |node: NodeId| node.0 > 0 && self.is_above(node, goal);
        skips.iter().all(|skip| self.is_skip(skip) && is_idle(skip))
            && contain(leaf)
            && contain(goal)
            && self.has(goal)
            && skips.first().is_some_and(|first| self.topology.parent(goal) == self.topology.parent(first.from))
            && consequences.completed.is_none_or(|completed| {
                is_above(completed.node) && !self.is_busy(completed.node) && completed.heir.is_none_or(is_above)
            })
            && consequences.failed.is_none_or(|failed| is_above(failed) && !self.is_busy(failed))
    }

    fn is_skip(&self, skip: &NodeRange) -> bool {
        skip.from.0 > 0 && skip.from < skip.to && self.has(skip.from) && skip.to <= self.topology.next()
    }

    fn has(&self, node: NodeId) -> bool {
        self.topology.has(node)
    }

    fn is_above(&self, top: NodeId, node: NodeId) -> bool {
        self.has(node) && self.has(top) && self.topology.is_within(node, top)
    }
}
