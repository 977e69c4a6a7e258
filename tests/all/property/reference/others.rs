//! What others have done need not be done again (`semantics` 2).

use std::collections::BTreeSet;

use ambidex::model::{
    Completion, Condition, Consequences, EffectTerm, MissionEnd, NodeId, NodeKind, NodeRange, ObjectId,
};

use super::world::singles;
use super::{Model, Step, TOP};

impl Model<'_> {
    /// The lowest THEN above a blocked leaf that can go on behind a later child goes on; true if there is one.
    pub(super) fn overtake(&mut self, leaf: NodeId) -> bool {
        let path = self.within(leaf);
        let is_chosen =
            |pair: &[NodeId]| self.kind(pair[1]) != &NodeKind::Or || self.committed.get(&pair[1]) == Some(&pair[0]);
        if !path.windows(2).all(is_chosen) {
            return false;
        }
        let found = path.windows(2).find_map(|pair| {
            let goal = self.overtaken(pair[1], pair[0])?;
            Some((pair[1], goal))
        });
        let Some((then, goal)) = found else { return false };
        self.go_on_behind(leaf, then, goal);
        true
    }

    /// Whether every OR above a leaf has chosen the way to it.
    fn is_chosen(&self, leaf: NodeId) -> bool {
        let is_way =
            |pair: &[NodeId]| self.kind(pair[1]) != &NodeKind::Or || self.committed.get(&pair[1]) == Some(&pair[0]);
        self.within(leaf).windows(2).all(is_way)
    }

    /// The last child behind `child` whose goal holds, if all that is passed over is about that goal.
    fn overtaken(&self, then: NodeId, child: NodeId) -> Option<NodeId> {
        if self.kind(then) != &NodeKind::Then || self.failing.contains_key(&then) {
            return None;
        }
        if self.runs_below(then) || self.waits_below(then) {
            return None;
        }
        let children = self.children(then);
        let goal = *children.iter().rfind(|later| **later > child && self.is_reached(**later))?;
        self.is_all_about(then, child, goal).then_some(goal)
    }

    /// Whether all that would be passed over is about the goal of a child; what was skipped before is satisfied.
    fn is_all_about(&self, then: NodeId, child: NodeId, goal: NodeId) -> bool {
        let mut parts = Vec::new();
        self.goal_parts(goal, &mut parts);
        let passed = NodeRange { from: child, to: self.below(goal).to };
        let is_in_cleanup = |leaf: &NodeId| self.cleans(*leaf) != self.cleans(then);
        let leaves = self.mission.tree.leaves().filter(|leaf| passed.contains(*leaf) && !is_in_cleanup(leaf));
        let is_left = |leaf: &NodeId| {
            let between = self.upward(*leaf).into_iter().take_while(|node| *node != then);
            !self.behavior(*leaf).is_drive() && between.into_iter().all(|node| !self.done.contains(&node))
        };
        leaves.filter(is_left).all(|leaf| self.is_about(leaf, &parts))
    }

    /// Whether others may do the work of a leaf: a THEN above could go on behind a child whose goal they can reach.
    pub(super) fn may_be_overtaken(&self, leaf: NodeId, makers: &BTreeSet<NodeId>) -> bool {
        let path = self.within(leaf);
        let mut pairs = path.windows(2).take_while(|_| self.is_chosen(leaf));
        pairs.any(|pair| {
            let [child, then] = *pair else { unreachable!() };
            if self.kind(then) != &NodeKind::Then || self.failing.contains_key(&then) {
                return false;
            }
            let can_come = |goal: &NodeId| {
                let passed = NodeRange { from: child, to: self.below(*goal).to };
                let others = makers.iter().copied().filter(|maker| !passed.contains(*maker)).collect();
                self.can_be_reached(*goal, &others)
            };
            let later = self.children(then).into_iter().rev().filter(|later| *later > child);
            later.into_iter().find(can_come).is_some_and(|goal| self.is_all_about(then, child, goal))
        })
    }

    fn can_be_reached(&self, node: NodeId, makers: &BTreeSet<NodeId>) -> bool {
        let children = self.children(node);
        match self.kind(node) {
            NodeKind::Cleanup => self.can_be_reached(self.body(node), makers),
            NodeKind::Behavior(spec) => {
                !spec.is_drive() && singles(&spec.satisfied).into_iter().all(|part| self.can_be(part, makers))
            }
            NodeKind::And | NodeKind::Tasks => children.iter().all(|child| self.can_be_reached(*child, makers)),
            NodeKind::Or => children.iter().any(|child| self.can_be_reached(*child, makers)),
            NodeKind::Then => children.last().is_some_and(|child| self.can_be_reached(*child, makers)),
            NodeKind::Root => unreachable!("is no child"),
        }
    }

    fn goal_parts<'a>(&'a self, node: NodeId, parts: &mut Vec<&'a Condition>) {
        let children = self.children(node);
        match self.kind(node) {
            NodeKind::Cleanup => self.goal_parts(self.body(node), parts),
            NodeKind::Behavior(spec) => parts.extend(singles(&spec.satisfied)),
            NodeKind::And | NodeKind::Tasks | NodeKind::Or => {
                children.iter().for_each(|child| self.goal_parts(*child, parts))
            }
            NodeKind::Then => self.goal_parts(*children.last().expect("a child"), parts),
            NodeKind::Root => unreachable!("is no child"),
        }
    }

    /// Whether a behavior wants, makes or changes an object or a fact of a goal, and puts none where the goal does not have it.
    fn is_about(&self, leaf: NodeId, goal: &[&Condition]) -> bool {
        let spec = self.behavior(leaf);
        let has_object = |object: ObjectId| {
            goal.iter().any(|part| match part {
                Condition::Held(hold) => hold.object == object,
                Condition::Free(other) | Condition::Somewhere(other) | Condition::Lies(other, _) => *other == object,
                Condition::Fact(..)
                | Condition::At { .. }
                | Condition::Path { .. }
                | Condition::Never
                | Condition::All(_) => false,
            })
        };
        let has_fact = |fact| goal.iter().any(|part| matches!(part, Condition::Fact(other, _) if *other == fact));
        let is_of_goal = |effect: &EffectTerm| match *effect {
            EffectTerm::Lies(object, _) | EffectTerm::Taken(object, _) | EffectTerm::LetGo(object, _) => {
                has_object(object)
            }
            EffectTerm::Fact(fact, _) => has_fact(fact),
            EffectTerm::Stands(_) => false,
        };
        let is_astray = |effect: &EffectTerm| match *effect {
            EffectTerm::Lies(object, place) => has_object(object) && !goal.contains(&&Condition::Lies(object, place)),
            EffectTerm::Taken(..) | EffectTerm::LetGo(..) | EffectTerm::Fact(..) | EffectTerm::Stands(_) => false,
        };
        let has_it = |part: &Condition| match *part {
            Condition::Held(hold) => has_object(hold.object),
            Condition::Free(object) | Condition::Somewhere(object) | Condition::Lies(object, _) => has_object(object),
            Condition::Fact(fact, _) => has_fact(fact),
            Condition::At { .. } | Condition::Path { .. } | Condition::Never | Condition::All(_) => false,
        };
        let changes = spec.changes.iter().any(|object| has_object(*object));
        let wants = singles(&spec.satisfied).into_iter().any(has_it);
        (wants || changes || spec.effects.iter().any(is_of_goal)) && !spec.effects.iter().any(is_astray)
    }

    /// What stands between counts as done, and kept leases go as on success.
    fn go_on_behind(&mut self, leaf: NodeId, then: NodeId, goal: NodeId) {
        let from = *self.not_done(then).first().expect("a child with the leaf");
        let skip = NodeRange { from, to: self.below(goal).to };
        let children = self.children(then).into_iter();
        self.done.extend(children.filter(|child| skip.contains(*child)));
        self.settle_done(skip);
        self.move_all(|holder| skip.contains(holder), Some(then), then);
        let mut fall = self.no_fall();
        let Completion { node, heir } = self.complete_above(goal, true);
        let below = self.below(node);
        self.move_all(|holder| below.contains(holder), heir, node);
        self.settle_done(below);
        if self.mission.tree.topology.is_cleanup(node) && self.done.contains(&node) {
            self.end_cleanup(self.parent(node), &mut fall);
        }
        self.end_failing_above(goal, &mut fall);
        if let Some(failed) = fall.failed {
            self.take_back(failed, Some(failed));
        }
        self.settle_fall(&mut fall);
        let completed = Some(Completion { node, heir });
        let cleaned = fall.cleaned;
        let consequences = Consequences { completed, failed: fall.failed, failing: fall.failing, cleaned };
        self.log.push(Step::Overtaken { leaf, skip, goal, consequences });
        if node != goal {
            self.end_iteration_of_complete(node);
        }
        self.try_again(&fall);
        if node == TOP && self.done.contains(&TOP) {
            self.finish(MissionEnd::Done);
        }
    }
}
