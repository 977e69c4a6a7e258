//! What a mission is at now: the tree, the resource table (III-B), controllers, world.
//!
//! [`Snapshot`] is what a history says at one moment, with names; as text ([`Snapshot::lines`]) or as JSON, through
//! serde.

mod health;
mod nodes;
mod outline;
mod page;
mod resources;
mod snapshot;
#[cfg(test)]
mod tests;
mod text;

use ambidex_model::{ControllerId, Diagnostics, NodeId, Time};
use ambidex_record::{History, MissionOutcome, Presence};

use crate::tasks::summaries;
use crate::text::ending;

pub(crate) use nodes::reason as node_reason;
pub(crate) use nodes::rows as node_rows;
pub(crate) use outline::Outline;
pub(crate) use resources::rows as resource_rows;

pub use snapshot::{
    ControllerRow, Daemon, DiagnosticsRow, FactRow, GoalRow, HolderRow, NodeRow, ObjectRow, Phase, ResourceRow,
    Snapshot, WorldRow,
};

impl Snapshot {
    /// What a history says now.
    ///
    /// `now` is the robot's time, which goes on while nothing is written: it tells who is silent.
    pub fn new(history: &History, daemon: Daemon, now: Time) -> Self {
        let header = history.header();
        let phase = phase(history, daemon);
        let counts = history.counts(NodeId(0));
        let outcome = history.end().map(MissionOutcome::from);
        Self {
            mission: header.mission.clone(),
            robot: header.robot.clone(),
            allocator: header.allocator.clone(),
            daemon,
            phase,
            outcome,
            why: outcome.and_then(|_| ending(history).2),
            time_s: history.now().seconds(),
            makespan_s: history.makespan_s(),
            rounds: history.rounds(),
            step: history.step_count(),
            messages: history.messages(),
            done: counts.done,
            of: counts.of,
            tasks: summaries(history),
            nodes: nodes::rows(history),
            resources: resources::rows(history),
            controllers: health::rows(history, phase, now),
            world: resources::world(history),
        }
    }
}

impl Snapshot {
    /// The same with what the daemon itself says of the last second.
    #[must_use]
    pub fn with_diagnostics(mut self, told: &[Diagnostics]) -> Self {
        for diagnostics in told {
            if let Some(row) = self.controllers.get_mut(diagnostics.controller.index()) {
                row.diagnostics = Some(DiagnosticsRow::new(diagnostics, true));
            }
        }
        self
    }
}

fn phase(history: &History, daemon: Daemon) -> Phase {
    let is_there = |controller: usize| {
        let view = history.controllers().view(ControllerId::from(controller));
        view.is_some_and(|view| view.presence == Presence::Configured)
    };
    match (history.end(), daemon) {
        (Some(_), _) => Phase::Ended,
        (None, Daemon::Gone) => Phase::Gone,
        (None, Daemon::Running { .. })
            if history.rounds() == 0 && !(0..history.names().controllers.len()).all(is_there) =>
        {
            Phase::Waiting
        }
        (None, Daemon::Running { .. }) => Phase::Running,
    }
}
