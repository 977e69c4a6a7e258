//! The table of leases and how they move (`semantics` 2 and 6).

use ambidex::model::{Access, Grant, LeaseKind, NodeId, NodeRange, ResourceId, Retention};

use super::Model;

/// A lease.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Held {
    pub holder: NodeId,
    pub behavior: NodeId,
    pub kind: LeaseKind,
    pub from: Option<NodeId>,
}

/// One resource.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Row {
    pub access: Option<Access>,
    pub leases: Vec<Held>,
}

impl Row {
    fn take_out(&mut self, is_out: impl Fn(&Held) -> bool) -> Vec<Held> {
        let out = self.leases.iter().copied().filter(|held| is_out(held));
        let out: Vec<Held> = out.collect();
        self.leases.retain(|held| !out.contains(held));
        if self.leases.is_empty() {
            self.access = None;
        }
        out
    }

    /// Of two leases with one holder the physical one stays, then that of the later behavior.
    fn put(&mut self, held: Held, access: Access) {
        let rank = |held: &Held| (held.kind != LeaseKind::Intention, held.behavior);
        let rival = self.leases.iter().position(|other| other.holder == held.holder);
        match rival {
            Some(rival) if rank(&self.leases[rival]) >= rank(&held) => {}
            Some(rival) => self.leases[rival] = held,
            None => self.leases.push(held),
        }
        self.leases.sort_by_key(|held| held.holder);
        self.access = Some(access);
    }
}

impl Model<'_> {
    /// Whether a lease of `holder` is the leaf's own, inherited, or inside what was skipped on the way.
    pub(super) fn is_own(&self, leaf: NodeId, skips: &[NodeRange], holder: NodeId) -> bool {
        self.upward(leaf).contains(&holder) || skips.iter().any(|skip| skip.contains(holder))
    }

    /// The first holder that keeps the leaf from using the resource in this way.
    pub(super) fn in_the_way(
        &self,
        leaf: NodeId,
        skips: &[NodeRange],
        resource: ResourceId,
        access: Access,
    ) -> Option<NodeId> {
        let row = &self.rows[resource.index()];
        let joins = matches!(access, Access::Shared(_)) && row.access == Some(access);
        let mut others = row.leases.iter().map(|held| held.holder);
        others.find(|&holder| !joins && !self.is_own(leaf, skips, holder))
    }

    /// Whether a running behavior has the resource.
    pub(super) fn is_run(&self, resource: ResourceId) -> bool {
        let leases = &self.rows[resource.index()].leases;
        leases.iter().any(|held| held.kind == LeaseKind::Running)
    }

    pub(super) fn take(&mut self, grant: &Grant) {
        for skip in &grant.request.skips {
            let then = self.parent(skip.from);
            self.move_all(|holder| skip.contains(holder), Some(then), then);
        }
        let line = self.upward(grant.leaf());
        for binding in &grant.bindings {
            let row = &mut self.rows[binding.resource.index()];
            let inherited = row.take_out(|held| line.contains(&held.holder));
            let held = Held {
                holder: grant.leaf(),
                behavior: grant.leaf(),
                kind: LeaseKind::Running,
                from: inherited.iter().map(|held| held.holder).max(),
            };
            row.put(held, binding.access);
        }
    }

    /// After success: to the THEN that goes on, else to the topmost node that is complete now.
    pub(super) fn hand_over(&mut self, grant: &Grant, completed: NodeId, then: Option<NodeId>) {
        for binding in &grant.bindings {
            let row = &mut self.rows[binding.resource.index()];
            row.take_out(|held| held.holder == grant.leaf());
            let kept = match binding.keep {
                Retention::Release => None,
                Retention::Intention(access) => then.map(|_| (LeaseKind::Intention, access)),
                Retention::Physical(access) => Some((LeaseKind::Physical, access)),
            };
            if let Some((kind, access)) = kept {
                let held = Held { holder: then.unwrap_or(completed), behavior: grant.leaf(), kind, from: None };
                row.put(held, access);
            }
        }
        let below = self.below(completed);
        self.move_all(|holder| below.contains(holder), then, completed);
    }

    /// After any other end: what holds an object goes back up, the rest is free.
    pub(super) fn take_back(&mut self, leaf: NodeId, failed: Option<NodeId>) {
        let ended = self.below(failed.unwrap_or(leaf));
        let above = self.parent(ended.from);
        for index in 0..self.rows.len() {
            let is_full = self.held_object(ResourceId::from(index)).is_some();
            let row = &mut self.rows[index];
            let access = row.access;
            for held in row.take_out(|held| ended.contains(held.holder)) {
                let from = held.from.filter(|&from| !ended.contains(from));
                let back = Held { holder: from.unwrap_or(above), kind: LeaseKind::Physical, from: None, ..held };
                if let Some(access) = access.filter(|_| is_full) {
                    row.put(back, access);
                }
            }
        }
    }

    /// What some nodes hold that do not run: a gripper with an object goes to another node, all else is free.
    pub(super) fn gather(&mut self, to: NodeId, is_from: impl Fn(NodeId) -> bool) {
        for index in 0..self.rows.len() {
            let is_full = self.held_object(ResourceId::from(index)).is_some();
            let row = &mut self.rows[index];
            let access = row.access;
            for held in row.take_out(|held| is_from(held.holder)) {
                if let Some(access) = access.filter(|_| is_full) {
                    row.put(Held { holder: to, kind: LeaseKind::Physical, from: None, ..held }, access);
                }
            }
        }
    }

    pub(super) fn end_intention(&mut self, resource: ResourceId, holder: NodeId) {
        self.rows[resource.index()].take_out(|held| held.holder == holder);
    }

    pub(super) fn end_physical(&mut self, resource: ResourceId) {
        self.rows[resource.index()].take_out(|held| held.kind == LeaseKind::Physical);
    }

    pub(super) fn move_all(&mut self, is_moved: impl Fn(NodeId) -> bool, then: Option<NodeId>, else_to: NodeId) {
        for row in &mut self.rows {
            let access = row.access;
            for held in row.take_out(|held| is_moved(held.holder)) {
                if then.is_none() && held.kind == LeaseKind::Intention {
                    continue;
                }
                let holder = then.unwrap_or(else_to);
                row.put(Held { holder, ..held }, access.expect("what is held is held in a way"));
            }
        }
    }
}
