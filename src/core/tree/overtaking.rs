//! Work that others did need not be done: a THEN whose next behavior cannot run goes on behind what holds already
//! (`semantics` 2, "Done by others").

use std::collections::BTreeSet;

use super::goals::reaches;
use super::ordering::Ordering;
use crate::behavior;
use ambidex_model::state::{Phase, State};
use ambidex_model::{
    BehaviorSpec, Condition, EffectTerm, FactId, NodeId, NodeKind, NodeRange, ObjectId, PlaceId, TreeSpec,
};

/// A THEN goes on behind a child whose goal others have reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Overtaken {
    /// The behavior that cannot run.
    pub(super) leaf: NodeId,
    /// What counts as done.
    pub(super) skips: Vec<NodeRange>,
    /// The last of it, whose goal holds.
    pub(super) goal: NodeId,
}

/// Looks for such a child.
pub(super) struct Overtaking<'a> {
    pub(super) tree: &'a TreeSpec,
    pub(super) state: &'a State,
    /// Whether the goal of a behavior holds that is no drive; the runs would be passed over.
    pub(super) holds: &'a dyn Fn(NodeId, &[NodeRange]) -> bool,
    /// Whether a THEN can go on now.
    pub(super) can_go_on: &'a dyn Fn(NodeId) -> bool,
}

/// What a goal is about.
#[derive(Debug, Default)]
struct Concern {
    objects: BTreeSet<ObjectId>,
    facts: BTreeSet<FactId>,
    lies: BTreeSet<(ObjectId, PlaceId)>,
}

impl Overtaking<'_> {
    /// What a leaf need not do, in the lowest THEN above it of which that can be said. Every OR above has chosen the way
    /// to it.
    pub(super) fn by(&self, leaf: NodeId) -> Option<Overtaken> {
        // A cleanup goes on behind nobody but its own.
        let mut path: Vec<NodeId> = self.tree.topology.path(leaf).collect();
        let top = path.iter().position(|node| self.tree.topology.is_cleanup(*node));
        path.truncate(top.map_or(path.len(), |top| top + 1));
        let is_chosen = path.windows(2).all(|pair| {
            let is_or = self.ordering(pair[1]) == Some(Ordering::Or);
            !is_or || self.state.status(pair[1]).way == Some(pair[0])
        });
        let is_then =
            |node| self.ordering(node) == Some(Ordering::Then) && !matches!(self.state.phase(node), Phase::Failing(_));
        let thens = path.windows(2).filter(|pair| is_chosen && is_then(pair[1]) && (self.can_go_on)(pair[1]));
        thens.into_iter().find_map(|pair| {
            let (then, present) = (pair[1], pair[0]);
            let goal = self.reached_behind(then, present)?;
            // What was skipped before it is satisfied.
            let from = self.tree.topology.children(then).find(|child| !self.state.is_done(*child)).unwrap_or(present);
            Some(Overtaken { leaf, skips: self.passed(then, from, goal), goal })
        })
    }

    fn ordering(&self, node: NodeId) -> Option<Ordering> {
        Ordering::of(&self.tree.nodes[node.index()])
    }

    /// The last child of a THEN behind its present one whose goal holds, if all that would be skipped is about that.
    fn reached_behind(&self, then: NodeId, present: NodeId) -> Option<NodeId> {
        let topology = &self.tree.topology;
        let holds = |goal: &NodeId| {
            let passed = self.passed(then, present, *goal);
            reaches(self.tree, *goal, &|leaf| (self.holds)(leaf, &passed))
        };
        let later = topology.children(then).skip_while(|child| *child != present).skip(1);
        let later: Vec<NodeId> = later.collect();
        let goal = later.into_iter().rfind(holds)?;
        let mut concern = Concern::default();
        self.read_goal(goal, &mut concern);
        let passed = self.passed(then, present, goal);
        let skipped =
            passed.iter().flat_map(|run| (run.from.0..run.to.0).map(NodeId)).filter(|node| topology.has(*node));
        let is_left =
            |leaf: &NodeId| topology.path(*leaf).take_while(|node| *node != then).all(|node| !self.state.is_done(node));
        // What cleans up below is passed over with what it would clean up.
        let is_asked = |leaf: &NodeId| {
            !topology.path(*leaf).take_while(|node| *node != then).any(|node| topology.is_cleanup(node))
        };
        let mut left = skipped.filter(is_left).filter(is_asked);
        left.all(|leaf| self.concerns(leaf, &concern)).then_some(goal)
    }

    /// The children of a THEN from one to another, with all below them.
    fn passed(&self, then: NodeId, from: NodeId, to: NodeId) -> Vec<NodeRange> {
        let children: Vec<NodeId> = self.tree.topology.children(then).skip_while(|child| *child != from).collect();
        let last = children.iter().position(|child| *child == to);
        self.tree.topology.runs(children.into_iter().take(last.map_or(0, |last| last + 1)))
    }

    /// What the goal of a node is about.
    fn read_goal(&self, node: NodeId, concern: &mut Concern) {
        let mut children = self.tree.topology.children(node);
        match &self.tree.nodes[node.index()] {
            NodeKind::Behavior(spec) => concern.read(&spec.as_in(self.state.world()).satisfied),
            NodeKind::And | NodeKind::Tasks | NodeKind::Or | NodeKind::Root => {
                children.for_each(|child| self.read_goal(child, concern))
            }
            NodeKind::Then => children.last().into_iter().for_each(|child| self.read_goal(child, concern)),
            NodeKind::Cleanup => children.next().into_iter().for_each(|child| self.read_goal(child, concern)),
        }
    }

    /// Whether a leaf is about the same, and puts nothing elsewhere; drives are about nothing.
    fn concerns(&self, leaf: NodeId, concern: &Concern) -> bool {
        let spec = self.tree.behavior_in(leaf, self.state.world());
        let is_way = |spec: &&BehaviorSpec| !spec.is_drive();
        let Some(spec) = spec.filter(is_way) else { return true };
        let is_elsewhere = |effect: &EffectTerm| match *effect {
            EffectTerm::Lies(object, place) => {
                concern.objects.contains(&object) && !concern.lies.contains(&(object, place))
            }
            EffectTerm::Taken(..) | EffectTerm::LetGo(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => false,
        };
        let is_about = |effect: &EffectTerm| match *effect {
            EffectTerm::Lies(object, _) | EffectTerm::Taken(object, _) | EffectTerm::LetGo(object, _) => {
                concern.objects.contains(&object)
            }
            EffectTerm::Fact(fact, _) => concern.facts.contains(&fact),
            EffectTerm::Stands(_) => false,
        };
        let mut own = Concern::default();
        own.read(&spec.satisfied);
        own.objects.extend(&spec.changes);
        let is_own = !own.objects.is_disjoint(&concern.objects) || !own.facts.is_disjoint(&concern.facts);
        (is_own || spec.effects.iter().any(is_about)) && !spec.effects.iter().any(is_elsewhere)
    }
}

impl Concern {
    fn read(&mut self, goal: &Condition) {
        for single in behavior::singles(goal) {
            match *single {
                Condition::Held(hold) => drop(self.objects.insert(hold.object)),
                Condition::Free(object) | Condition::Somewhere(object) => drop(self.objects.insert(object)),
                Condition::Lies(object, place) => {
                    self.objects.insert(object);
                    self.lies.insert((object, place));
                }
                Condition::Fact(fact, _) => drop(self.facts.insert(fact)),
                Condition::All(_) | Condition::Never | Condition::At { .. } | Condition::Path { .. } => {}
            }
        }
    }
}
