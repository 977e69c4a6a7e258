//! Reasons in the light of who holds which resource at the moment.

use ambidex_model::{Access, Lease, LeaseKind, Names, NodeId, Reason, ResourceId, TypeId};
use ambidex_record::History;

use crate::text::phrase;

/// A reason in words: what stays so as long as the reason does, and who is behind it at the moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Because {
    pub(super) sentence: String,
    pub(super) detail: Option<String>,
}

impl Because {
    /// The sentence with the detail in brackets.
    pub(super) fn whole(&self) -> String {
        match &self.detail {
            Some(detail) => format!("{} ({detail})", self.sentence),
            None => self.sentence.clone(),
        }
    }
}

/// A reason with what it rests on: who holds it for what, by how much a request was better.
pub(super) fn because(reason: &Reason, history: &History) -> Because {
    let names = history.names();
    let plain = |detail| Because { sentence: reason.sentence(names), detail };
    let told = |sentence| Because { sentence, detail: None };
    match reason {
        Reason::Held { resource, by, .. } => match lease(history, *resource, *by) {
            Some((lease, access)) => told(held(*resource, lease, access, names)),
            None => plain(None),
        },
        Reason::Outbid { by, resource, own, theirs } => {
            told(outbid(names.node(*by), names.resource(*resource), *own, *theirs))
        }
        Reason::NoneFree { of } | Reason::TooFew { of, .. } | Reason::NothingAvailable { of } => {
            plain(holders(history, *of))
        }
        Reason::Satisfied
        | Reason::Unavailable { .. }
        | Reason::Unfit { .. }
        | Reason::BackingOff { .. }
        | Reason::Unwanted
        | Reason::Missing { .. }
        | Reason::OutOfReach { .. }
        | Reason::OutOfReachLater { .. }
        | Reason::Unreachable { .. }
        | Reason::NoSpot { .. }
        | Reason::NotHeld { .. }
        | Reason::Misheld(_)
        | Reason::Taken { .. }
        | Reason::Elsewhere { .. }
        | Reason::Nowhere { .. }
        | Reason::NotAt { .. }
        | Reason::Driving { .. }
        | Reason::NoPath { .. }
        | Reason::InTheWay { .. }
        | Reason::PathNotFound { .. }
        | Reason::Fact { .. }
        | Reason::AlreadyDone { .. }
        | Reason::Outdone { .. }
        | Reason::SameObject { .. }
        | Reason::Clash { .. }
        | Reason::Alternative { .. }
        | Reason::WholeRobot { .. }
        | Reason::WouldDeadlock { .. }
        | Reason::NotItsTurn { .. }
        | Reason::Ending { .. }
        | Reason::LessUrgent { .. }
        | Reason::DoneOftener { .. }
        | Reason::Reserved { .. }
        | Reason::TooEarly { .. }
        | Reason::NotYet { .. }
        | Reason::GivenUp { .. }
        | Reason::OutOfTime { .. } => plain(None),
    }
}

fn lease(history: &History, resource: ResourceId, holder: NodeId) -> Option<(&Lease, Access)> {
    let state = history.resources().get(resource.index())?;
    let lease = state.leases().iter().find(|lease| lease.holder == holder)?;
    Some((lease, state.access()?))
}

/// Who holds the resources of a type; none where nobody holds any.
fn holders(history: &History, of: TypeId) -> Option<String> {
    let names = history.names();
    let mut held: Vec<(String, Vec<&str>)> = Vec::new();
    let resources = history.resources().iter().zip(&history.header().resource_types).enumerate();
    for (index, (state, _)) in resources.filter(|(_, (state, ty))| **ty == of && state.is_locked()) {
        let holders = phrase::nodes(state.leases().iter().map(|lease| lease.holder), names);
        let resource = names.resource(ResourceId::from(index));
        match held.iter_mut().find(|(other, _)| *other == holders) {
            Some((_, resources)) => resources.push(resource),
            None => held.push((holders, vec![resource])),
        }
    }
    let held: Vec<String> =
        held.iter().map(|(holders, resources)| format!("{holders} has {}", phrase::listed(resources))).collect();
    (!held.is_empty()).then(|| phrase::listed(&held))
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

/// A better request, and how much better.
fn outbid(by: &str, resource: &str, own: f64, theirs: f64) -> String {
    let more = theirs - own;
    let numbers = match more {
        0.0 => format!("both have {own:.3}, and {by} comes first"),
        _ if more.abs() < 0.000_5 => format!("{theirs:.3}, which is {more:.1e} more"),
        _ => format!("{theirs:.3} against {own:.3}"),
    };
    format!("outbid by {by} for {resource} ({numbers})")
}
