//! Values as cells of a table, and as arguments of events.

use std::collections::BTreeSet;

use ambidex_model::{End, Grant, LeaseKind, Mode, Names, NodeId, ResourceId, Time};

/// Between the parts of a list in one cell.
const BETWEEN: &str = ";";

/// Names in one cell.
pub(super) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().collect::<Vec<_>>().join(BETWEEN)
}

/// Names of nodes.
pub(super) fn nodes(nodes: &[NodeId], names: &Names) -> String {
    list(nodes.iter().map(|node| names.node(*node)))
}

/// The resources of a grant, in their order.
pub(super) fn resources(grant: &Grant, names: &Names) -> String {
    let resources: BTreeSet<ResourceId> = grant.bindings.iter().map(|binding| binding.resource).collect();
    list(resources.into_iter().map(|resource| names.resource(resource)))
}

/// The objects that a granted behavior changes.
pub(super) fn objects(grant: &Grant, names: &Names) -> String {
    list(grant.request.changes.iter().map(|object| names.object(*object)))
}

/// The place where the object lies that a granted behavior follows.
pub(super) fn place(grant: &Grant, names: &Names) -> String {
    grant.request.place.map_or(String::new(), |place| names.place(place).to_owned())
}

/// Seconds, as short as they can be said.
pub(super) fn seconds(at: Time) -> String {
    at.seconds().to_string()
}

/// Seconds, or nothing.
pub(super) fn seconds_of(at: Option<Time>) -> String {
    at.map(seconds).unwrap_or_default()
}

/// How a behavior ended.
pub(super) fn end(end: End) -> &'static str {
    match end {
        End::Succeeded => "succeeded",
        End::Failed(_) => "failed",
        End::Canceled => "canceled",
        End::Interrupted => "interrupted",
    }
}

/// At what a behavior failed; nothing where it did not.
pub(super) fn fault(end: End, names: &Names) -> String {
    match end {
        End::Failed(fault) => fault.sentence(names),
        End::Succeeded | End::Canceled | End::Interrupted => String::new(),
    }
}

/// Why a lease is held.
pub(super) fn lease(kind: LeaseKind) -> &'static str {
    match kind {
        LeaseKind::Running => "running",
        LeaseKind::Intention => "intention",
        LeaseKind::Physical => "physical",
    }
}

/// Whether a command ends its behavior or lasts as long.
pub(super) fn mode(mode: Mode) -> &'static str {
    match mode {
        Mode::Achieve => "achieve",
        Mode::Maintain => "maintain",
    }
}
