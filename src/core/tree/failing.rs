//! What fails without a behavior's end: what can never run, and what takes too long; and what follows where something
//! fails: another attempt, or the end of the mission (`semantics` 6).

use std::collections::BTreeSet;
use std::sync::Arc;

use super::goals::begin_anew;
use super::ordering::{Ended, Settled, settle};
use super::overtaking::Overtaken;
use super::{Outbox, Root};
use crate::behavior;
use crate::world::{View, Ways};
use ambidex_model::state::Phase;
use ambidex_model::{
    Cause, Consequences, ControllerId, Deadline, Fault, Grant, MissionEnd, NodeId, Reason, Record, Rejection, Reopened,
    ResourceId, Service, Time, match_claims,
};

impl Root {
    /// Whatever can never run has failed for good, one after the other in tree order; what depends on it follows.
    pub(super) fn give_up(&mut self, now: Time, out: &mut Outbox) {
        loop {
            let infeasible = self.feasibility.infeasible(&self.view(now));
            if infeasible.is_empty() {
                return;
            }
            for (leaf, reason) in infeasible {
                if self.state.is_over(leaf) || self.is_over() {
                    continue;
                }
                let settled = settle(&self.mission.tree, &self.state, leaf, Ended::Failed(None));
                let consequences = settled.consequences;
                self.edit(Record::Infeasible { at: now, leaf, reason, consequences }, out);
                self.is_wanted = true;
                self.conclude(now, settled, out);
            }
            if self.is_over() {
                return;
            }
        }
    }

    /// Task nodes whose time is over, the outermost first.
    pub(super) fn time_out(&mut self, now: Time, out: &mut Outbox) {
        let due = self.state.deadlines().iter().take_while(|(until, _)| *until <= now);
        let mut due: Vec<NodeId> = due.map(|(_, node)| *node).collect();
        due.sort_unstable();
        for node in due {
            if self.is_over() {
                return;
            }
            // With something above it that took too long.
            if self.state.is_over(node) {
                continue;
            }
            let settled = settle(&self.mission.tree, &self.state, node, Ended::OutOfTime);
            let consequences = settled.consequences;
            self.edit(Record::TimedOut { at: now, node, consequences }, out);
            self.is_wanted = true;
            self.conclude(now, settled, out);
        }
    }

    /// A THEN goes on behind what others did.
    pub(super) fn overtake(&mut self, now: Time, Overtaken { leaf, skips, goal }: Overtaken, out: &mut Outbox) {
        let record = |consequences| Record::Overtaken { at: now, leaf, skips: skips.clone(), goal, consequences };
        let mut after = self.state.clone();
        after.apply(&record(Consequences::default()));
        let settled = settle(&self.mission.tree, &after, goal, Ended::Succeeded);
        self.edit(record(settled.consequences), out);
        self.conclude(now, settled, out);
    }

    /// What follows once something has failed or is complete.
    pub(super) fn conclude(&mut self, now: Time, settled: Settled, out: &mut Outbox) {
        let Settled { consequences, cause, retried, repeated } = settled;
        if let Some(node) = repeated {
            return self.repeat(now, node, out);
        }
        if let Some((node, fault)) = retried {
            let reopened = self.attempt(node, fault);
            // What is done once more is done as often as it says, from now on.
            let topology = self.state.topology();
            let is_done = |above: NodeId| above > node && self.state.phase(above) == Phase::Done;
            self.began.retain(|begun, _| !topology.is_within(*begun, node) || !topology.path(*begun).any(is_done));
            self.edit(Record::Reopened { at: now, reopened }, out);
        }
        let completed = consequences.completed.map(|completed| completed.node).filter(|node| self.is_task(*node));
        let failed = consequences.failed.filter(|node| self.is_task(*node));
        match (completed, failed, self.mission.tree.is_standing()) {
            (Some(_), _, false) => self.finish(now, MissionEnd::Done, out),
            (None, Some(_), false) if self.ending.is_none() => self.finish(now, self.failed_for(cause), out),
            (Some(task), _, true) => self.note_ended(task, MissionEnd::Done),
            (None, Some(task), true) => self.note_ended(task, self.failed_for(cause)),
            (None, Some(_), false) | (None, None, _) => {}
        }
    }

    /// How a mission ends that failed at a node: as lost, where that claimed what is gone for good.
    pub(super) fn failed_for(&self, cause: NodeId) -> MissionEnd {
        let gone = match self.state.infeasible().get(&cause) {
            Some(Reason::Unavailable { resource, .. }) => self.mission.robot.resources[resource.index()].controller,
            Some(_) | None => None,
        };
        gone.map_or(MissionEnd::Failed(cause), MissionEnd::ControllerLost)
    }

    /// A further attempt of a node, with what begins anew in it.
    fn attempt(&self, node: NodeId, fault: Fault) -> Reopened {
        let wait = self.mission.tree.limits(node).wait(self.state.status(node).failures + 1);
        let view = self.view(self.turned);
        let mut reset = vec![node];
        begin_anew(&view, node, &mut reset);
        reset.sort_unstable();
        // Waiting is counted from the turn: when answers have come is not told again.
        let cause = Cause::Retry { fault, since: self.turned, until: self.turned + wait };
        Reopened { reset, ..Reopened::new(node, node, cause) }
    }

    /// The moments at which task nodes will have taken too long that begin with some grants.
    pub(super) fn deadlines<'a>(&self, granted: impl Iterator<Item = &'a Grant>) -> Vec<Deadline> {
        let tree = &self.mission.tree;
        if tree.limits.is_empty() {
            return Vec::new();
        }
        // A cleanup takes no time of those above it: what it cleans up has ended.
        let below_cleanup = |grant: &Grant| {
            let path: Vec<NodeId> = tree.topology.path(grant.leaf()).collect();
            let top = path.iter().position(|node| tree.topology.is_cleanup(*node));
            path.into_iter().take(top.map_or(usize::MAX, |top| top + 1))
        };
        let above: BTreeSet<NodeId> = granted.flat_map(below_cleanup).collect();
        let begun = above.into_iter().filter(|node| !self.state.is_timed(*node));
        begun.filter_map(|node| Some(Deadline { node, until: self.turned + tree.limits(node).timeout? })).collect()
    }

    /// What would not do a behavior, for reach or kind.
    pub(super) fn unfit(&self, grant: &Grant, fault: Fault) -> Vec<ResourceId> {
        let Fault::Rejected(controller, Rejection::OutOfReach | Rejection::Unsupported) = fault else {
            return Vec::new();
        };
        self.moved_for(grant, controller)
    }

    fn moved_for(&self, grant: &Grant, controller: ControllerId) -> Vec<ResourceId> {
        let claimed = std::iter::zip(&grant.request.claims, &grant.bindings).map(|(_, binding)| binding.resource);
        claimed.filter(|id| self.mission.robot.resources[id.index()].controller == Some(controller)).collect()
    }

    /// Whether nothing is left that would serve a behavior, once some of it will not.
    pub(super) fn is_left_without(&self, leaf: NodeId, unfit: &[ResourceId]) -> bool {
        let Some(spec) = self.mission.tree.behavior(leaf).filter(|_| !unfit.is_empty()) else { return false };
        let known = self.state.unfit(leaf);
        let would = spec.claims.iter().map(|claim| {
            let all = behavior::could_serve(claim, &self.state, &self.mission.robot);
            let is_gone = |id: ResourceId| matches!(self.state.table().resource(id).service(), Service::Gone { .. });
            let is_fit = |id: &ResourceId| !known.contains(id) && !unfit.contains(id) && !is_gone(*id);
            all.into_iter().filter(is_fit).collect::<Vec<_>>()
        });
        match_claims(&would.collect::<Vec<_>>()).is_err()
    }

    /// Where the base can drive from where it is; what was found is kept while it stands there.
    pub(super) fn ways(&self) -> Arc<Ways> {
        let base = self.state.world().base;
        match &self.ways {
            Some(ways) if ways.are_from(&self.free_space, base) => Arc::clone(ways),
            Some(_) | None => Arc::new(Ways::new(&self.free_space, base)),
        }
    }

    /// The state as nodes see it in a round.
    pub(super) fn view(&self, now: Time) -> View {
        View {
            round: self.state.round() + 1,
            now,
            state: self.state.clone(),
            touched: None,
            barred: Arc::clone(self.certificate.barred()),
            mission: Arc::clone(&self.mission),
            ways: self.ways(),
            rules: Arc::clone(&self.settings.rules),
        }
    }
}
