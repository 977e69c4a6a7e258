//! The resource table: who holds what, and how leases move (III-B; only root writes it).

use serde::{Deserialize, Serialize};

use super::{Access, ChannelId, Grant, Lineage, NodeId, ResourceId, Retention, Service, Topology};

/// Why a lease is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum LeaseKind {
    /// Kept for what its behavior was done for.
    Intention,
    /// Kept because the world is so.
    Physical,
    /// Its behavior runs.
    Running,
}

/// A granted claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lease {
    /// The node that holds it.
    pub holder: NodeId,
    /// The behavior that got it.
    pub behavior: NodeId,
    /// Why it is held.
    pub kind: LeaseKind,
    /// The node that it was inherited from, while the behavior runs.
    pub from: Option<NodeId>,
}

/// One resource's changing part; name and type stand in the robot's description.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resource {
    access: Option<Access>,
    leases: Vec<Lease>,
    #[serde(default, skip_serializing_if = "Service::is_available")]
    service: Service,
}

impl Resource {
    /// Whether its controller is there, so that it can be granted.
    pub fn service(&self) -> Service {
        self.service
    }

    /// Number of owners.
    pub fn owners(&self) -> usize {
        self.leases.len()
    }

    /// Whether it is in use.
    pub fn is_locked(&self) -> bool {
        !self.leases.is_empty()
    }

    /// Whether nobody uses it and it is there.
    pub fn is_free(&self) -> bool {
        !self.is_locked() && self.service.is_available()
    }

    /// How it is used; none while it is free.
    pub fn access(&self) -> Option<Access> {
        self.access
    }

    /// The intention with which it is shared.
    pub fn channel(&self) -> Option<ChannelId> {
        self.access?.channel()
    }

    /// Its leases, by holder.
    pub fn leases(&self) -> &[Lease] {
        &self.leases
    }

    /// Whether a running behavior uses it.
    pub fn is_running(&self) -> bool {
        self.leases.iter().any(|lease| lease.kind == LeaseKind::Running)
    }

    /// The holder that keeps a node of this line from using the resource so, if any.
    pub fn obstacle(&self, line: &Lineage<'_>, access: Access) -> Option<NodeId> {
        if self.access.is_some_and(|present| present.joins(access)) {
            return None;
        }
        self.leases.iter().map(|lease| lease.holder).find(|&holder| !line.contains(holder))
    }

    fn remove(&mut self, gone: impl Fn(&Lease) -> bool) -> Vec<Lease> {
        let (removed, kept) = std::mem::take(&mut self.leases).into_iter().partition(gone);
        self.leases = kept;
        if self.leases.is_empty() {
            self.access = None;
        }
        removed
    }

    /// Adds a lease; a holder has one per resource, the physical before the intention, then the later behavior.
    fn add(&mut self, lease: Lease, access: Access) {
        self.access = Some(access);
        match self.leases.iter_mut().find(|present| present.holder == lease.holder) {
            Some(present) if (present.kind, present.behavior) < (lease.kind, lease.behavior) => *present = lease,
            Some(_) => {}
            None => {
                self.leases.push(lease);
                self.leases.sort_by_key(|lease| lease.holder);
            }
        }
    }
}

/// Where the kept leases of an ended behavior go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heir {
    /// The node that takes them.
    pub node: NodeId,
    /// Whether it is a THEN that is not complete: only there an intention lives on.
    pub goes_on: bool,
}

/// Every resource of the robot, by id.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ResourceTable {
    resources: Vec<Resource>,
}

impl ResourceTable {
    /// A table of `count` free resources.
    pub fn new(count: usize) -> Self {
        Self { resources: vec![Resource::default(); count] }
    }

    /// How many resources there are.
    pub fn count(&self) -> usize {
        self.resources.len()
    }

    /// One resource.
    pub fn resource(&self, id: ResourceId) -> &Resource {
        &self.resources[id.index()]
    }

    /// All resources in resource order, with their ids.
    pub fn iter(&self) -> impl Iterator<Item = (ResourceId, &Resource)> {
        self.resources.iter().enumerate().map(|(index, resource)| (ResourceId::from(index), resource))
    }

    /// All leases, in resource order, then by holder.
    pub fn leases(&self) -> impl Iterator<Item = (ResourceId, &Lease)> {
        self.iter().flat_map(|(id, resource)| resource.leases.iter().map(move |lease| (id, lease)))
    }

    /// Moves and makes the leases of a grant.
    ///
    /// What was skipped to reach the behavior is done now, so its leases go to the THEN that skipped it; then what
    /// the behavior claims of its line moves to it, and what it does not claim stays.
    pub fn take(&mut self, topology: &Topology, grant: &Grant) {
        for skip in &grant.request.skips {
            let heir = Heir { node: topology.parent(skip.from), goes_on: true };
            self.move_up(|holder| skip.contains(holder), heir);
        }
        let line = Lineage { topology, node: grant.leaf(), skips: &[] };
        for binding in &grant.bindings {
            let resource = &mut self.resources[binding.resource.index()];
            let inherited = resource.remove(|lease| line.contains(lease.holder));
            let from = inherited.iter().map(|lease| lease.holder).max();
            let lease = Lease { holder: grant.leaf(), behavior: grant.leaf(), kind: LeaseKind::Running, from };
            resource.add(lease, binding.access);
        }
    }

    /// Hands over the leases of a behavior that succeeded; `completed` is the topmost node that it completes.
    pub fn hand_over(&mut self, topology: &Topology, grant: &Grant, completed: NodeId, heir: Heir) {
        for binding in &grant.bindings {
            let resource = &mut self.resources[binding.resource.index()];
            resource.remove(|lease| lease.holder == grant.leaf());
            let (kind, access) = match binding.keep {
                Retention::Release => continue,
                Retention::Intention(_) if !heir.goes_on => continue,
                Retention::Intention(access) => (LeaseKind::Intention, access),
                Retention::Physical(access) => (LeaseKind::Physical, access),
            };
            resource.add(Lease { holder: heir.node, behavior: grant.leaf(), kind, from: None }, access);
        }
        self.move_up(|holder| topology.is_within(holder, completed), heir);
    }

    /// Takes back the leases of a behavior that did not succeed; `failed` is the topmost node that fails with it.
    ///
    /// A resource that holds something goes back to the node it was inherited from, else to the nearest node above
    /// that lives on; everything else is free.
    pub fn take_back(
        &mut self,
        topology: &Topology,
        leaf: NodeId,
        failed: Option<NodeId>,
        is_full: impl Fn(ResourceId) -> bool,
    ) {
        let above = topology.parent(failed.unwrap_or(leaf));
        for (index, resource) in self.resources.iter_mut().enumerate() {
            let ended = |holder| holder == leaf || failed.is_some_and(|top| topology.is_within(holder, top));
            let access = resource.access;
            for lease in resource.remove(|lease| ended(lease.holder)) {
                if !is_full(ResourceId::from(index)) {
                    continue;
                }
                let holder = lease.from.filter(|&from| !ended(from)).unwrap_or(above);
                let access = access.expect("a resource with a lease has an access");
                resource.add(Lease { holder, kind: LeaseKind::Physical, from: None, ..lease }, access);
            }
        }
    }

    /// What some nodes hold that do not run: a resource with something in it goes to another node, all else is free.
    pub fn gather(&mut self, to: NodeId, is_from: impl Fn(NodeId) -> bool, is_full: impl Fn(ResourceId) -> bool) {
        for (index, resource) in self.resources.iter_mut().enumerate() {
            let access = resource.access;
            for lease in resource.remove(|lease| is_from(lease.holder)) {
                if is_full(ResourceId::from(index)) {
                    let access = access.expect("a resource with a lease has an access");
                    resource.add(Lease { holder: to, kind: LeaseKind::Physical, from: None, ..lease }, access);
                }
            }
        }
    }

    /// Ends an intention lease of a holder.
    pub fn lapse(&mut self, resource: ResourceId, holder: NodeId) {
        self.resources[resource.index()].remove(|lease| lease.holder == holder && lease.kind == LeaseKind::Intention);
    }

    /// Ends the physical leases of a gripper that the world shows empty.
    pub fn emptied(&mut self, resource: ResourceId) {
        self.resources[resource.index()].remove(|lease| lease.kind == LeaseKind::Physical);
    }

    /// Its controller went, or came back.
    pub fn serve(&mut self, resource: ResourceId, service: Service) {
        self.resources[resource.index()].service = service;
    }

    /// What some nodes hold is free.
    pub fn free(&mut self, is_from: impl Fn(NodeId) -> bool) {
        self.resources.iter_mut().for_each(|resource| drop(resource.remove(|lease| is_from(lease.holder))));
    }

    /// Frees everything.
    pub fn clear(&mut self) {
        for resource in &mut self.resources {
            (resource.access, resource.leases) = (None, Vec::new());
        }
    }

    /// What some nodes hold that are done goes to their heir.
    pub fn move_up(&mut self, leaves_from: impl Fn(NodeId) -> bool, heir: Heir) {
        for resource in &mut self.resources {
            let access = resource.access;
            for lease in resource.remove(|lease| leaves_from(lease.holder)) {
                if lease.kind == LeaseKind::Physical || heir.goes_on {
                    let access = access.expect("a resource with a lease has an access");
                    resource.add(Lease { holder: heir.node, ..lease }, access);
                }
            }
        }
    }

    /// The invariants of `semantics` 2, kept in release builds too.
    ///
    /// # Panics
    /// Where one does not hold.
    pub fn assert_sound(&self) {
        for (id, resource) in self.iter() {
            let owners = resource.owners();
            let sound = match resource.access {
                None => owners == 0,
                Some(Access::Exclusive) => owners == 1,
                Some(Access::Shared(_)) => owners >= 1,
            };
            assert!(sound, "{id:?} is used {:?} by {owners} owners", resource.access);
        }
    }
}
