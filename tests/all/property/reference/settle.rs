//! What events change: grants, ends, the world (`semantics` 4 and 6).

use std::time::Duration;

use ambidex::model::{
    Change, Completion, Consequences, ControllerId, EffectTerm, End, Fault, Grant, Location, Loss, MissionEnd, NodeId,
    NodeKind, NodeRange, Outcome, ResourceId,
};

use super::Model;

const TOP: NodeId = NodeId(1);

impl Model<'_> {
    /// What was skipped to come to a granted behavior is done, and an OR above it has chosen.
    pub(super) fn settle_grant(&mut self, grant: &Grant) {
        for skip in &grant.request.skips {
            let then = self.parent(skip.from);
            let children = self.children(then).into_iter();
            self.done.extend(children.filter(|child| skip.contains(*child)));
            self.forget_needs(*skip);
        }
        for pair in self.upward(grant.leaf()).windows(2) {
            if let [child, node] = *pair
                && self.kind(node) == &NodeKind::Or
            {
                self.committed.insert(node, child);
            }
        }
        self.silent.remove(&grant.leaf());
    }

    pub(super) fn end_of_round(&mut self, is_satisfied: bool, goes_on: bool) {
        if is_satisfied {
            self.finish(MissionEnd::Done);
        } else if !goes_on && self.running.is_empty() && self.waits.is_empty() {
            self.stall();
        }
    }

    /// Who is away is awaited for ten seconds; then whoever is still away is the cause.
    fn stall(&mut self) {
        let moves = |id: &ControllerId| self.mission.robot.moved_by(*id).next();
        if self.away.iter().any(|(id, (_, is_awaited))| *is_awaited && moves(id).is_some()) {
            self.awaited.get_or_insert(self.now + Duration::from_secs(10));
            return;
        }
        let first = self.away.keys().filter_map(|id| Some((moves(id)?, *id))).min();
        self.finish(first.map_or(MissionEnd::Stalled, |(_, id)| MissionEnd::ControllerLost(id)));
    }

    /// A controller is away, or back; a round follows.
    pub fn service(&mut self, controller: ControllerId, outage: Option<Loss>) -> bool {
        if outage.is_some() && self.away.contains_key(&controller) {
            return false;
        }
        self.awaited = None;
        match outage {
            Some(why) => drop(self.away.insert(controller, (why, true))),
            None => drop(self.away.remove(&controller)),
        }
        true
    }

    fn finish(&mut self, end: MissionEnd) {
        self.end = Some(end);
        if end == MissionEnd::Done {
            self.rows.iter_mut().for_each(|row| *row = super::Row::default());
        }
    }

    /// The moment came for which some wait; true if a round follows.
    pub fn woke(&mut self) -> bool {
        let before = self.waits.len();
        self.waits.retain(|_, (until, ..)| *until > self.now);
        let is_over = self.awaited.is_some_and(|until| until <= self.now);
        if is_over {
            self.awaited = None;
            self.away.values_mut().for_each(|(_, is_awaited)| *is_awaited = false);
        }
        self.waits.len() < before || is_over
    }

    /// The world is different from outside; true if a round follows.
    pub fn world(&mut self, change: Change) -> bool {
        let before = (self.world_state.clone(), self.rows.clone());
        self.change(&[change]);
        let is_different = (&self.world_state, &self.rows) != (&before.0, &before.1);
        self.progress += u64::from(is_different);
        is_different
    }

    /// A behavior ended: what that completes and what fails with it.
    pub fn ended(&mut self, leaf: NodeId, outcome: &Outcome) -> Consequences {
        let grant = self.running.remove(&leaf).expect("only what runs ends");
        let mut changes = Vec::new();
        let end = self.believed(leaf, &grant, outcome);
        if end == End::Succeeded {
            let effects = self.behavior(leaf).effects.iter();
            changes.extend(effects.map(|effect| match *effect {
                EffectTerm::Lies(object, place) => Change::Object(object, Location::At(place)),
                EffectTerm::Taken(object, claim) => {
                    Change::Object(object, Location::In(grant.bindings[claim].resource))
                }
                EffectTerm::Stands(pose) => Change::Base(pose),
                EffectTerm::Fact(fact, holds) => Change::Fact(fact, holds),
            }));
        }
        changes.extend(&outcome.changes);
        if let End::Failed(fault) = end {
            self.wait(leaf, fault, &grant);
        }
        let consequences = self.consequences(leaf, end);
        let emptied = self.change_objects(&changes);
        if let Some(Completion { node, heir }) = consequences.completed {
            self.hand_over(&grant, node, heir);
            self.forget_needs(self.below(node));
            self.progress += u64::from(self.ever_completed.insert(leaf));
        }
        if consequences.completed.is_none() || consequences.failed.is_some() {
            self.take_back(leaf, consequences.failed);
        }
        if let Some(failed) = consequences.failed {
            let below = self.below(failed);
            self.waits.retain(|leaf, _| !below.contains(*leaf));
        }
        emptied.into_iter().for_each(|gripper| self.end_physical(gripper));
        if self.end == Some(MissionEnd::Done) {
            self.finish(MissionEnd::Done);
        }
        consequences
    }

    /// It waits twice as long as the last time, and prefers other resources from now on.
    fn wait(&mut self, leaf: NodeId, fault: Fault, grant: &Grant) {
        let claims = self.behavior(leaf).claims.len();
        self.bad.extend(grant.bindings[..claims].iter().map(|binding| (leaf, binding.resource)));
        let failures = self.failures.get(&leaf).copied().unwrap_or(0);
        let wait = self.behavior(leaf).backoff * 2u32.pow(failures);
        self.waits.insert(leaf, (self.now + wait, wait.as_millis() as u64, fault));
    }

    /// Done and failed flags from the leaf upward.
    fn consequences(&mut self, leaf: NodeId, end: End) -> Consequences {
        let mut completed = None;
        let mut failed = None;
        let mut cause = leaf;
        match end {
            End::Succeeded => {
                self.done.insert(leaf);
                completed = Some(Completion { node: leaf, heir: None });
            }
            End::Failed(_) => {
                let failures = self.failures.entry(leaf).or_default();
                *failures += 1;
                if *failures > self.mission.tree.behavior(leaf).expect("a leaf").retries {
                    failed = Some(leaf);
                }
            }
            End::Canceled | End::Interrupted => {}
        }
        for pair in self.upward(leaf).windows(2) {
            let [child, node] = *pair else { unreachable!() };
            if node.0 == 0 {
                break;
            }
            if failed == Some(child) {
                self.fail_child(node, child, cause);
            }
            if completed == Some(Completion { node: child, heir: None }) && !self.ending.contains_key(&node) {
                completed = Some(self.complete_child(node, child));
            }
            if let Some(&(_, first)) = self.ending.get(&node)
                && !self.runs_below(node)
            {
                (failed, cause) = (Some(node), first);
            }
        }
        if completed.is_some_and(|completed| completed.node == TOP) {
            self.finish(MissionEnd::Done);
        } else if failed == Some(TOP) {
            self.finish(MissionEnd::Failed(cause));
        }
        Consequences { completed, failed, failing: None }
    }

    fn fail_child(&mut self, node: NodeId, child: NodeId, cause: NodeId) {
        self.failed.insert(child);
        let fails = match self.kind(node) {
            NodeKind::Or => {
                self.committed.remove(&node);
                self.children(node).iter().all(|child| self.failed.contains(child))
            }
            NodeKind::And | NodeKind::Then => true,
            NodeKind::Root | NodeKind::Behavior(_) => unreachable!("has no failing child"),
        };
        if fails {
            self.ending.entry(node).or_insert((child, cause));
        }
    }

    fn complete_child(&mut self, node: NodeId, child: NodeId) -> Completion {
        let all = self.children(node).iter().all(|child| self.done.contains(child));
        let is_then = self.kind(node) == &NodeKind::Then;
        if all || self.kind(node) == &NodeKind::Or {
            self.done.insert(node);
            Completion { node, heir: None }
        } else {
            Completion { node: child, heir: is_then.then_some(node) }
        }
    }

    /// What was sent back there is done again, and nothing waits there any more.
    fn forget_needs(&mut self, nodes: NodeRange) {
        self.waits.retain(|leaf, _| !nodes.contains(*leaf));
        let there = self.redone.iter_mut().filter(|(leaf, _)| nodes.contains(**leaf));
        there.for_each(|(_, (_, by))| *by = None);
    }

    fn change(&mut self, changes: &[Change]) {
        let emptied = self.change_objects(changes);
        emptied.into_iter().for_each(|gripper| self.end_physical(gripper));
    }

    /// Applies changes; the grippers that the world shows empty now.
    /// How a running behavior ended.
    pub fn judged(&self, leaf: NodeId, outcome: &Outcome) -> End {
        self.believed(leaf, &self.running[&leaf], outcome)
    }

    /// A success of which a controller says that a taker holds nothing or something else, or that what was put down is
    /// still held, is a failure of that controller.
    fn believed(&self, leaf: NodeId, grant: &Grant, outcome: &Outcome) -> End {
        if outcome.end != End::Succeeded {
            return outcome.end;
        }
        let holds = |gripper: ResourceId| {
            outcome.changes.iter().find_map(|change| match *change {
                Change::Object(object, Location::In(at)) if at == gripper => Some(Some(object)),
                Change::Emptied(at) if at == gripper => Some(None),
                Change::Object(..) | Change::Emptied(_) | Change::Base(_) | Change::Fact(..) => None,
            })
        };
        let grippers = || (0..self.rows.len()).map(ResourceId::from);
        for effect in &self.behavior(leaf).effects {
            let strange = match *effect {
                EffectTerm::Taken(object, claim) => {
                    let taker = grant.bindings[claim].resource;
                    let is_strange = |id: &ResourceId| match holds(*id) {
                        Some(held) if *id == taker => held != Some(object),
                        Some(held) => held == Some(object),
                        None => false,
                    };
                    outcome.changes.iter().filter_map(gripper_of).find(is_strange)
                }
                EffectTerm::Lies(object, _) => grippers().find(|id| holds(*id) == Some(Some(object))),
                EffectTerm::Stands(_) | EffectTerm::Fact(..) => None,
            };
            if let Some(gripper) = strange {
                return End::Failed(Fault::Contradicted(gripper));
            }
        }
        End::Succeeded
    }

    fn change_objects(&mut self, changes: &[Change]) -> Vec<ResourceId> {
        let grippers = || (0..self.rows.len()).map(ResourceId::from);
        let mut emptied: Vec<_> = grippers().filter(|id| self.held_object(*id).is_some()).collect();
        for &change in changes {
            match change {
                Change::Base(pose) => self.world_state.base = pose,
                Change::Object(object, at) => {
                    let is_pushed_out = |other: &Location| *other == at && matches!(at, Location::In(_));
                    self.world_state
                        .objects
                        .iter_mut()
                        .filter(|other| is_pushed_out(other))
                        .for_each(|other| *other = Location::Unknown);
                    self.world_state.objects[object.index()] = at;
                }
                Change::Fact(fact, holds) => self.world_state.facts[fact.index()] = holds,
                Change::Emptied(gripper) => {
                    emptied.push(gripper);
                    if let Some(object) = self.held_object(gripper) {
                        self.world_state.objects[object.index()] = Location::Unknown;
                    }
                }
            }
        }
        emptied.retain(|id| self.held_object(*id).is_none());
        emptied
    }
}

fn gripper_of(change: &Change) -> Option<ResourceId> {
    match *change {
        Change::Object(_, Location::In(gripper)) | Change::Emptied(gripper) => Some(gripper),
        Change::Object(..) | Change::Base(_) | Change::Fact(..) => None,
    }
}
