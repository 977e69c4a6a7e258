//! Urgent work: what a behavior would ask for without those that are less urgent, whom it interrupts for that, and who is
//! as urgent as it since it waits for them (`semantics` 6, "Urgent work").

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::offers::Rank;
use super::{Outbox, Root, Verdict};
use crate::world::{View, priority};
use ambidex_model::{
    Cause, Grant, Kept, Lease, LeaseKind, Lineage, NodeId, Reason, Record, Reopened, Request, ResourceId, StopCause,
    Time, Urged,
};

impl Root {
    /// The wishes that count: below an OR that has not chosen, only where nothing of it can be granted, and one.
    pub(super) fn wishes_of(&self, view: &View, requests: &[Arc<Request>]) -> Vec<Arc<Request>> {
        let mut wishes: Vec<&Arc<Request>> = self.wishes.values().collect();
        wishes.sort_unstable_by_key(|wish| Rank::of(wish));
        let open = |wish: &Request| self.open_choice(wish.leaf);
        let granted: Vec<NodeId> = match wishes.iter().any(|wish| open(wish).is_some()) {
            true => self.settings.allocator.choose(view, requests, &[]).granted.iter().map(Grant::leaf).collect(),
            false => Vec::new(),
        };
        let mut chosen = BTreeSet::new();
        wishes.retain(|wish| {
            let Some(or) = open(wish) else { return true };
            let is_served = granted.iter().any(|leaf| view.state.topology().is_within(*leaf, or));
            !is_served && chosen.insert(or)
        });
        wishes.into_iter().cloned().collect()
    }

    /// The topmost OR above a leaf that has not chosen.
    fn open_choice(&self, leaf: NodeId) -> Option<NodeId> {
        let is_open = |node: &NodeId| self.ors.binary_search(node).is_ok() && self.state.status(*node).way.is_none();
        self.state.topology().path(leaf).filter(is_open).last()
    }

    /// Interrupts less urgent behaviors for wishes that found a place, each once until that is granted or there is
    /// progress.
    pub(super) fn preempt(&mut self, now: Time, view: &View, wished: &[Grant], out: &mut Outbox) -> BTreeSet<NodeId> {
        let mut stopped = BTreeSet::new();
        for wish in wished {
            let by = wish.leaf();
            let victims: Vec<NodeId> = self.victims(view, wish).filter(|leaf| self.may_preempt(*leaf, by)).collect();
            let progress = self.state.progress();
            self.preempted.extend(victims.iter().map(|leaf| ((*leaf, by), progress)));
            stopped.extend(self.stop(now, victims, StopCause::Preempted { by }, out));
        }
        stopped
    }

    /// Less urgent behaviors run on what a wish needs, or change the same object, and may be interrupted.
    fn victims<'a>(&'a self, view: &'a View, wish: &'a Grant) -> impl Iterator<Item = NodeId> + 'a {
        let tree = &self.mission.tree;
        let line = self.line(wish);
        self.state.running().iter().filter_map(move |(&leaf, running)| {
            let changes = |object| running.request.changes.contains(object);
            let is_in_the_way = wish.bindings.iter().any(|binding| {
                let resource = self.state.table().resource(binding.resource);
                let holds = resource.leases().iter().any(|lease| lease.holder == leaf);
                holds && !line.contains(leaf) && resource.obstacle(&line, binding.access).is_some()
            });
            let is_meant = is_in_the_way || wish.request.changes.iter().any(changes);
            let is_less_urgent = view.priority(leaf) < wish.request.priority;
            let may_be = tree.behavior(leaf).is_some_and(|spec| spec.is_interruptible);
            (is_meant && is_less_urgent && may_be).then_some(leaf)
        })
    }

    fn may_preempt(&self, leaf: NodeId, by: NodeId) -> bool {
        !self.state.status(leaf).is_stopping && self.preempted.get(&(leaf, by)) != Some(&self.state.progress())
    }

    /// What is kept for less urgent intentions and in the way of wishes that found a place is given up.
    pub(super) fn give_way(&mut self, now: Time, view: &View, wished: &[Grant], out: &mut Outbox) {
        for wish in wished {
            let ended = self.in_the_way(view, wish);
            if !ended.is_empty() && !self.is_over() {
                let reopened = Reopened { ended, ..Reopened::new(wish.leaf(), NodeId(0), Cause::Yield) };
                self.is_wanted = true;
                self.edit(Record::Reopened { at: now, reopened }, out);
            }
        }
    }

    fn in_the_way(&self, view: &View, wish: &Grant) -> Vec<Kept> {
        let line = self.line(wish);
        let in_the_way = wish.bindings.iter().filter_map(|binding| {
            let resource = self.state.table().resource(binding.resource);
            resource.obstacle(&line, binding.access).map(|_| (binding.resource, resource))
        });
        let yields = |lease: &&Lease| {
            let is_less_urgent = view.priority(lease.holder) < wish.request.priority;
            lease.kind == LeaseKind::Intention && is_less_urgent && !line.contains(lease.holder)
        };
        let kept = in_the_way.flat_map(|(id, resource)| {
            let leases = resource.leases().iter().filter(yields);
            leases.map(move |lease| Kept { resource: id, holder: lease.holder, behavior: lease.behavior })
        });
        kept.collect()
    }

    fn line<'a>(&'a self, wish: &'a Grant) -> Lineage<'a> {
        Lineage { topology: self.state.topology(), node: wish.leaf(), skips: &wish.request.skips }
    }

    /// Takes note of what is granted: who interrupted others for it may do so again.
    pub(super) fn note_grants(&mut self, verdict: &Verdict) {
        self.preempted.retain(|(_, by), _| !verdict.granted.contains_key(by));
        self.note_begun(verdict);
    }

    /// Who is as urgent as those that wait for a gripper that it holds full; none where that is as before.
    pub(super) fn urge(&self) -> Option<Vec<Urged>> {
        if !self.mission.tree.has_priorities() {
            return None;
        }
        let mut urged: BTreeMap<NodeId, i32> = BTreeMap::new();
        // Mostly nobody keeps anything physically, and who waits need not be looked at.
        let mut goes_on = self.state.table().leases().any(|(_, lease)| lease.kind == LeaseKind::Physical);
        while goes_on {
            let before = urged.clone();
            for (&leaf, reason) in self.reasons.iter() {
                let of = |node| priority(&self.mission.tree, &urged, node);
                let lent = of(leaf);
                let holders = self.named(reason).into_iter().flat_map(|id| self.idle_holders(id, leaf));
                let less: Vec<NodeId> = holders.filter(|holder| lent > of(*holder)).collect();
                urged.extend(less.into_iter().map(|holder| (holder, lent)));
            }
            goes_on = urged != before;
        }
        let told = urged.iter().map(|(&node, &priority)| Urged { node, priority }).collect();
        (urged != *self.state.urged()).then_some(told)
    }

    /// What a reason says is held by others.
    fn named(&self, reason: &Reason) -> Vec<ResourceId> {
        if let Reason::Held { resource, .. } = *reason {
            vec![resource]
        } else if let Reason::NoneFree { of } | Reason::TooFew { of, .. } | Reason::NothingAvailable { of } = *reason {
            self.mission.robot.of_type(of).collect()
        } else {
            Vec::new()
        }
    }

    /// Who keeps a resource physically and does not run, and is not above a leaf.
    fn idle_holders(&self, id: ResourceId, leaf: NodeId) -> Vec<NodeId> {
        let leases = self.state.table().resource(id).leases().iter();
        let is_other = |holder| !self.state.topology().is_within(leaf, holder);
        let idle = leases.filter(|lease| lease.kind == LeaseKind::Physical && is_other(lease.holder));
        idle.map(|lease| lease.holder).collect()
    }
}
