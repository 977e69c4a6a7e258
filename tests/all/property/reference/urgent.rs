//! What must last, and what is more urgent (`semantics` 6, "While" and "Urgent work").

use std::collections::{BTreeMap, BTreeSet};

use ambidex::model::{
    Access, Binding, Cause, Grant, Kept, LeaseKind, NodeId, NodeKind, NodeRange, Reason, Reopened, ResourceId,
    StopCause, Urged,
};

use super::round::order;
use super::{Ask, Decision, Held, Model, Refusal, Row};

impl Model<'_> {
    /// How urgent a node is, with who waits for what it or a node above holds.
    pub(super) fn priority(&self, node: NodeId) -> i32 {
        let urged = self.upward(node).into_iter().filter_map(|node| self.urged.get(&node));
        urged.copied().chain([self.told_priority(node)]).max().expect("at least one")
    }

    /// How urgent it is by what the task says.
    pub(super) fn told_priority(&self, node: NodeId) -> i32 {
        self.mission.tree.priority(node)
    }

    /// The first holder that keeps the leaf from using the resource, or from wishing for it.
    pub(super) fn hinders(
        &self,
        leaf: NodeId,
        skips: &[NodeRange],
        resource: ResourceId,
        access: Access,
        is_wish: bool,
    ) -> Option<NodeId> {
        let by = self.in_the_way(leaf, skips, resource, access)?;
        if !is_wish {
            return Some(by);
        }
        let leases = self.rows[resource.index()].leases.iter();
        let mut others = leases.filter(|held| !self.is_own(leaf, skips, held.holder));
        let is_full = self.held_object(resource).is_some();
        others.find(|held| is_full || !self.is_waited_for(leaf, held)).map(|held| held.holder)
    }

    /// Whether a lease is of what runs, or an idle one for an intention of who is less urgent.
    fn is_waited_for(&self, leaf: NodeId, held: &Held) -> bool {
        match held.kind {
            LeaseKind::Running => true,
            LeaseKind::Intention => self.priority(held.holder) < self.priority(leaf),
            LeaseKind::Physical => false,
        }
    }

    /// What a behavior that could not ask would ask for without what it waits for.
    pub(super) fn wish(&self, leaf: NodeId, skips: &[NodeRange], refusal: &Refusal) -> Option<Ask> {
        let is_it = !self.is_serial && !matches!(refusal.reason, Reason::NothingAvailable { .. } | Reason::Unwanted);
        if !is_it {
            return None;
        }
        let least = self.mission.tree.leaves().map(|leaf| self.told_priority(leaf)).min()?;
        if self.priority(leaf) <= least && !self.is_overdue(leaf) {
            return None;
        }
        self.request(leaf, skips, true).ok()
    }

    /// What a wish names first: what is free, what it can be given, what others use.
    pub(super) fn preferences(
        &self,
        leaf: NodeId,
        skips: &[NodeRange],
        serving: &[Vec<(ResourceId, f64)>],
    ) -> BTreeMap<ResourceId, u32> {
        let claims = &self.behavior(leaf).claims;
        let mut ranks = BTreeMap::new();
        for (claim, serving) in std::iter::zip(claims, serving) {
            for (id, _) in serving {
                let rank = if self.in_the_way(leaf, skips, *id, claim.access).is_none() {
                    0
                } else {
                    let leases = self.rows[id.index()].leases.iter();
                    let mut others = leases.filter(|held| !self.is_own(leaf, skips, held.holder));
                    let can_be_given = |held: &Held| match held.kind {
                        LeaseKind::Running => self.may_be_preempted(held.holder, leaf),
                        LeaseKind::Intention | LeaseKind::Physical => true,
                    };
                    if others.all(can_be_given) { 1 } else { 2 }
                };
                ranks.insert(*id, rank);
            }
        }
        ranks
    }

    /// The wishes that count: below an OR that has not chosen only where nothing is granted without any.
    pub(super) fn counting(&self, mut wishes: Vec<Ask>, asks: &[Ask]) -> Vec<Ask> {
        if wishes.is_empty() {
            return wishes;
        }
        wishes.sort_by(order);
        let (accepted, _) = self.merge(asks.to_vec());
        let (mut used, mut counting) = (BTreeSet::new(), Vec::new());
        for wish in wishes {
            let is_open = |node: &NodeId| self.kind(*node) == &NodeKind::Or && !self.committed.contains_key(node);
            let ors: Vec<_> = self.upward(wish.grant.leaf()).into_iter().filter(is_open).collect();
            let is_free = |or: &NodeId| {
                let below = self.below(*or);
                !used.contains(or) && !accepted.iter().any(|ask| below.contains(ask.grant.leaf()))
            };
            if ors.iter().all(is_free) {
                used.extend(ors);
                counting.push(wish);
            }
        }
        counting
    }

    fn may_be_preempted(&self, running: NodeId, wish: NodeId) -> bool {
        self.priority(running) < self.priority(wish) && self.behavior(running).is_interruptible
    }

    /// What runs and lacks what must last is told to end.
    pub(super) fn tell_what_is_broken(&mut self) {
        for leaf in self.running.keys().copied().collect::<Vec<_>>() {
            if self.stopping.contains_key(&leaf) {
                continue;
            }
            if let Some(refusal) = self.unmet(&self.behavior(leaf).lasting, leaf, &[]) {
                self.tell_to_end(leaf, StopCause::Broken(refusal.reason));
            }
        }
    }

    /// What a wish has taken and others hold in another way.
    fn in_the_way_of(&self, wish: &Grant) -> Vec<ResourceId> {
        let is_held = |binding: &&Binding| {
            self.in_the_way(wish.leaf(), &wish.request.skips, binding.resource, binding.access).is_some()
        };
        wish.bindings.iter().filter(is_held).map(|binding| binding.resource).collect()
    }

    /// What a wish waits for is told to end, if it is less urgent and may be interrupted.
    pub(super) fn preempt(&mut self, taken: &[Grant]) {
        for wish in taken {
            let (by, resources) = (wish.leaf(), self.in_the_way_of(wish));
            for leaf in self.running.keys().copied().collect::<Vec<_>>() {
                let holds = resources.iter().any(|id| {
                    let leases = &self.rows[id.index()].leases;
                    leases.iter().any(|held| held.holder == leaf && held.kind == LeaseKind::Running)
                });
                let mut changed = self.behavior(leaf).changes.iter();
                let changes_same = changed.any(|object| wish.request.changes.contains(object));
                let is_told = self.stopping.contains_key(&leaf) || !self.may_be_preempted(leaf, by);
                if (!holds && !changes_same) || is_told {
                    continue;
                }
                if self.preempted.insert((leaf, by, self.progress)) {
                    self.tell_to_end(leaf, StopCause::Preempted { by });
                }
            }
        }
    }

    /// Idle leases for intentions of who is less urgent end; whoever kept them stays done.
    pub(super) fn give_way(&mut self, taken: &[Grant]) -> Vec<Reopened> {
        let mut yields = Vec::new();
        for wish in taken {
            let (node, mut ended) = (wish.leaf(), Vec::new());
            for resource in self.in_the_way_of(wish) {
                let is_idle = |held: &&Held| {
                    held.kind == LeaseKind::Intention
                        && !self.is_own(node, &wish.request.skips, held.holder)
                        && self.priority(held.holder) < self.priority(node)
                };
                let idle: Vec<Held> = self.rows[resource.index()].leases.iter().filter(is_idle).copied().collect();
                for Held { holder, behavior, .. } in idle {
                    ended.push(Kept { resource, holder, behavior });
                    self.end_intention(resource, holder);
                }
            }
            if !ended.is_empty() {
                yields.push(Reopened { ended, ..Reopened::new(node, NodeId(0), Cause::Yield) });
            }
        }
        yields
    }

    /// Where nothing was granted since it is reserved, those do not ask in the next round; true if there are such.
    pub(super) fn hide(&mut self, decision: &Decision) -> bool {
        let is_reserved =
            |refusal: &&Refusal| matches!(refusal.reason, Reason::Reserved { .. } | Reason::WouldDeadlock { .. });
        let reserved =
            decision.refused.iter().filter(|(leaf, refusal)| is_reserved(refusal) && !self.hidden.contains_key(leaf));
        let more: Vec<_> = reserved.map(|(leaf, refusal)| (*leaf, refusal.clone())).collect();
        let is_hiding = !more.is_empty();
        self.hidden.extend(more);
        is_hiding
    }

    /// Who held before the grants of this round what is waited for is as urgent as who waits; all, if that is different.
    pub(super) fn urge(&mut self, decision: &Decision, rows: &[Row]) -> Option<Vec<Urged>> {
        let before = std::mem::take(&mut self.urged);
        loop {
            let mut is_same = true;
            for (&leaf, refusal) in &decision.refused {
                let named = match refusal.reason {
                    Reason::Held { resource, .. } => vec![resource],
                    Reason::NoneFree { of } | Reason::NothingAvailable { of } | Reason::TooFew { of, .. } => {
                        self.of_type(of)
                    }
                    _ => continue,
                };
                let priority = self.priority(leaf);
                for resource in named {
                    for held in rows[resource.index()].leases.clone() {
                        let is_idle = held.kind == LeaseKind::Physical && !self.is_own(leaf, &[], held.holder);
                        if is_idle && self.priority(held.holder) < priority {
                            self.urged.insert(held.holder, priority);
                            is_same = false;
                        }
                    }
                }
            }
            if is_same {
                break;
            }
        }
        let all = self.urged.iter().map(|(&node, &priority)| Urged { node, priority });
        (self.urged != before).then(|| all.collect())
    }
}
