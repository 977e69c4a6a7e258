//! The resource table as root told it (III-B), and the world, with names.

use ambidex_model::{Lease, Location, Resource, ResourceId, Service};
use ambidex_record::{History, OutsideChange};

use super::snapshot::{FactRow, HolderRow, ObjectRow, Outage, ResourceRow, WorldRow};

/// Every resource in resource order.
pub(crate) fn rows(history: &History) -> Vec<ResourceRow> {
    let resources = history.resources().iter().enumerate();
    resources.map(|(index, state)| row(history, ResourceId::from(index), state)).collect()
}

fn row(history: &History, id: ResourceId, state: &Resource) -> ResourceRow {
    let (header, names) = (history.header(), history.names());
    let ty = header.resource_types.get(id.index());
    let mover = header.movers.get(id.index()).copied().flatten();
    let holder = |lease: &Lease| HolderRow {
        node: names.node(lease.holder).to_owned(),
        behavior: names.node(lease.behavior).to_owned(),
        kind: lease.kind,
    };
    ResourceRow {
        name: names.resource(id).to_owned(),
        ty: ty.map_or("?", |ty| names.ty(*ty)).to_owned(),
        owners: state.owners(),
        channel: state.channel().map(|channel| names.channel(channel).to_owned()),
        locked: state.is_locked(),
        unavailable: outage(history, state.service()),
        holders: state.leases().iter().map(holder).collect(),
        holds: history.world().held_by(id).map(|object| names.object(object).to_owned()),
        controller: mover.map(|controller| names.controller(controller).to_owned()),
    }
}

fn outage(history: &History, service: Service) -> Option<Outage> {
    let (why, since) = match service {
        Service::Available => return None,
        Service::Unavailable { why, since } | Service::Gone { why, since } => (why, since),
    };
    let since_s = history.moment(since).seconds();
    Some(Outage { why: why.to_string(), since_s, awaited: service.is_awaited() })
}

/// Base, objects and facts.
pub(super) fn world(history: &History) -> WorldRow {
    let (names, world) = (history.names(), history.world());
    let how = |made: &OutsideChange| made.origin.phrase(&made.change, names);
    let object = |(index, (name, at)): (usize, (&String, &Location))| {
        let holders: Vec<String> = at.holders().iter().map(|resource| names.resource(*resource).to_owned()).collect();
        let at = match *at {
            Location::At(place) => Some(names.place(place).to_owned()),
            Location::In(_) | Location::Unknown => None,
        };
        // What is in a gripper only its controller can have said.
        let how = history.maker_of_object(index.into()).filter(|_| holders.is_empty()).map(how);
        ObjectRow { name: name.clone(), at, held_by: holders, how }
    };
    let fact = |(index, (name, holds)): (usize, (&String, &bool))| {
        let how = history.maker_of_fact(index.into()).map(how);
        FactRow { name: name.clone(), holds: *holds, how }
    };
    let objects = names.objects.iter().zip(&world.objects).enumerate();
    WorldRow {
        base: history.base().map(|pose| [pose.at.x, pose.at.y, pose.heading]),
        objects: objects.filter(|(index, _)| history.has_object((*index).into())).map(object).collect(),
        facts: names.facts.iter().zip(&world.facts).enumerate().map(fact).collect(),
    }
}
