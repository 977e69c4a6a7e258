//! AND, OR and THEN: whom they ask, what they pass on, and what the end of a child means for them (III-A, III-C). No
//! other file tells them apart.

use super::{Answer, News, Requests};
use ambidex_model::state::{Phase, State};
use ambidex_model::{Completion, Consequences, End, Failing, LeaseKind, NodeId, NodeKind, NodeRange, Reason, TreeSpec};

/// The ordering constraint of a task node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ordering {
    /// All children, in any order.
    And,
    /// One child.
    Or,
    /// All children, in order.
    Then,
}

impl Ordering {
    /// That of a node; none of root and of behaviors.
    pub(super) fn of(kind: &NodeKind) -> Option<Self> {
        match kind {
            NodeKind::And => Some(Self::And),
            NodeKind::Or => Some(Self::Or),
            NodeKind::Then => Some(Self::Then),
            NodeKind::Root | NodeKind::Behavior(_) => None,
        }
    }

    /// Whom a round asks at once.
    pub(super) fn first(self, state: &State, node: NodeId) -> impl Iterator<Item = NodeId> {
        let way = state.status(node).way;
        let is_open = move |child: &NodeId| match self {
            Self::And | Self::Then => !state.is_done(*child),
            Self::Or => way.map_or(state.phase(*child) != Phase::Failed, |way| way == *child),
        };
        let most = if self == Self::Then { 1 } else { usize::MAX };
        state.topology().children(node).filter(is_open).take(most)
    }

    /// Whom a THEN asks behind a child that is satisfied, in the same round (III-C.2).
    pub(super) fn behind(self, state: &State, node: NodeId, satisfied: NodeId) -> Option<NodeId> {
        match self {
            Self::And | Self::Or => None,
            Self::Then if state.is_busy(node) => None,
            Self::Then => state.topology().children(node).find(|child| *child > satisfied && !state.is_done(*child)),
        }
    }

    /// Whether an OR or a THEN is satisfied when all that it asked, in order, have answered and nothing below runs.
    pub(super) fn is_satisfied<'a>(self, state: &State, node: NodeId, answers: impl Answers<'a>) -> bool {
        let last = answers.clone().last();
        match self {
            Self::And => answers.clone().all(|(_, answer)| answer.is_satisfied),
            Self::Or => answers.clone().any(|(_, answer)| answer.is_satisfied),
            Self::Then => {
                let all = answers.clone().all(|(_, answer)| answer.is_satisfied);
                all && last.is_some_and(|(last, _)| self.behind(state, node, last).is_none())
            }
        }
    }

    /// What an OR or a THEN passes on of what those have said that it asked, in order; an AND lets its allocator say.
    pub(super) fn pass_on<'a>(self, answers: impl Answers<'a>, news: &mut News) -> Requests {
        match self {
            Self::And => Requests::default(),
            Self::Then => answers.last().map(|(_, answer)| answer.requests.clone()).unwrap_or_default(),
            Self::Or => choose(answers, news),
        }
    }

    /// Whether a node fails when one more of its children does.
    fn fails(self, state: &State, node: NodeId, failed: NodeId) -> bool {
        let mut others = state.topology().children(node).filter(|child| *child != failed);
        match self {
            Self::And | Self::Then => true,
            Self::Or => others.all(|child| state.phase(child) == Phase::Failed),
        }
    }

    /// What is complete when a child is, and who inherits.
    fn complete(self, state: &State, node: NodeId, child: Completion) -> Completion {
        let mut others = state.topology().children(node).filter(|other| *other != child.node);
        match self {
            Self::Or => Completion { node, heir: None },
            Self::And | Self::Then if others.all(|other| state.is_done(other)) => Completion { node, heir: None },
            Self::And => child,
            Self::Then => Completion { heir: Some(node), ..child },
        }
    }
}

/// Those that a node asked, in order, each with its answer.
pub(super) trait Answers<'a>: Iterator<Item = (NodeId, &'a Answer)> + Clone {}

impl<'a, T: Iterator<Item = (NodeId, &'a Answer)> + Clone> Answers<'a> for T {}

/// What the end of a behavior means for the nodes above it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settled {
    pub(super) consequences: Consequences,
    /// Where something fails: the leaf that it began with, which may have ended before this one.
    pub(super) cause: NodeId,
}

/// Follows the end of a behavior up the tree, in a state in which it still runs.
pub(super) fn settle(tree: &TreeSpec, state: &State, leaf: NodeId, end: End, is_final: bool) -> Settled {
    let mut completed = (end == End::Succeeded).then_some(Completion { node: leaf, heir: None });
    let (mut failed, mut failing, mut cause) = (is_final.then_some(leaf), None, leaf);
    let mut child = leaf;
    for node in tree.topology.path(leaf).skip(1) {
        let Some(ordering) = Ordering::of(&tree.nodes[node.index()]) else { break };
        let mut ends = match state.phase(node) {
            Phase::Failing(failing) => Some(failing),
            Phase::Pending | Phase::Done | Phase::Failed => None,
        };
        if failed == Some(child) && ends.is_none() && ordering.fails(state, node, child) {
            ends = Some(Failing { node, child, cause });
            failing = ends;
        }
        if let Some(complete) = completed.as_mut().filter(|completed| completed.node == child && ends.is_none()) {
            *complete = ordering.complete(state, node, *complete);
        }
        if let Some(ends) = ends
            && state.running_below(node).all(|(other, _)| other == leaf)
        {
            (failed, failing, cause) = (Some(node), None, ends.cause);
        }
        child = node;
    }
    Settled { consequences: Consequences { completed, failed, failing }, cause }
}

/// The ORs above a node whose chosen way has nothing done, nothing running and nothing held below it: a lapse has left
/// them with nothing, so they choose again.
pub(super) fn undecided(tree: &TreeSpec, state: &State, below: NodeId) -> Vec<NodeId> {
    let is_open = |node: &NodeId| {
        let way = state.status(*node).way;
        let is_or = Ordering::of(&tree.nodes[node.index()]) == Some(Ordering::Or);
        way.filter(|_| is_or).is_some_and(|way| is_left_with_nothing(state, way))
    };
    tree.topology.path(below).skip(1).filter(is_open).collect()
}

fn is_left_with_nothing(state: &State, way: NodeId) -> bool {
    let below = NodeRange { from: way, to: state.topology().end(way) };
    let is_done = || (below.from.0..below.to.0).any(|node| state.is_done(NodeId(node)));
    // A behavior may have kept two things: while one of them is left, what it was done for may still come.
    let is_holding = state.table().leases().any(|(_, lease)| {
        let is_kept = lease.kind == LeaseKind::Intention && below.contains(lease.behavior);
        is_kept || below.contains(lease.holder)
    });
    !is_holding && !state.is_busy(way) && !is_done()
}

/// An OR passes on its best child: the greatest potential, the first among equals.
fn choose<'a>(answers: impl Answers<'a>, news: &mut News) -> Requests {
    let potential = |answer: &Answer| answer.potential().unwrap_or(0.0);
    let satisfied = answers.clone().find(|(_, answer)| answer.is_satisfied);
    let asking = answers.clone().filter(|(_, answer)| !answer.requests.is_empty());
    let best = asking.max_by(|(a, one), (b, other)| potential(one).total_cmp(&potential(other)).then(b.cmp(a)));
    let Some((chosen, best)) = satisfied.or(best) else { return Requests::default() };
    let others = answers.filter(|(child, _)| *child != chosen).flat_map(|(_, answer)| answer.requests.iter());
    news.reasons.extend(others.map(|request| (request.leaf, Some(Reason::Alternative { chosen }))));
    best.requests.clone()
}
