//! What events change: grants, ends, the world (`semantics` 4 and 6).

use ambidex::model::{
    Change, Completion, Consequences, EffectTerm, End, Fault, Grant, Holders, Location, MissionEnd, NodeId, NodeKind,
    NodeRange, Outcome, Rejection, ResourceId,
};

use super::failing::Fall;
use super::{Decision, Model, Step, TOP};

impl Model<'_> {
    /// What was skipped to come to a granted behavior is done, and an OR above it has chosen.
    pub(super) fn settle_grant(&mut self, grant: &Grant) {
        for skip in &grant.request.skips {
            let then = self.parent(skip.from);
            let children = self.children(then).into_iter();
            self.done.extend(children.filter(|child| skip.contains(*child)));
            self.settle_done(*skip);
        }
        for pair in self.upward(grant.leaf()).windows(2) {
            if let [child, node] = *pair
                && self.kind(node) == &NodeKind::Or
            {
                self.committed.insert(node, child);
            }
        }
        self.silent.remove(&grant.leaf());
        self.preempted.retain(|(_, wish, _)| *wish != grant.leaf());
    }

    /// True if another round follows at once.
    pub(super) fn end_of_round(&mut self, is_satisfied: bool, goes_on: bool, decision: &Decision) -> bool {
        if is_satisfied {
            self.finish(MissionEnd::Done);
        } else if !goes_on && self.running.is_empty() && self.waits.is_empty() {
            return self.stall(decision);
        }
        goes_on
    }

    pub(super) fn finish(&mut self, end: MissionEnd) {
        self.end = Some(end);
        if end == MissionEnd::Done {
            self.rows.iter_mut().for_each(|row| *row = super::Row::default());
        }
    }

    /// The world is different from outside; true if a round follows.
    pub fn world(&mut self, change: Change) -> bool {
        let before = (self.world_state.clone(), self.rows.clone());
        self.change(&[change]);
        let is_different = (&self.world_state, &self.rows) != (&before.0, &before.1);
        self.progress += u64::from(is_different);
        if is_different {
            self.hidden.clear();
        }
        is_different
    }

    /// A behavior ended: what that completes and what fails with it.
    pub fn ended(&mut self, leaf: NodeId, outcome: &Outcome) {
        self.hidden.clear();
        self.denied.clear();
        let grant = self.running.remove(&leaf).expect("only what runs ends");
        let told = self.stopping.remove(&leaf);
        let end = match self.believed(leaf, &grant, outcome) {
            End::Canceled if told.is_some_and(|cause| cause.interrupts()) => End::Interrupted,
            end => end,
        };
        let changes = self.changes(leaf, end, &grant, outcome);
        let unfit = self.rejected(&grant, end);
        self.unfit.extend(unfit.iter().map(|id| (leaf, *id, self.progress)));
        if let End::Failed(fault) = end {
            self.wait(leaf, fault, &grant);
        }
        let mut fall = self.no_fall();
        let completed = self.consequences(leaf, end, !unfit.is_empty(), &mut fall);
        let emptied = self.change_objects(&changes);
        if let Some(Completion { node, heir }) = completed {
            self.hand_over(&grant, node, heir);
            self.settle_done(self.below(node));
            self.progress += u64::from(self.ever_completed.insert(leaf) && self.cleans(leaf).is_none());
            if self.mission.tree.topology.is_cleanup(node) && self.done.contains(&node) {
                self.end_cleanup(self.parent(node), &mut fall);
            }
        }
        if fall.cleaned.is_none() && (completed.is_none() || fall.failed.is_some()) {
            self.take_back(leaf, fall.failed);
        }
        self.settle_fall(&mut fall);
        emptied.into_iter().for_each(|gripper| self.end_physical(gripper));
        if self.end == Some(MissionEnd::Done) {
            self.finish(MissionEnd::Done);
        }
        let cleaned = fall.cleaned;
        let consequences = Consequences { completed, failed: fall.failed, failing: fall.failing, cleaned };
        self.log.push(Step::Released { leaf, end, consequences, unfit });
        if let Some(completed) = completed {
            self.end_iteration_of_complete(completed.node);
        }
        self.try_again(&fall);
    }

    /// The kind's effects come first; what controllers say overrules them.
    fn changes(&self, leaf: NodeId, end: End, grant: &Grant, outcome: &Outcome) -> Vec<Change> {
        let mut changes = Vec::new();
        if end == End::Succeeded {
            let effects = self.behavior(leaf).effects.iter();
            changes.extend(effects.map(|effect| match *effect {
                EffectTerm::Lies(object, place) => Change::Object(object, Location::At(place)),
                EffectTerm::Taken(object, claim) => Change::Taken(object, grant.bindings[claim].resource),
                EffectTerm::LetGo(_, claim) => Change::Emptied(grant.bindings[claim].resource),
                EffectTerm::Stands(pose) => Change::Base(pose),
                EffectTerm::Fact(fact, holds) => Change::Fact(fact, holds),
            }));
        }
        changes.extend(&outcome.changes);
        changes
    }

    /// What would not do it, for reach or kind.
    fn rejected(&self, grant: &Grant, end: End) -> Vec<ResourceId> {
        let End::Failed(Fault::Rejected(controller, Rejection::OutOfReach | Rejection::Unsupported)) = end else {
            return Vec::new();
        };
        let claims = self.behavior(grant.leaf()).claims.len();
        let claimed = grant.bindings[..claims].iter().map(|binding| binding.resource);
        let is_its = |id: &ResourceId| self.mission.robot.resources[id.index()].controller == Some(controller);
        let mut unfit: Vec<_> = claimed.filter(is_its).collect();
        unfit.sort();
        unfit
    }

    /// Whether nothing that could serve a behavior is left.
    fn has_nothing_left(&self, leaf: NodeId) -> bool {
        let claims = &self.behavior(leaf).claims;
        let is_left = |id: &ResourceId| !self.is_gone(*id) && !self.is_unfit(leaf, *id);
        let all = claims.iter().map(|claim| self.could_serve(claim.selector).into_iter().filter(is_left));
        let left: Vec<Vec<_>> = all.map(|serving| serving.map(|id| (id, 0.0)).collect()).collect();
        left.iter().any(Vec::is_empty) || self.all_at_once(claims, &left).is_err()
    }

    pub(super) fn is_unfit(&self, leaf: NodeId, resource: ResourceId) -> bool {
        self.unfit.contains(&(leaf, resource, self.progress))
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
    fn consequences(&mut self, leaf: NodeId, end: End, is_rejected: bool, fall: &mut Fall) -> Option<Completion> {
        let mut completed = None;
        match end {
            End::Succeeded => {
                self.done.insert(leaf);
                completed = Some(self.complete_above(leaf, false));
            }
            End::Failed(fault) => {
                let failures = self.failures.entry(leaf).or_default();
                *failures += 1;
                let is_last = *failures > self.mission.tree.behavior(leaf).expect("a leaf").retries;
                if is_last || (is_rejected && self.has_nothing_left(leaf)) {
                    self.fail(leaf, leaf, Some(fault), fall);
                }
            }
            End::Canceled | End::Interrupted => {}
        }
        self.end_failing_above(leaf, fall);
        if completed.is_some_and(|completed| completed.node == TOP && !self.is_not_the_last(TOP)) {
            self.finish(MissionEnd::Done);
        }
        completed
    }

    /// The topmost node that is complete with one that is.
    pub(super) fn complete_above(&mut self, node: NodeId, is_by_others: bool) -> Completion {
        let mut completed = Completion { node, heir: None };
        // What others did is done as often as it says.
        let is_last = |model: &Self, at: NodeId| (is_by_others && at == node) || !model.is_not_the_last(at);
        while completed.node != TOP && completed.heir.is_none() && is_last(self, completed.node) {
            let parent = self.parent(completed.node);
            if self.is_canceling(parent) || self.mission.tree.topology.is_cleanup(completed.node) {
                break;
            }
            let next = self.complete_child(parent, completed.node);
            if next == completed {
                break;
            }
            completed = next;
        }
        if !is_last(self, completed.node) {
            self.done.remove(&completed.node);
        }
        completed
    }

    /// Nothing may be left that a failing node above waits for.
    pub(super) fn end_failing_above(&mut self, node: NodeId, fall: &mut Fall) {
        for above in self.upward(node) {
            self.end_failing(above, fall);
        }
    }

    fn complete_child(&mut self, node: NodeId, child: NodeId) -> Completion {
        let is_done = |child: &NodeId| self.done.contains(child) || self.mission.tree.topology.is_cleanup(*child);
        let all = self.children(node).iter().all(is_done);
        let is_then = self.kind(node) == &NodeKind::Then;
        if all || self.kind(node) == &NodeKind::Or {
            self.done.insert(node);
            Completion { node, heir: None }
        } else {
            Completion { node: child, heir: is_then.then_some(node) }
        }
    }

    /// What was sent back there is done again, and nothing waits there any more, nor does any time run.
    pub(super) fn settle_done(&mut self, nodes: NodeRange) {
        self.waits.retain(|node, _| !nodes.contains(*node));
        self.resting.retain(|node, _| !nodes.contains(*node));
        self.deadlines.retain(|node, _| !nodes.contains(*node));
        let there = self.redone.iter_mut().filter(|(leaf, _)| nodes.contains(**leaf));
        there.for_each(|(_, (_, by))| *by = None);
    }

    fn change(&mut self, changes: &[Change]) {
        let emptied = self.change_objects(changes);
        emptied.into_iter().for_each(|gripper| self.end_physical(gripper));
    }

    /// A success of which a controller says that a taker holds nothing or something else, or that what was put down is
    /// still held, is a failure of that controller.
    fn believed(&self, leaf: NodeId, grant: &Grant, outcome: &Outcome) -> End {
        if outcome.end != End::Succeeded {
            return outcome.end;
        }
        let holds = |gripper: ResourceId| {
            outcome.changes.iter().find_map(|change| match *change {
                Change::Taken(object, at) if at == gripper => Some(Some(object)),
                Change::Emptied(at) if at == gripper => Some(None),
                Change::Taken(..) | Change::Emptied(_) => None,
                Change::Object(..) | Change::Laid(..) | Change::Base(_) | Change::Fact(..) => None,
                Change::Blocked(_) | Change::Cleared(_) => None,
            })
        };
        let grippers = || (0..self.rows.len()).map(ResourceId::from);
        for effect in &self.behavior(leaf).effects {
            let strange = match *effect {
                EffectTerm::Taken(object, claim) => {
                    let taker = grant.bindings[claim].resource;
                    holds(taker).is_some_and(|held| held != Some(object)).then_some(taker)
                }
                EffectTerm::LetGo(object, claim) => {
                    let giver = grant.bindings[claim].resource;
                    (holds(giver) == Some(Some(object))).then_some(giver)
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

    /// Applies changes; the grippers that the world shows empty now.
    fn change_objects(&mut self, changes: &[Change]) -> Vec<ResourceId> {
        let grippers = || (0..self.rows.len()).map(ResourceId::from);
        let mut emptied: Vec<_> = grippers().filter(|id| self.held_object(*id).is_some()).collect();
        for &change in changes {
            match change {
                Change::Base(pose) => self.world_state.base = pose,
                Change::Laid(object, place, _) => self.world_state.objects[object.index()] = Location::At(place),
                Change::Object(object, at) => {
                    at.holders().iter().for_each(|gripper| self.open(*gripper));
                    self.world_state.objects[object.index()] = at;
                }
                Change::Taken(object, gripper) => {
                    if self.held_object(gripper) != Some(object) {
                        self.open(gripper);
                    }
                    let mut holders = self.world_state.objects[object.index()].holders().to_vec();
                    holders.push(gripper);
                    if let Ok(holders) = Holders::try_from(holders) {
                        self.world_state.objects[object.index()] = Location::In(holders);
                    }
                }
                // No tree of these has anything come to stand in its room.
                Change::Blocked(_) | Change::Cleared(_) => {}
                Change::Fact(fact, holds) => self.world_state.facts[fact.index()] = holds,
                Change::Emptied(gripper) => {
                    emptied.push(gripper);
                    self.open(gripper);
                }
            }
        }
        emptied.retain(|id| self.held_object(*id).is_none());
        emptied
    }

    /// What nothing else holds is nobody knows where.
    fn open(&mut self, gripper: ResourceId) {
        for at in &mut self.world_state.objects {
            let left: Vec<_> = at.holders().iter().copied().filter(|holder| *holder != gripper).collect();
            if left.len() < at.holders().len() {
                *at = Holders::try_from(left).map_or(Location::Unknown, Location::In);
            }
        }
    }
}
