//! The resource table as root told it, with names (III-B).

use ambidex_model::{Header, Lease, Resource, ResourceId};

use super::Status;
use super::snapshot::{HolderRow, ResourceRow};

impl Status {
    pub(super) fn resource_rows(&self, header: &Header) -> Vec<ResourceRow> {
        let resources = self.resources.iter().enumerate().map(|(index, state)| (ResourceId::from(index), state));
        resources.map(|(id, state)| self.resource_row(id, state, header)).collect()
    }

    fn resource_row(&self, id: ResourceId, state: &Resource, header: &Header) -> ResourceRow {
        let names = &header.names;
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
            holders: state.leases().iter().map(holder).collect(),
            holds: self.world.held_by(id).map(|object| names.object(object).to_owned()),
            controller: mover.map(|controller| names.controller(controller).to_owned()),
        }
    }
}
