//! AND, OR and THEN: whom they ask, what they pass on, and what the end of a child means for them (III-A, III-C). No
//! other file tells them apart.

use super::{Answer, News, Requests};
use ambidex_model::state::{Phase, State};
use ambidex_model::{
    Completion, Consequences, Failing, Fault, LeaseKind, NodeId, NodeKind, NodeRange, Reason, TreeSpec,
};

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
            Self::And | Self::Then => !matches!(state.phase(*child), Phase::Done | Phase::Failed),
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
            Self::Then => {
                let mut later = state.topology().children(node).filter(|child| *child > satisfied);
                later.find(|child| !state.is_done(*child)).filter(|next| state.phase(*next) != Phase::Failed)
            }
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

    /// Whether nothing is left to be finished of a node that cannot be complete any more; `now` is how a child of it ends
    /// now.
    fn is_finished(self, state: &State, node: NodeId, now: Option<(NodeId, Phase)>) -> bool {
        let phase = |child: NodeId| match now.filter(|(other, _)| *other == child) {
            Some((_, phase)) => phase,
            None => state.phase(child),
        };
        let mut phases = state.topology().children(node).map(phase);
        match self {
            Self::And => phases.all(|phase| matches!(phase, Phase::Done | Phase::Failed)),
            Self::Or => phases.all(|phase| phase == Phase::Failed),
            Self::Then => phases.find(|phase| *phase != Phase::Done).is_none_or(|phase| phase == Phase::Failed),
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

/// How something ended, for the nodes above it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ended {
    /// A behavior succeeded.
    Succeeded,
    /// A behavior ended otherwise, and will ask again.
    Again,
    /// A behavior has failed for good; without a fault it never could run.
    Failed(Option<Fault>),
    /// A task node took too long.
    OutOfTime,
}

/// What an end means for the nodes above it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settled {
    pub(super) consequences: Consequences,
    /// Where something fails: the node that it began with, which may have ended before this one.
    pub(super) cause: NodeId,
    /// A node above whose attempt failed and that has another one, with the fault.
    pub(super) retried: Option<(NodeId, Fault)>,
}

/// Follows an end up the tree; what ended may still run in the state.
pub(super) fn settle(tree: &TreeSpec, state: &State, from: NodeId, ended: Ended) -> Settled {
    let mut completed = (ended == Ended::Succeeded).then_some(Completion { node: from, heir: None });
    let (mut failed, mut fault) = match ended {
        Ended::Failed(fault) => (Some(from), fault),
        Ended::Succeeded | Ended::Again | Ended::OutOfTime => (None, None),
    };
    let (mut failing, mut cause, mut retried) = (None, from, None);
    let mut child = from;
    for node in tree.topology.path(from).skip(usize::from(ended != Ended::OutOfTime)) {
        let Some(ordering) = Ordering::of(&tree.nodes[node.index()]) else { break };
        let mut ends = match state.phase(node) {
            Phase::Failing(failing) => Some(failing),
            Phase::Pending | Phase::Done | Phase::Failed => None,
        };
        if ended == Ended::OutOfTime && node == from {
            // What cannot be complete any more has failed already, and at something else.
            let (cause, fault) = (ends.map_or(node, |ends| ends.cause), Some(Fault::TimedOut));
            ends = Some(Failing { node, child: node, cause, fault, finishes: false });
            failing = ends;
        } else if failed == Some(child) && ends.is_none() && ordering.fails(state, node, child) {
            let finishes = ordering == Ordering::And && !can_recover(tree, state, node, fault);
            ends = Some(Failing { node, child, cause, fault, finishes });
            failing = ends;
        }
        if let Some(complete) = completed.as_mut().filter(|completed| completed.node == child) {
            *complete = match ends {
                None => ordering.complete(state, node, *complete),
                // It goes on as far as it can.
                Some(ends) if ends.finishes && ordering == Ordering::Then => {
                    Completion { heir: Some(node), ..*complete }
                }
                Some(_) => *complete,
            };
        }
        let now = match (failed == Some(child), completed.is_some_and(|completed| completed.node == child)) {
            (true, _) => Some((child, Phase::Failed)),
            (false, true) => Some((child, Phase::Done)),
            (false, false) => None,
        };
        if let Some(ends) = ends
            && state.running_below(node).all(|(other, _)| other == from)
            && (!ends.finishes || ordering.is_finished(state, node, now))
        {
            (failing, cause, fault) = (None, ends.cause, ends.fault);
            let is_given_up = state.is_over(tree.topology.parent(node));
            if let Some(fault) = fault.filter(|_| has_attempts(tree, state, node) && !is_given_up) {
                retried = Some((node, fault));
                break;
            }
            failed = Some(node);
        }
        child = node;
    }
    Settled { consequences: Consequences { completed, failed, failing }, cause, retried }
}

/// Whether a node may be tried again after it failed, and could be complete then.
fn has_attempts(tree: &TreeSpec, state: &State, node: NodeId) -> bool {
    tree.limits(node).retries > state.status(node).failures && !is_never(tree, state, node)
}

/// Whether a node cannot be complete since behaviors below it can never run.
pub(super) fn is_never(tree: &TreeSpec, state: &State, node: NodeId) -> bool {
    let below = node..state.topology().end(node);
    if state.infeasible().range(below).next().is_none() {
        return false;
    }
    let mut children = state.topology().children(node);
    match Ordering::of(&tree.nodes[node.index()]) {
        None => true,
        Some(Ordering::And | Ordering::Then) => children.any(|child| is_never(tree, state, child)),
        Some(Ordering::Or) => children.all(|child| is_never(tree, state, child)),
    }
}

/// Whether what is canceled below a node will be tried again with it or with something above it.
pub(super) fn begins_again(tree: &TreeSpec, state: &State, failing: Failing) -> bool {
    let mut above = tree.topology.path(failing.node).take_while(|node| node.0 > 0);
    failing.fault.is_some() && above.any(|node| has_attempts(tree, state, node))
}

/// Whether a node that fails, or something above it, can be tried again or choose another way. What never can run is
/// not tried again.
fn can_recover(tree: &TreeSpec, state: &State, failing: NodeId, fault: Option<Fault>) -> bool {
    let mut child = failing;
    for node in tree.topology.path(failing).take_while(|node| node.0 > 0) {
        if let Phase::Failing(above) = state.phase(node) {
            return !above.finishes;
        }
        let is_other_way = |way: NodeId| way != child && state.phase(way) != Phase::Failed;
        let is_or = node != failing && Ordering::of(&tree.nodes[node.index()]) == Some(Ordering::Or);
        let has_way = is_or && state.topology().children(node).any(is_other_way);
        if has_way || fault.is_some() && has_attempts(tree, state, node) {
            return true;
        }
        child = node;
    }
    false
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
