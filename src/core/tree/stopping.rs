//! How behaviors end: what root tells to end and why, and what follows when one has ended (`semantics` 6).

use std::collections::BTreeSet;
use std::sync::Arc;

use super::ordering::{Ended, settle};
use super::{Down, Effect, Outbox, Root, TOP, Verdict};
use crate::behavior;
use ambidex_model::state::{Stage, State};
use ambidex_model::{
    End, Fault, Grant, Lineage, MissionEnd, NodeId, Outcome, PlaceId, Reason, Record, StopCause, Task, Time,
};

impl Root {
    /// The mission is told to end, once.
    pub(super) fn end(&mut self, now: Time, end: MissionEnd, out: &mut Outbox) {
        if self.ending.is_some() {
            return;
        }
        self.ending = Some(end);
        if self.state.stage() == Stage::Running {
            let until = self.turned + self.settings.cleanup_grace;
            self.is_wanted = true;
            self.edit(Record::Ending { at: now, end, until }, out);
        }
    }

    pub(super) fn release(&mut self, now: Time, leaf: NodeId, outcome: Outcome, out: &mut Outbox) {
        let mission = Arc::clone(&self.mission);
        // What ended when its runtime was gone may be told once more by a controller that lived on.
        let Some(grant) = self.state.running().get(&leaf) else { return };
        self.denied.clear();
        let spec = mission.tree.behavior(leaf).expect("only leaves run").asked(&grant.request);
        let end = match behavior::believed(spec, grant, &outcome) {
            End::Canceled if is_stopped_by_what_came(&self.state, leaf) => End::Failed(Fault::Blocked),
            End::Canceled if self.state.interrupted(leaf).is_some() && !self.state.is_ending(leaf) => End::Interrupted,
            end => end,
        };
        let changes = behavior::changes(spec, grant, &Outcome { end, ..outcome }, &mission.robot);
        let has_failed = matches!(end, End::Failed(_));
        let failures = self.state.status(leaf).failures;
        let unfit = match end {
            End::Failed(fault) => self.unfit(grant, fault),
            End::Succeeded | End::Canceled | End::Interrupted => Vec::new(),
        };
        let is_final = failures >= spec.retries || self.is_left_without(leaf, &unfit);
        let ended = match end {
            End::Succeeded => Ended::Succeeded,
            End::Failed(fault) if is_final => Ended::Failed(Some(fault)),
            End::Failed(_) | End::Canceled | End::Interrupted => Ended::Again,
        };
        let waits_until = (has_failed && !is_final).then(|| now + spec.wait(failures + 1));
        let settled = settle(&mission.tree, &self.state, leaf, ended);
        let consequences = settled.consequences;
        self.is_wanted = true;
        let waits_until = waits_until.filter(|_| consequences.failed.is_none() && settled.retried.is_none());
        self.edit(Record::Released { at: now, leaf, end, consequences, changes, waits_until, unfit }, out);
        self.conclude(now, settled, out);
    }

    /// Once the mission is told to end: all that runs, but for cleanups while they may take their time.
    pub(super) fn stop_all(&mut self, now: Time, out: &mut Outbox) {
        let is_over = self.is_grace_over();
        let running = self.state.running().keys().copied();
        let leaves = running.filter(|leaf| is_over || self.state.is_ending(*leaf)).collect();
        let stopped = self.stop(now, leaves, StopCause::Ends, out);
        if !stopped.is_empty() {
            let verdict = Verdict::stopping(&self.state, stopped);
            out.push(Effect::Down(TOP, Down::Verdict(Arc::new(verdict))));
        }
    }

    /// What runs below a node that fails, is given up or left.
    pub(super) fn stop_what_ends(&mut self, now: Time, out: &mut Outbox) -> BTreeSet<NodeId> {
        let running = self.state.running().keys().copied();
        let leaves = running.filter(|leaf| self.state.is_ending(*leaf)).collect();
        self.stop(now, leaves, StopCause::Ends, out)
    }

    /// What runs though something is not so any more that is to last.
    pub(super) fn stop_broken(&mut self, now: Time, out: &mut Outbox) -> BTreeSet<NodeId> {
        let broken: Vec<(NodeId, Reason)> =
            self.state.running().keys().filter_map(|leaf| Some((*leaf, self.broken(*leaf)?))).collect();
        let stop = |(leaf, reason)| self.stop(now, vec![leaf], StopCause::Broken(reason), out);
        broken.into_iter().flat_map(stop).collect()
    }

    /// What is to last while a behavior runs and is not so.
    fn broken(&self, leaf: NodeId) -> Option<Reason> {
        let grant = self.state.running().get(&leaf)?;
        if self.is_blocked(grant) {
            return self.driven_to(grant).map(|place| Reason::InTheWay { place });
        }
        let lasting = &self.mission.tree.behavior(leaf)?.asked(&grant.request).lasting;
        behavior::singles(lasting).next()?;
        let line = Lineage { topology: &self.mission.tree.topology, node: leaf, skips: &[] };
        behavior::check(lasting, &self.view(self.turned), &line).err()
    }

    /// Whether something has come to stand on what is left of the way of a running behavior.
    fn is_blocked(&self, grant: &Grant) -> bool {
        !self.came.is_free(self.state.world().base.at, &grant.way)
    }

    /// The place that a running behavior drives to.
    fn driven_to(&self, grant: &Grant) -> Option<PlaceId> {
        let spec = self.mission.tree.behavior(grant.leaf())?.asked(&grant.request);
        spec.commands.iter().find_map(|term| match term.task {
            Task::DriveTo(place, _) => Some(place),
            _ => None,
        })
    }

    /// Tells some of what runs to end, each once; those that were told already are left out.
    pub(super) fn stop(
        &mut self,
        now: Time,
        mut leaves: Vec<NodeId>,
        cause: StopCause,
        out: &mut Outbox,
    ) -> BTreeSet<NodeId> {
        leaves.retain(|leaf| !self.state.status(*leaf).is_stopping);
        if !leaves.is_empty() {
            self.edit(Record::Stopped { at: now, leaves: leaves.clone(), cause }, out);
        }
        leaves.into_iter().collect()
    }
}

/// Whether a behavior was told to end because something came to stand in its way, and for no other reason since.
fn is_stopped_by_what_came(state: &State, leaf: NodeId) -> bool {
    let cause = state.interrupted(leaf).filter(|_| !state.is_ending(leaf));
    matches!(cause, Some(StopCause::Broken(Reason::InTheWay { .. })))
}
