//! Events of what becomes of a mission: rounds, ends of goals, changes of the world, its beginning and end.

use tracing::{debug, error, info, warn};

use ambidex_model::{
    Cause, Change, Consequences, ControllerId, End, FactId, Grant, Header, MissionEnd, Names, NodeId, Objection,
    Origin, PlaceId, Reason, Reopened, Resource, ResourceId, Service, StopCause,
};

use super::MISSION;
use ambidex_record::format;

pub(super) fn started(header: &Header) {
    info!(
        target: MISSION,
        mission = header.mission,
        robot = header.robot,
        allocator = header.allocator,
        nodes = header.nodes.len(),
        "mission started"
    );
}

pub(super) fn decided(at_s: f64, round: u32, granted: &[Grant], refused: usize, names: &Names) {
    if granted.is_empty() {
        debug!(target: MISSION, round, refused, at_s, "nothing granted");
        return;
    }
    let leaves = granted.iter().map(|grant| grant.leaf());
    info!(
        target: MISSION,
        round,
        granted = %format::nodes(leaves, names),
        refused,
        at_s,
        "round granted"
    );
    for grant in granted {
        debug!(
            target: MISSION,
            round,
            leaf = names.node(grant.leaf()),
            potential = grant.request.potential,
            claims = %format::bindings(&grant.bindings, names),
            at_s,
            "grant"
        );
    }
}

pub(super) fn infeasible(at_s: f64, leaf: NodeId, reason: &Reason, names: &Names) {
    let (leaf, reason) = (names.node(leaf), format::reason(reason, names));
    warn!(target: MISSION, leaf, %reason, at_s, "can never run");
}

pub(super) fn timed_out(at_s: f64, node: NodeId, names: &Names) {
    warn!(target: MISSION, node = names.node(node), at_s, "took too long");
}

pub(super) fn overtaken(at_s: f64, leaf: NodeId, goal: NodeId, names: &Names) {
    let (leaf, goal) = (names.node(leaf), names.node(goal));
    info!(target: MISSION, leaf, goal, at_s, "done by others");
}

pub(super) fn reopened(at_s: f64, round: Option<u32>, reopened: &Reopened, names: &Names) {
    let lacks = reopened.lacks();
    let (cause, fault) = match reopened.cause {
        Cause::Lapse { .. } => ("lapse", None),
        Cause::Redo { .. } => ("redo", None),
        Cause::Leave => ("leave", None),
        Cause::Retry { fault, .. } => ("retry", Some(fault.sentence(names))),
        Cause::Repeat { .. } => ("repeat", None),
        Cause::Yield => ("yield", None),
    };
    debug!(
        target: MISSION,
        round,
        leaf = names.node(reopened.node),
        holder = names.node(reopened.up_to),
        cause,
        fault,
        lapsed = reopened.lapsed().map(|resource| names.resource(resource)),
        heir = lacks.map(|lacks| names.node(lacks.leaf)),
        reason = lacks.map(|lacks| display(format::reason(&lacks.reason, names))),
        at_s,
        "reopened"
    );
}

pub(super) fn released(
    at_s: f64,
    leaf: NodeId,
    end: End,
    consequences: Consequences,
    changes: &[Change],
    names: &Names,
) {
    let (completes, fails) = (consequences.completed.map(|completion| completion.node), consequences.failed);
    macro_rules! released {
        ($level:ident) => {
            $level!(
                target: MISSION,
                leaf = names.node(leaf),
                end = format::end(end),
                controller = format::at_fault(end, names),
                completes = completes.map(|node| names.node(node)),
                fails = fails.map(|node| names.node(node)),
                changes = (!changes.is_empty()).then(|| display(format::changes(changes, names))),
                at_s,
                "goal ended"
            )
        };
    }
    match end {
        End::Succeeded | End::Canceled => released!(info),
        End::Failed(_) | End::Interrupted => released!(warn),
    }
}

pub(super) fn stopped(at_s: f64, leaves: &[NodeId], cause: &StopCause, names: &Names) {
    let stopped = format::nodes(leaves.iter().copied(), names);
    match cause {
        StopCause::Ends => debug!(target: MISSION, %stopped, at_s, "told to end"),
        StopCause::Broken(reason) => {
            let reason = format::reason(reason, names);
            info!(target: MISSION, %stopped, %reason, at_s, "told to end");
        }
        StopCause::Preempted { by } => {
            info!(target: MISSION, %stopped, preempted_by = names.node(*by), at_s, "told to end");
        }
    }
}

pub(super) fn ending(at_s: f64, end: MissionEnd) {
    info!(target: MISSION, outcome = ?end, at_s, "mission is to end");
}

pub(super) fn leaving(at_s: f64, way: NodeId, names: &Names) {
    info!(target: MISSION, way = names.node(way), at_s, "is to be left");
}

pub(super) fn cleaning(at_s: f64, node: NodeId, names: &Names) {
    info!(target: MISSION, node = names.node(node), at_s, "cleaning up");
}

pub(super) fn cleaned(at_s: f64, node: NodeId, is_done: bool, names: &Names) {
    match is_done {
        true => info!(target: MISSION, node = names.node(node), at_s, "clean already"),
        false => warn!(target: MISSION, node = names.node(node), at_s, "cannot be cleaned up"),
    }
}

pub(super) fn woke(at_s: f64, leaves: &[NodeId], names: &Names) {
    let woken = format::nodes(leaves.iter().copied(), names);
    debug!(target: MISSION, %woken, at_s, "asks again");
}

pub(super) fn served(at_s: f64, controller: ControllerId, service: Service, names: &Names) {
    let controller = names.controller(controller);
    match service {
        Service::Available => info!(target: MISSION, controller, at_s, "available again"),
        Service::Unavailable { why, .. } => warn!(target: MISSION, controller, %why, at_s, "unavailable"),
        Service::Gone { why, .. } => warn!(target: MISSION, controller, %why, at_s, "awaited no more"),
    }
}

pub(super) fn awaited(at_s: f64, until_s: Option<f64>) {
    warn!(target: MISSION, until_s, at_s, "nothing can go on without what is unavailable");
}

pub(super) fn expected(at_s: f64, facts: &[FactId], places: &[PlaceId], names: &Names) {
    let facts = facts.iter().map(|fact| names.fact(*fact)).collect::<Vec<_>>().join(", ");
    let places = places.iter().map(|place| names.place(*place)).collect::<Vec<_>>().join(", ");
    info!(target: MISSION, facts, places, at_s, "nothing can go on before others change facts or clear the way");
}

pub(super) fn changed(at_s: f64, change: &Change, origin: Origin, names: &Names) {
    debug!(
        target: MISSION,
        changes = %format::changes(std::slice::from_ref(change), names),
        how = origin.phrase(change, names),
        at_s,
        "world changed"
    );
}

pub(super) fn denied(at_s: f64, change: &Change, origin: Origin, why: Objection, names: &Names) {
    warn!(
        target: MISSION,
        changes = %format::changes(std::slice::from_ref(change), names),
        how = origin.phrase(change, names),
        why = why.sentence(change, names),
        at_s,
        "a change from outside was refused"
    );
}

/// The five properties of a resource (III-B); its type stands in the header.
pub(super) fn used(at_s: f64, id: ResourceId, resource: &Resource, names: &Names) {
    debug!(
        target: MISSION,
        resource = names.resource(id),
        owners = resource.owners(),
        channel = resource.channel().map(|channel| names.channel(channel)),
        locked = resource.is_locked(),
        holders = %format::nodes(resource.leases().iter().map(|lease| lease.holder), names),
        at_s,
        "resource"
    );
}

pub(super) fn ended(at_s: f64, end: MissionEnd, names: &Names) {
    const SAYS: &str = "mission ended";
    match end {
        MissionEnd::Done => info!(target: MISSION, outcome = "done", at_s, "{SAYS}"),
        MissionEnd::Canceled => info!(target: MISSION, outcome = "canceled", at_s, "{SAYS}"),
        MissionEnd::Stalled => warn!(target: MISSION, outcome = "stalled", at_s, "{SAYS}"),
        MissionEnd::Failed(leaf) => {
            let leaf = names.node(leaf);
            warn!(target: MISSION, outcome = "failed", leaf, at_s, "{SAYS}");
        }
        MissionEnd::ControllerLost(controller) => {
            let controller = names.controller(controller);
            error!(target: MISSION, outcome = "failed", controller, at_s, "{SAYS}: controller lost");
        }
        MissionEnd::NotAttached => error!(target: MISSION, outcome = "failed", at_s, "{SAYS}: not attached"),
        MissionEnd::TaskLost => error!(target: MISSION, outcome = "failed", at_s, "{SAYS}: task lost"),
        MissionEnd::NodeLost(node) => {
            let node = names.node(node);
            error!(target: MISSION, outcome = "failed", node, at_s, "{SAYS}: node lost");
        }
    }
}
