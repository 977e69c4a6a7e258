//! The live display: who uses which resource now, for what and how far it is; and one plain line per event.

mod line;
mod rows;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use ambidex_model::{
    Binding, Change, ControllerId, End, Grant, Location, NodeEntry, NodeId, ObjectId, Record, ResourceId, Tally,
};

use super::crew::Crew;

/// A running fold of records for the live display.
#[derive(Debug, Clone, Default)]
pub struct Progress {
    tally: Tally,
    movers: Vec<Option<ControllerId>>,
    crew: Crew,
    running: BTreeMap<NodeId, Vec<Binding>>,
    holding: BTreeMap<ResourceId, ObjectId>,
    done: BTreeSet<NodeId>,
    behaviors: usize,
}

impl Progress {
    /// Takes the next record.
    pub fn add(&mut self, record: &Record) {
        self.tally.add(record);
        match record {
            Record::Header(header) => {
                let is_behavior = |node: &&NodeEntry| node.kind.is_behavior();
                self.behaviors = header.nodes.iter().filter(is_behavior).count();
                self.movers.clone_from(&header.movers);
            }
            Record::Sent { .. } | Record::Resource { .. } | Record::Ended { .. } => {}
            Record::Decided { granted, reopened, .. } => {
                if let Some(reopened) = reopened {
                    self.done.remove(&reopened.leaf);
                }
                granted.iter().for_each(|grant| self.grant(grant));
            }
            Record::Released { leaf, end, changes, .. } => {
                self.running.remove(leaf);
                self.crew.release(*leaf);
                if *end == End::Succeeded {
                    self.done.insert(*leaf);
                }
                changes.iter().for_each(|change| self.change(*change));
            }
            Record::World { change, .. } => self.change(*change),
            Record::Controller { at, controller, message } => self.crew.add(*at, *controller, message),
        }
    }

    /// The fold of the same records for summary and diagram.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    fn grant(&mut self, grant: &Grant) {
        self.running.insert(grant.leaf(), grant.bindings.clone());
        let Some(header) = &self.tally.header else {
            return;
        };
        let behaviors = grant.skipped(header.nodes.len()).filter(|node| {
            let entry = header.nodes.get(node.index());
            entry.is_some_and(|entry| entry.kind.is_behavior())
        });
        self.done.extend(behaviors);
    }

    fn change(&mut self, change: Change) {
        let Change::Object(object, at) = change else {
            return;
        };
        self.holding.retain(|_, held| *held != object);
        if let Location::In(resource) = at {
            self.holding.insert(resource, object);
        }
    }

    /// Behaviors that are done, by running or by being skipped.
    fn done(&self) -> usize {
        let skipped = self.tally.skipped.iter();
        self.done.len() + skipped.filter(|(leaf, _)| !self.done.contains(leaf)).count()
    }
}
