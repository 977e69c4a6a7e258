//! What a mission is at now, folded from its records alone: the tree, the resource table (III-B), controllers, world.
//!
//! [`Status`] is the fold, [`Snapshot`] what it says at one moment, with names; as text ([`Snapshot::lines`]) or as
//! JSON, through serde.

mod health;
mod nodes;
mod outline;
mod page;
mod resources;
mod snapshot;
mod table;
#[cfg(test)]
mod tests;
mod text;
mod world;

use std::collections::BTreeSet;

use ambidex_model::{Header, Message, NodeId, Record, Resource, Tally, Time};

use super::crew::{Crew, Presence};
use super::summary::ending;
use world::World;

pub use snapshot::{
    ControllerRow, Daemon, FactRow, GoalRow, Health, HolderRow, NodeRow, ObjectRow, Phase, ResourceRow, Snapshot,
    WorldRow,
};

/// A running fold of records, in memory bounded by the mission and the number of its grants.
#[derive(Debug, Clone, Default)]
pub struct Status {
    tally: Tally,
    crew: Crew,
    resources: Vec<Resource>,
    potentials: Vec<Option<f64>>,
    failed: BTreeSet<NodeId>,
    world: World,
}

impl Status {
    /// Takes the next record.
    pub fn add(&mut self, record: &Record) {
        self.tally.add(record);
        match record {
            Record::Header(header) => self.begin(header),
            Record::Sent { from, message, .. } => self.sent(*from, message),
            Record::Released { leaf, consequences, changes, .. } => {
                self.crew.release(*leaf);
                self.say(*leaf, None);
                self.failed.extend(consequences.failed);
                changes.iter().for_each(|change| self.world.apply(*change));
            }
            Record::World { change, .. } => self.world.apply(*change),
            Record::Resource { resource, state, .. } => {
                if let Some(known) = self.resources.get_mut(resource.index()) {
                    known.clone_from(state);
                }
            }
            Record::Controller { at, controller, message } => {
                self.crew.add(*at, *controller, message);
                self.world.hear(*controller, message);
            }
            Record::Decided { .. } | Record::Ended { .. } => {}
        }
    }

    /// The fold of the same records for report and summary.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Robot seconds per wall second, once a controller was told.
    pub fn speed(&self) -> Option<f64> {
        self.crew.speed()
    }

    /// What can be said now; none before a header.
    ///
    /// `now` is the robot's time, which goes on while nothing is written: it tells who is silent.
    pub fn snapshot(&self, daemon: Daemon, now: Time) -> Option<Snapshot> {
        let header = self.tally.header.as_deref()?;
        let nodes = self.nodes(header);
        let phase = self.phase(header, daemon);
        let (_, word, why) = ending(&self.tally, header);
        let (done, of) = nodes.first().map_or((0, 0), |root| (root.done, root.of));
        Some(Snapshot {
            mission: header.mission.clone(),
            robot: header.robot.clone(),
            allocator: header.allocator.clone(),
            daemon,
            phase,
            outcome: self.tally.end.map(|_| word),
            why: Some(why).filter(|why| self.tally.end.is_some() && !why.is_empty()),
            time_s: self.tally.now.seconds(),
            makespan_s: self.tally.makespan_s(),
            rounds: self.tally.rounds,
            step: self.tally.steps.len(),
            messages: self.tally.messages,
            done,
            of,
            nodes,
            resources: self.resource_rows(header),
            controllers: self.controller_rows(header, phase, now),
            world: self.world.row(&header.names),
        })
    }

    fn begin(&mut self, header: &Header) {
        self.resources = vec![Resource::default(); header.names.resources.len()];
        self.potentials = vec![None; header.nodes.len()];
        self.world = World::new(header);
    }

    fn sent(&mut self, from: NodeId, message: &Message) {
        match message {
            // A behavior that runs asks for nothing: what it was granted with still says most.
            Message::Answer { running: true, potential: None, .. } if self.is_leaf(from) => {}
            Message::Answer { potential, .. } => self.say(from, *potential),
            Message::Activation
            | Message::Verdict { .. }
            | Message::Reopen { .. }
            | Message::Cancel
            | Message::Release { .. } => {}
        }
    }

    fn say(&mut self, node: NodeId, potential: Option<f64>) {
        if let Some(last) = self.potentials.get_mut(node.index()) {
            *last = potential;
        }
    }

    fn is_leaf(&self, node: NodeId) -> bool {
        let entry = self.tally.header.as_ref().and_then(|header| header.nodes.get(node.index()));
        entry.is_some_and(|entry| entry.kind.is_behavior())
    }

    fn phase(&self, header: &Header, daemon: Daemon) -> Phase {
        let mut controllers = (0..header.names.controllers.len()).map(Into::into);
        let is_there = |id| self.crew.member(id).is_some_and(|member| member.presence == Presence::Configured);
        match (self.tally.end, daemon) {
            (Some(_), _) => Phase::Ended,
            (None, Daemon::Gone) => Phase::Gone,
            (None, Daemon::Running { .. } | Daemon::Unknown)
                if self.tally.rounds == 0 && !controllers.all(is_there) =>
            {
                Phase::Waiting
            }
            (None, Daemon::Running { .. } | Daemon::Unknown) => Phase::Running,
        }
    }
}
