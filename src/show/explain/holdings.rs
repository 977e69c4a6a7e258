//! Who holds which resource, as the records tell it, and reasons in the light of that.

use std::collections::BTreeMap;

use crate::phrase;
use ambidex_model::{Access, Header, Lease, LeaseKind, Names, NodeId, Reason, Record, Resource, ResourceId, TypeId};

/// The resource table at a moment of the journal.
#[derive(Debug, Clone, Default)]
pub(super) struct Holdings {
    resources: BTreeMap<ResourceId, Resource>,
    types: Vec<TypeId>,
}

/// A reason in words: what stays so as long as the reason does, and who is behind it at the moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Because {
    pub(super) sentence: String,
    pub(super) detail: Option<String>,
}

impl Because {
    /// Both in one.
    pub(super) fn whole(&self) -> String {
        match &self.detail {
            Some(detail) => format!("{} ({detail})", self.sentence),
            None => self.sentence.clone(),
        }
    }
}

impl Holdings {
    pub(super) fn new(header: &Header) -> Self {
        Self { resources: BTreeMap::new(), types: header.resource_types.clone() }
    }

    pub(super) fn add(&mut self, record: &Record) {
        if let Record::Resource { resource, state, .. } = record {
            self.resources.insert(*resource, state.clone());
        }
    }

    /// The reason with what it rests on: who holds it for what, by how much a request was better.
    pub(super) fn because(&self, reason: &Reason, names: &Names) -> Because {
        let plain = |detail| Because { sentence: reason.sentence(names), detail };
        match reason {
            Reason::Held { resource, by, .. } => match self.lease(*resource, *by) {
                Some((lease, access)) => Because { sentence: held(*resource, lease, access, names), detail: None },
                None => plain(None),
            },
            Reason::Outbid { by, resource, own, theirs } => {
                Because { sentence: outbid(names.node(*by), names.resource(*resource), *own, *theirs), detail: None }
            }
            Reason::NoneFree { of } | Reason::NothingAvailable { of } => plain(self.holders(*of, names)),
            Reason::Satisfied
            | Reason::Unwanted
            | Reason::Missing { .. }
            | Reason::OutOfReach { .. }
            | Reason::NotHeld { .. }
            | Reason::Taken { .. }
            | Reason::Elsewhere { .. }
            | Reason::NotAt { .. }
            | Reason::Driving { .. }
            | Reason::NoPath { .. }
            | Reason::PathNotFound { .. }
            | Reason::Fact { .. }
            | Reason::AlreadyDone { .. }
            | Reason::SameObject { .. }
            | Reason::Clash { .. }
            | Reason::Alternative { .. }
            | Reason::WholeRobot { .. }
            | Reason::NotItsTurn { .. }
            | Reason::Ending { .. } => plain(None),
        }
    }

    fn lease(&self, resource: ResourceId, holder: NodeId) -> Option<(&Lease, Access)> {
        let state = self.resources.get(&resource)?;
        let lease = state.leases().iter().find(|lease| lease.holder == holder)?;
        Some((lease, state.access()?))
    }

    /// Who holds the resources of a type; none where nobody holds any.
    fn holders(&self, of: TypeId, names: &Names) -> Option<String> {
        let mut held: Vec<(String, Vec<&str>)> = Vec::new();
        for (index, _) in self.types.iter().enumerate().filter(|(_, ty)| **ty == of) {
            let resource = ResourceId::from(index);
            let leases = self.resources.get(&resource).map_or(&[][..], Resource::leases);
            let holders = phrase::nodes(leases.iter().map(|lease| lease.holder), names);
            if holders.is_empty() {
                continue;
            }
            match held.iter_mut().find(|(other, _)| *other == holders) {
                Some((_, resources)) => resources.push(names.resource(resource)),
                None => held.push((holders, vec![names.resource(resource)])),
            }
        }
        let held: Vec<String> =
            held.iter().map(|(holders, resources)| format!("{holders} has {}", phrase::listed(resources))).collect();
        (!held.is_empty()).then(|| phrase::listed(&held))
    }
}

/// Who holds a resource, in which way and for what.
fn held(resource: ResourceId, lease: &Lease, access: Access, names: &Names) -> String {
    let (resource, holder) = (names.resource(resource), names.node(lease.holder));
    let behavior = names.node(lease.behavior);
    let for_what = match access {
        Access::Exclusive => String::new(),
        Access::Shared(_) => format!(" {}", phrase::access(access, names)),
    };
    match lease.kind {
        LeaseKind::Running => format!("{resource} is in use by {holder}{for_what}"),
        LeaseKind::Intention => format!("{resource} is kept{for_what} by {holder}, for what comes after {behavior}"),
        LeaseKind::Physical => format!("{resource} holds something for {holder} since {behavior}"),
    }
}

/// A better request, and by how much.
fn outbid(by: &str, resource: &str, own: f64, theirs: f64) -> String {
    let more = theirs - own;
    let by_much = if more.abs() < 0.000_5 { format!("{more:.1e}") } else { format!("{more:.3}") };
    match more {
        0.0 => format!("{by} took {resource}: both have potential {own:.3}, and {by} comes first"),
        _ => format!("{by} took {resource} with potential {theirs:.3} against {own:.3}, which is {by_much} more"),
    }
}
