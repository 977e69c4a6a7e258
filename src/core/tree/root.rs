//! Root: keeps resources and world, opens rounds, grants, and moves leases. Only it writes.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::lapse::LapseCheck;
use super::{Activation, Allocator, Answer, Down, Effect, Greedy, Outbox, Release, Verdict};
use crate::world::{Compatible, FreeSpace, Unconstrained, View};
use ambidex_model::{
    Blocked, Change, Claim, Grant, Heir, LeaseKind, MissionEnd, MissionSpec, NodeId, Reason, Record, Reopened,
    ResourceTable, Retention, Time, WorldState,
};

/// The top of the task: root's one child.
const TOP: NodeId = NodeId(1);

/// How a mission is to be run.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How requests are chosen.
    pub allocator: Arc<dyn Allocator>,
    /// What may go on at once beyond resources and objects.
    pub rules: Arc<dyn Compatible>,
    /// Whether a stall waits for the world instead of ending the mission.
    pub waits_when_stalled: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { allocator: Arc::new(Greedy), rules: Arc::new(Unconstrained), waits_when_stalled: false }
    }
}

/// The machine of root.
#[derive(Debug)]
pub struct Root {
    mission: Arc<MissionSpec>,
    free_space: Arc<FreeSpace>,
    settings: Settings,
    table: ResourceTable,
    /// The table as the records tell it.
    last_recorded: ResourceTable,
    world_state: WorldState,
    running: BTreeMap<NodeId, Grant>,
    round: u32,
    open: Option<Arc<View>>,
    is_wanted: bool,
    deferred: Vec<Deferred>,
    /// Behaviors that completed at least once.
    completed: BTreeSet<NodeId>,
    progress: u64,
    /// THEN and behavior below it that kept an intention for it, or was skipped as if it had.
    keepers: BTreeSet<(NodeId, NodeId)>,
    phase: Phase,
}

/// What arrives during a round is applied after its verdict.
#[derive(Debug)]
enum Deferred {
    Release(Release),
    World(Change),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Waiting,
    Running,
    Ending(MissionEnd),
    Over,
}

impl Root {
    pub(super) fn new(mission: &Arc<MissionSpec>, settings: &Settings) -> Self {
        Self {
            mission: Arc::clone(mission),
            free_space: Arc::new(FreeSpace::new(&mission.world.obstacles, mission.robot.radius_m)),
            settings: settings.clone(),
            table: ResourceTable::new(mission.robot.resources.len()),
            last_recorded: ResourceTable::new(mission.robot.resources.len()),
            world_state: mission.start.clone(),
            running: BTreeMap::new(),
            round: 0,
            open: None,
            is_wanted: false,
            deferred: Vec::new(),
            completed: BTreeSet::new(),
            progress: 0,
            keepers: BTreeSet::new(),
            phase: Phase::Waiting,
        }
    }

    /// Who holds what.
    pub fn table(&self) -> &ResourceTable {
        &self.table
    }

    /// Robot pose, objects, facts.
    pub fn world_state(&self) -> &WorldState {
        &self.world_state
    }

    /// Behaviors that were granted and have not ended.
    pub fn running(&self) -> &BTreeMap<NodeId, Grant> {
        &self.running
    }

    pub(super) fn begin(&mut self, now: Time, world_state: WorldState, out: &mut Outbox) {
        match self.phase {
            Phase::Waiting => {}
            // The end came first.
            Phase::Ending(_) | Phase::Over => return,
            Phase::Running => panic!("a mission begins once"),
        }
        self.world_state = world_state;
        self.phase = Phase::Running;
        self.is_wanted = true;
        self.advance(now, out);
    }

    pub(super) fn on_observation(&mut self, change: Change) {
        self.world_state.apply(change);
    }

    pub(super) fn on_world_change(&mut self, now: Time, change: Change, out: &mut Outbox) {
        self.deferred.push(Deferred::World(change));
        self.advance(now, out);
    }

    pub(super) fn on_release(&mut self, now: Time, release: Release, out: &mut Outbox) {
        self.deferred.push(Deferred::Release(release));
        self.advance(now, out);
    }

    pub(super) fn end(&mut self, now: Time, end: MissionEnd, out: &mut Outbox) {
        match self.phase {
            Phase::Waiting | Phase::Running => {
                self.phase = Phase::Ending(end);
                if !self.running.is_empty() {
                    out.push(Effect::Down(TOP, Down::Cancel(self.round)));
                }
                self.advance(now, out);
            }
            Phase::Ending(_) | Phase::Over => {}
        }
    }

    /// Applies what waited for the round to end, and opens the next one if one is wanted.
    fn advance(&mut self, now: Time, out: &mut Outbox) {
        if self.open.is_some() {
            return;
        }
        for deferred in std::mem::take(&mut self.deferred) {
            match deferred {
                Deferred::Release(release) => self.apply(now, release, out),
                Deferred::World(change) => self.apply_world(now, change, out),
            }
        }
        if let Phase::Ending(end) = self.phase
            && self.running.is_empty()
        {
            self.finish(now, end, out);
        }
        if self.phase == Phase::Running && std::mem::take(&mut self.is_wanted) {
            self.open_round(now, out);
        }
    }

    fn open_round(&mut self, now: Time, out: &mut Outbox) {
        self.round += 1;
        let view = Arc::new(View {
            round: self.round,
            now,
            table: self.table.clone(),
            world_state: self.world_state.clone(),
            running: self.running.clone(),
            progress: self.progress,
            mission: Arc::clone(&self.mission),
            free_space: Arc::clone(&self.free_space),
            rules: Arc::clone(&self.settings.rules),
        });
        self.open = Some(Arc::clone(&view));
        let activation = Activation { view, skips: Arc::from([]) };
        out.push(Effect::Down(TOP, Down::Activation(activation)));
    }

    pub(super) fn on_answer(&mut self, now: Time, answer: Answer, out: &mut Outbox) {
        let view = self.open.take().expect("an answer ends an open round");
        let is_complete = answer.is_satisfied;
        let mut verdict = self.decide(&view, answer);
        self.name_winners(&mut verdict);
        let is_quiet = verdict.granted.is_empty() && verdict.reopened.is_none() && self.running.is_empty();
        // What arrived meanwhile may change nothing: then another round says whether this is a stall.
        let is_unsure = is_quiet && !self.deferred.is_empty();
        self.is_wanted |= !verdict.granted.is_empty() || verdict.reopened.is_some() || is_unsure;
        out.push(Effect::Record(Box::new(Record::Decided {
            at: now,
            round: self.round,
            granted: verdict.granted.values().cloned().collect(),
            refused: verdict.refused.iter().map(|(&leaf, reason)| Blocked { leaf, reason: reason.clone() }).collect(),
            reopened: verdict.reopened.clone(),
        })));
        self.tell_table(now, out);
        out.push(Effect::Down(TOP, Down::Verdict(Arc::new(verdict))));
        if matches!(self.phase, Phase::Ending(_)) && !self.running.is_empty() {
            out.push(Effect::Down(TOP, Down::Cancel(self.round)));
        }
        if self.phase == Phase::Running && is_complete {
            self.finish(now, MissionEnd::Done, out);
        } else if self.phase == Phase::Running
            && is_quiet
            && self.deferred.is_empty()
            && !self.settings.waits_when_stalled
        {
            self.finish(now, MissionEnd::Stalled, out);
        }
        self.advance(now, out);
    }

    /// Chooses, moves the leases, and finds what lapses or goes back.
    fn decide(&mut self, view: &View, answer: Answer) -> Verdict {
        let mut verdict = Verdict { round: self.round, progress: self.progress, ..Verdict::default() };
        for blocked in answer.blocked {
            verdict.refused.insert(blocked.leaf, blocked.reason);
        }
        let requests = if self.phase == Phase::Running { answer.requests } else { Vec::new() };
        let chosen = self.settings.allocator.choose(view, requests);
        for blocked in chosen.refused {
            verdict.refused.insert(blocked.leaf, blocked.reason);
        }
        for grant in chosen.granted {
            self.table.take(&self.mission.tree.topology, &grant);
            self.remember_skipped(view, &grant, &verdict.refused);
            self.running.insert(grant.leaf(), grant.clone());
            verdict.granted.insert(grant.leaf(), grant);
        }
        if !answer.is_satisfied && self.phase == Phase::Running {
            verdict.reopened = self.reopen(view, &verdict);
        }
        verdict
    }

    /// A request that beat another below root may have lost here: a reason names only who got what it is about.
    fn name_winners(&self, verdict: &mut Verdict) {
        let told: Vec<_> = verdict.refused.iter().map(|(&leaf, reason)| (leaf, self.winner(reason, verdict))).collect();
        let lacks = verdict.reopened.as_ref().and_then(|reopened| reopened.lacks.as_ref());
        let lacks = lacks.and_then(|lacks| self.winner(&lacks.reason, verdict));
        for (leaf, reason) in told {
            if let Some(reason) = reason {
                verdict.refused.insert(leaf, reason);
            }
        }
        if let (Some(reason), Some(reopened)) = (lacks, &mut verdict.reopened)
            && let Some(lacks) = &mut reopened.lacks
        {
            lacks.reason = reason;
        }
    }

    /// The true reason where one names a behavior that did not get what it is about.
    fn winner(&self, reason: &Reason, verdict: &Verdict) -> Option<Reason> {
        let (by, contested, own) = if let Reason::Outbid { by, resource, own, .. } = *reason {
            (by, Some(resource), own)
        } else if let Reason::WholeRobot { by } = *reason {
            (by, None, 0.0)
        } else {
            return None;
        };
        if self.running.contains_key(&by) {
            return None;
        }
        let has = |grant: &&Grant| grant.bindings.iter().any(|binding| Some(binding.resource) == contested);
        let winner = verdict.granted.values().find(has).zip(contested);
        Some(match winner {
            Some((grant, resource)) => {
                Reason::Outbid { by: grant.leaf(), resource, own, theirs: grant.request.potential }
            }
            None => Reason::Outdone { by },
        })
    }

    fn reopen(&mut self, view: &View, verdict: &Verdict) -> Option<Reopened> {
        let (tree, table, running, refused) = (&self.mission.tree, &self.table, &self.running, &verdict.refused);
        let check = LapseCheck { tree, view, table, running, refused };
        let reopened = check.lapse().or_else(|| {
            let is_stuck = running.is_empty() && self.deferred.is_empty();
            if is_stuck { check.go_back(&self.keepers) } else { None }
        })?;
        if let Some(resource) = reopened.lapsed {
            self.table.lapse(resource, reopened.holder);
        }
        self.keepers.remove(&(reopened.holder, reopened.leaf));
        Some(reopened)
    }

    fn apply(&mut self, now: Time, release: Release, out: &mut Outbox) {
        let grant = self.running.remove(&release.leaf).expect("only what runs ends");
        let consequences = release.consequences;
        let were_occupied = self.occupied();
        for &change in &release.changes {
            self.world_state.apply(change);
        }
        let mission = Arc::clone(&self.mission);
        let topology = &mission.tree.topology;
        if let Some(completed) = consequences.completed {
            let heir = Heir { node: completed.heir.unwrap_or(completed.node), goes_on: completed.heir.is_some() };
            self.table.hand_over(topology, &grant, completed.node, heir);
            self.keepers.retain(|(holder, _)| !topology.is_within(*holder, completed.node));
            self.remember_kept();
            if self.completed.insert(release.leaf) {
                self.progress += 1;
            }
        }
        if consequences.completed.is_none() || consequences.failed.is_some() {
            let is_full = |resource| self.world_state.held_by(resource).is_some();
            self.table.take_back(topology, release.leaf, consequences.failed, is_full);
        }
        if let Some(failed) = consequences.failed {
            self.keepers
                .retain(|&(holder, leaf)| !topology.is_within(holder, failed) && !topology.is_within(leaf, failed));
        }
        self.release_emptied(&were_occupied, &release.changes);
        self.is_wanted = true;
        out.push(Effect::Record(Box::new(Record::Released {
            at: now,
            leaf: release.leaf,
            end: release.outcome.end,
            consequences,
            changes: release.changes,
        })));
        self.tell_table(now, out);
        if self.phase != Phase::Over && consequences.completed.is_some_and(|completed| completed.node == TOP) {
            self.finish(now, MissionEnd::Done, out);
        } else if self.phase == Phase::Running && consequences.failed == Some(TOP) {
            self.finish(now, MissionEnd::Failed(release.cause), out);
        }
    }

    fn apply_world(&mut self, now: Time, change: Change, out: &mut Outbox) {
        let were_occupied = self.occupied();
        let is_different = self.world_state.apply(change);
        // A lease may say of a gripper that it is full when nobody knows with what.
        if self.release_emptied(&were_occupied, &[change]) || is_different {
            self.progress += 1;
            self.is_wanted = true;
            out.push(Effect::Record(Box::new(Record::World { at: now, change })));
            self.tell_table(now, out);
        }
    }

    /// Which resources hold an object, by resource.
    fn occupied(&self) -> Vec<bool> {
        self.table.iter().map(|(id, _)| self.world_state.held_by(id).is_some()).collect()
    }

    /// A physical lease ends when the world shows the gripper empty; true if one did.
    fn release_emptied(&mut self, were_occupied: &[bool], changes: &[Change]) -> bool {
        let ids: Vec<_> = self.table.iter().map(|(id, _)| id).collect();
        let before = self.table.leases().count();
        for id in ids {
            let is_said_empty = changes.contains(&Change::Emptied(id));
            if (were_occupied[id.index()] || is_said_empty) && self.world_state.held_by(id).is_none() {
                self.table.emptied(id);
            }
        }
        self.table.leases().count() < before
    }

    fn remember_kept(&mut self) {
        let kept = self.table.leases().filter(|(_, lease)| lease.kind == LeaseKind::Intention);
        self.keepers.extend(kept.map(|(_, lease)| (lease.holder, lease.behavior)));
    }

    /// Skipped behaviors count as ones that kept an intention, and what was kept for a skipped node is kept for the
    /// THEN that skipped it: what they stand for may be undone as well. Ways that an OR did not take stand for nothing.
    fn remember_skipped(&mut self, view: &View, grant: &Grant, refused: &BTreeMap<NodeId, Reason>) {
        for skip in &grant.request.skips {
            let holder = self.mission.tree.topology.parent(skip.from);
            for (&leaf, reason) in refused.range(skip.from..skip.to) {
                let spec = self.mission.tree.behavior(leaf).expect("only leaves are refused");
                let keeps = |claim: &Claim| matches!(claim.keep, Retention::Intention(_));
                if *reason == Reason::Satisfied && spec.claims.iter().any(keeps) {
                    self.keepers.insert((holder, leaf));
                }
            }
            for (_, lease) in view.table.leases() {
                if lease.kind == LeaseKind::Intention && skip.contains(lease.holder) {
                    self.keepers.insert((holder, lease.behavior));
                }
            }
        }
    }

    /// Records every resource that is not as it was last told.
    fn tell_table(&mut self, now: Time, out: &mut Outbox) {
        for (id, resource) in self.table.iter().filter(|(id, resource)| self.last_recorded.resource(*id) != *resource) {
            let state = resource.clone();
            out.push(Effect::Record(Box::new(Record::Resource { at: now, resource: id, state })));
        }
        self.last_recorded.clone_from(&self.table);
    }

    fn finish(&mut self, now: Time, end: MissionEnd, out: &mut Outbox) {
        self.phase = Phase::Over;
        if end == MissionEnd::Done {
            self.table.clear();
            self.tell_table(now, out);
        }
        out.push(Effect::Record(Box::new(Record::Ended { at: now, end })));
        out.push(Effect::Finished(end));
    }
}
