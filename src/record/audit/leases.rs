//! Who has what: no resource serves two behaviors, no two children of a THEN run, nothing is granted that is away.

use std::collections::BTreeMap;

use ambidex_model::{Access, Binding, EntryKind, Grant, MissionEnd, NodeId, Record, Resource, ResourceId};

use super::run::Run;
use super::{Found, LookedAt, Rule};

/// What the auditor remembers of leases.
#[derive(Debug, Default)]
pub(super) struct Leases {
    /// How many hold each resource, as was told last.
    owners: BTreeMap<ResourceId, usize>,
    is_done: bool,
}

impl Leases {
    pub(super) fn take(&mut self, run: &Run, record: &Record, found: &mut Found, looked_at: &mut LookedAt) {
        if let Record::Decided { granted, .. } = record {
            looked_at.grants += granted.len() as u64;
            for (index, grant) in granted.iter().enumerate() {
                let others = run.running.values().chain(&granted[..index]);
                others.for_each(|other| beside(run, grant, other, found));
                is_there(run, grant, found);
            }
        } else if let Record::Resource { resource, state, .. } = record {
            self.owners.insert(*resource, state.owners());
            is_sound(run, *resource, state, found);
        } else if let Record::Ended { end, .. } = record {
            self.is_done = *end == MissionEnd::Done;
        }
    }

    /// What is given back when all is done is told behind the end.
    pub(super) fn finish(&self, run: &Run, found: &mut Found) {
        for resource in self.owners.iter().filter(|(_, owners)| self.is_done && **owners > 0).map(|(id, _)| id) {
            let resource = run.names.resource(*resource);
            found.push(Rule::End, format!("the mission is done, and {resource} is still held"));
        }
    }
}

/// An exclusive resource has one owner, a shared one has any.
fn is_sound(run: &Run, resource: ResourceId, state: &Resource, found: &mut Found) {
    let is_sound = match state.access() {
        None => state.owners() == 0,
        Some(Access::Exclusive) => state.owners() == 1,
        Some(Access::Shared(_)) => state.owners() > 0,
    };
    if !is_sound {
        let holders: Vec<_> = state.leases().iter().map(|lease| run.name(lease.holder)).collect();
        let resource = run.names.resource(resource);
        found.push(Rule::Owners, format!("{resource} has the owners {}", holders.join(" and ")));
    }
}

/// Two behaviors that run at once.
fn beside(run: &Run, grant: &Grant, other: &Grant, found: &mut Found) {
    let (one, two) = (run.name(grant.leaf()), run.name(other.leaf()));
    if grant.leaf() == other.leaf() {
        found.push(Rule::Owners, format!("{one} is granted and runs already"));
        return;
    }
    for binding in &grant.bindings {
        let clashes = |bound: &Binding| bound.resource == binding.resource && !bound.access.joins(binding.access);
        if other.bindings.iter().any(clashes) {
            let resource = run.names.resource(binding.resource);
            found.push(Rule::Owners, format!("{resource} is granted to {one} and serves {two}"));
        }
    }
    if let Some(object) = grant.request.changes.iter().find(|object| other.request.changes.contains(object)) {
        let object = run.names.object(*object);
        found.push(Rule::Owners, format!("{one} and {two} change {object} at once"));
    }
    if let Some(then) = shared_then(run, grant.leaf(), other.leaf()) {
        found.push(Rule::Owners, format!("{one} and {two} run at once in the THEN {}", run.name(then)));
    }
}

/// The THEN below which two behaviors are in different children, if it is the lowest node above both.
fn shared_then(run: &Run, one: NodeId, two: NodeId) -> Option<NodeId> {
    if !run.is_known(one) || !run.is_known(two) {
        return None;
    }
    let lowest = run.topology.path(one).find(|node| run.topology.is_within(two, *node))?;
    matches!(run.kinds[lowest.index()], EntryKind::Then | EntryKind::Cleanup).then_some(lowest)
}

fn is_there(run: &Run, grant: &Grant, found: &mut Found) {
    for binding in &grant.bindings {
        let outage = run.services.get(&binding.resource).and_then(|service| service.outage());
        if let Some(why) = outage {
            let (name, resource) = (run.name(grant.leaf()), run.names.resource(binding.resource));
            found.push(Rule::Available, format!("{resource} is granted to {name} and is away: {why}"));
        }
    }
}
