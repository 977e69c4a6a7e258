//! What comes of a round in which nothing goes on, and of moments and controllers (`semantics` 2 and 6).

use std::time::Duration;

use ambidex::model::{Cause, ControllerId, Loss, MissionEnd, NodeId, NodeKind, Reason, Reopened};

use super::{Decision, Model, Step, TOP};

impl Model<'_> {
    /// True if another round follows at once.
    pub(super) fn stall(&mut self, decision: &Decision) -> bool {
        if let Some(node) = self.cleaning.first().copied() {
            self.end_cleanup_alone(node, false);
            return true;
        }
        // Who is away is awaited for ten seconds.
        if self.away.iter().any(|(id, (_, is_awaited))| *is_awaited && self.moves_something(*id)) {
            self.awaited.get_or_insert(self.now + Duration::from_secs(10));
            return false;
        }
        if self.leave() {
            return true;
        }
        if !self.resting.is_empty() {
            return false;
        }
        let world = &self.mission.world;
        let is_outside = |reason: &Reason| matches!(reason, Reason::Fact { fact, .. } if world.is_outside(*fact));
        if !decision.refused.values().any(|refusal| is_outside(refusal.reason.root_cause())) {
            self.end_stalled(false);
        }
        self.ending.is_some()
    }

    /// Nothing can come any more: what has failed already has failed, then whoever was awaited in vain is the cause.
    pub fn end_stalled(&mut self, is_told: bool) {
        let moves = |id: &ControllerId| self.mission.robot.moved_by(*id).next();
        let first = self.away.keys().filter_map(|id| Some((moves(id)?, *id))).min();
        let end = match (self.failing.get(&TOP), first) {
            (Some(failing), _) => self.failed_at(failing.cause),
            (None, Some((_, id))) => MissionEnd::ControllerLost(id),
            (None, None) => MissionEnd::Stalled,
        };
        self.ending = Some((end, self.now + Duration::from_secs(10)));
        if self.owes(TOP, None) || is_told {
            self.ending = None;
            self.tell_to_finish(end);
            return;
        }
        self.ending = None;
        self.finish(end);
    }

    fn moves_something(&self, controller: ControllerId) -> bool {
        self.mission.robot.moved_by(controller).next().is_some()
    }

    /// The last OR that can leave its way does.
    fn leave(&mut self) -> bool {
        let nodes = (1..self.mission.tree.nodes.len()).rev().map(NodeId::from);
        let found = nodes.filter(|node| self.kind(*node) == &NodeKind::Or).find_map(|or| {
            let way = *self.committed.get(&or)?;
            let others = self.children(or).into_iter().filter(|other| *other != way);
            let has_other = others.into_iter().any(|other| !self.failed.contains(&other));
            let was_left = self.left.get(&way) == Some(&self.progress);
            (!self.is_over(or) && !self.done.contains(&way) && has_other && !was_left).then_some((or, way))
        });
        let Some((or, way)) = found else { return false };
        self.leaving.insert(way, or);
        if self.owes(way, None) {
            self.log.push(Step::Leaving { way });
        } else {
            self.leaving.remove(&way);
            self.leave_at_last(or, way);
        }
        true
    }

    pub(super) fn leave_at_last(&mut self, or: NodeId, way: NodeId) {
        self.hidden.clear();
        self.committed.remove(&or);
        self.rechoices += 1;
        self.left.insert(way, self.progress);
        let below = self.below(way);
        self.gather(or, |holder| below.contains(holder));
        self.deadlines.retain(|node, _| !below.contains(*node));
        self.begun.retain(|node| !below.contains(*node));
        self.log.push(Step::Reopened(Reopened::new(way, or, Cause::Leave)));
    }

    /// A controller is away, or back; a round follows.
    pub fn service(&mut self, controller: ControllerId, outage: Option<Loss>) -> bool {
        self.hidden.clear();
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

    /// The moment came for which some wait; true if a round follows.
    pub fn woke(&mut self) -> bool {
        let before = self.waits.len();
        self.waits.retain(|_, (until, ..)| *until > self.now);
        let is_over = self.awaited.is_some_and(|until| until <= self.now);
        if is_over {
            self.hidden.clear();
            self.awaited = None;
            self.away.values_mut().for_each(|(_, is_awaited)| *is_awaited = false);
        }
        let resting = self.resting.len();
        self.resting.retain(|_, (until, _)| *until > self.now);
        let mut goes_on = self.waits.len() < before || self.resting.len() < resting || is_over;
        while let Some(node) = self.first_out_of_time() {
            self.time_out(node);
            goes_on = true;
        }
        goes_on
    }

    /// Of several the outermost.
    fn first_out_of_time(&self) -> Option<NodeId> {
        let due = self.deadlines.iter().filter(|(_, until)| **until <= self.now);
        due.map(|(node, _)| *node).find(|node| !self.is_over(*node))
    }
}
