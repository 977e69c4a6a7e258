//! AND, OR, THEN and cleanups: whom they ask, what they pass on, and what the end of a child means for them (III-A, III-C). No
//! other file tells them apart.

use super::{Answer, News, Requests};
use ambidex_model::state::{GoesOn, Phase, State};
use ambidex_model::{Completion, Consequences, Failing, Fault, LeaseKind, NodeId, NodeKind, Reason, TreeSpec};

/// The ordering constraint of a task node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ordering {
    /// All children, in any order.
    And,
    /// One child.
    Or,
    /// All children, in order.
    Then,
    /// The first; the second where that fails or is given up.
    Cleanup,
}

impl Ordering {
    /// That of a node; none of root and of behaviors.
    pub(super) fn of(kind: &NodeKind) -> Option<Self> {
        match kind {
            NodeKind::And | NodeKind::Tasks => Some(Self::And),
            NodeKind::Or => Some(Self::Or),
            NodeKind::Then => Some(Self::Then),
            NodeKind::Cleanup => Some(Self::Cleanup),
            NodeKind::Root | NodeKind::Behavior(_) => None,
        }
    }

    /// Whom a round asks at once.
    pub(super) fn first(self, state: &State, node: NodeId) -> impl Iterator<Item = NodeId> {
        let way = state.status(node).way;
        let is_cleaning = matches!(state.phase(node), Phase::Cleaning(_));
        let is_open = move |child: &NodeId| match self {
            Self::Cleanup => state.topology().is_cleanup(*child) == is_cleaning,
            Self::And | Self::Then => !matches!(state.phase(*child), Phase::Done | Phase::Failed),
            Self::Or => way.map_or(state.phase(*child) != Phase::Failed, |way| way == *child),
        };
        let most = if self == Self::Then { 1 } else { usize::MAX };
        state.topology().children(node).filter(is_open).take(most)
    }

    /// Whom a THEN asks behind a child that is satisfied, in the same round (III-C.2).
    pub(super) fn behind(self, state: &State, node: NodeId, satisfied: NodeId) -> Option<NodeId> {
        match self {
            Self::And | Self::Or | Self::Cleanup => None,
            Self::Then if state.is_busy(node) => None,
            Self::Then => {
                let mut later = state.topology().children(node).skip_while(|child| *child != satisfied).skip(1);
                later.find(|child| !state.is_done(*child)).filter(|next| state.phase(*next) != Phase::Failed)
            }
        }
    }

    /// Whether an OR or a THEN is satisfied when all that it asked, in order, have answered and nothing below runs.
    pub(super) fn is_satisfied<'a>(self, state: &State, node: NodeId, answers: impl Answers<'a>) -> bool {
        let last = answers.clone().last();
        match self {
            Self::And | Self::Cleanup => answers.clone().all(|(_, answer)| answer.is_satisfied),
            Self::Or => answers.clone().any(|(_, answer)| answer.is_satisfied),
            Self::Then => {
                let all = answers.clone().all(|(_, answer)| answer.is_satisfied);
                all && last.is_none_or(|(last, _)| self.behind(state, node, last).is_none())
            }
        }
    }

    /// What an OR or a THEN passes on of what those have said that it asked, in order; an AND lets its allocator say.
    pub(super) fn pass_on<'a>(self, answers: impl Answers<'a>, news: &mut News) -> Requests {
        match self {
            Self::And => Requests::default(),
            Self::Then | Self::Cleanup => answers.last().map(|(_, answer)| answer.requests.clone()).unwrap_or_default(),
            Self::Or => choose(answers, news),
        }
    }

    /// Whether a node fails when one more of its children does.
    fn fails(self, state: &State, node: NodeId, failed: NodeId) -> bool {
        let mut others = state.topology().children(node).filter(|child| *child != failed);
        match self {
            Self::And | Self::Then | Self::Cleanup => true,
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
            Self::Cleanup => phases.next() == Some(Phase::Failed),
            Self::Then => phases.find(|phase| *phase != Phase::Done).is_none_or(|phase| phase == Phase::Failed),
        }
    }

    /// What is complete when a child is, and who inherits.
    fn complete(self, state: &State, node: NodeId, child: Completion) -> Completion {
        let mut others = state.topology().children(node).filter(|other| *other != child.node);
        match self {
            Self::Or | Self::Cleanup => Completion { node, heir: None },
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
    /// The cleanup of a node is over, without the end of a behavior.
    Cleaned,
}

/// What an end means for the nodes above it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settled {
    pub(super) consequences: Consequences,
    /// Where something fails: the node that it began with, which may have ended before this one.
    pub(super) cause: NodeId,
    /// A node above whose attempt failed and that has another one, with the fault.
    pub(super) retried: Option<(NodeId, Fault)>,
    /// A node that is complete and is done once more.
    pub(super) repeated: Option<NodeId>,
}

/// Follows an end up the tree; what ended may still run in the state.
pub(super) fn settle(tree: &TreeSpec, state: &State, from: NodeId, ended: Ended) -> Settled {
    let failed = match ended {
        Ended::Failed(fault) => Some((from, fault)),
        Ended::Succeeded | Ended::Again | Ended::OutOfTime | Ended::Cleaned => None,
    };
    let mut settling = Settling {
        tree,
        state,
        from,
        ended,
        completed: (ended == Ended::Succeeded).then_some(Completion { node: from, heir: None }),
        failed: failed.map(|(node, _)| node),
        fault: failed.and_then(|(_, fault)| fault),
        failing: None,
        cleaned: None,
        cause: from,
        retried: None,
        repeated: None,
    };
    let is_own = matches!(ended, Ended::OutOfTime | Ended::Cleaned);
    if ended == Ended::Succeeded && goes_on(tree, state, from) && !state.is_over(from) {
        settling.repeated = Some(from);
    } else {
        let mut child = from;
        for node in tree.topology.path(from).skip(usize::from(!is_own)) {
            if !settling.climb(node, child) {
                break;
            }
            child = node;
        }
    }
    let Settling { completed, failed, failing, cleaned, cause, retried, repeated, .. } = settling;
    Settled { consequences: Consequences { completed, failed, failing, cleaned }, cause, retried, repeated }
}

/// An end on its way up.
struct Settling<'a> {
    tree: &'a TreeSpec,
    state: &'a State,
    from: NodeId,
    ended: Ended,
    completed: Option<Completion>,
    failed: Option<NodeId>,
    fault: Option<Fault>,
    failing: Option<Failing>,
    cleaned: Option<NodeId>,
    cause: NodeId,
    retried: Option<(NodeId, Fault)>,
    repeated: Option<NodeId>,
}

impl Settling<'_> {
    /// What it means for a node above; false where it means nothing for those above that.
    fn climb(&mut self, node: NodeId, child: NodeId) -> bool {
        let (tree, state) = (self.tree, self.state);
        // Tasks are nothing to each other.
        let ordering = Ordering::of(&tree.nodes[node.index()]).filter(|_| node > tree.topology.stem());
        let Some(ordering) = ordering else { return false };
        if let Phase::Cleaning(goes_on) = state.phase(node) {
            return self.clean(node, child, goes_on);
        }
        let ends = self.ends(node, child, ordering);
        let mut is_repeated = false;
        if let Some(complete) = self.completed.as_mut().filter(|completed| completed.node == child) {
            let next = match ends {
                None => ordering.complete(state, node, *complete),
                // It goes on as far as it can.
                Some(ends) if ends.finishes && ordering == Ordering::Then => {
                    Completion { heir: Some(node), ..*complete }
                }
                Some(_) => *complete,
            };
            is_repeated = next.node == node && goes_on(tree, state, node);
            if !is_repeated || !state.is_over(node) {
                *complete = next;
            }
        }
        if is_repeated && !state.is_over(node) {
            self.repeated = Some(node);
            return false;
        }
        let now = match (self.failed == Some(child), self.completed.is_some_and(|completed| completed.node == child)) {
            (true, _) => Some((child, Phase::Failed)),
            (false, true) => Some((child, Phase::Done)),
            (false, false) => None,
        };
        if let Some(ends) = ends
            && state.running_below(node).all(|(other, _)| other == self.from)
            && state.owed_cleanups(node, self.cleaned).all(|owed| self.completes(owed))
            && (!ends.finishes || ordering.is_finished(state, node, now))
        {
            (self.failing, self.cause, self.fault) = (None, ends.cause, ends.fault);
            let is_given_up = state.is_over(tree.topology.parent(node));
            if let Some(fault) = ends.fault.filter(|_| has_attempts(tree, state, node) && !is_given_up) {
                self.retried = Some((node, fault));
                return false;
            }
            self.failed = Some(node);
        }
        true
    }

    /// Whether a node is complete now, or below what is: nothing is to be cleaned up there.
    fn completes(&self, node: NodeId) -> bool {
        self.completed.is_some_and(|completed| self.tree.topology.is_within(node, completed.node))
    }

    /// Why a node cannot be complete any more; none while it can.
    fn ends(&mut self, node: NodeId, child: NodeId, ordering: Ordering) -> Option<Failing> {
        let (tree, state) = (self.tree, self.state);
        let before = match state.phase(node) {
            Phase::Failing(failing) => Some(failing),
            // What is given up stays so until all there is cleaned up.
            Phase::Ending => return None,
            Phase::Pending | Phase::Done | Phase::Failed | Phase::Cleaning(_) => None,
        };
        if self.ended == Ended::OutOfTime && node == self.from {
            // What cannot be complete any more has failed already, and at something else.
            let cause = before.map_or(node, |ends| ends.cause);
            self.failing = Some(Failing { node, child: node, cause, fault: Some(Fault::TimedOut), finishes: false });
            self.failing
        } else if self.failed == Some(child)
            && before.is_none_or(|before| before.finishes && ordering == Ordering::Cleanup)
            && ordering.fails(state, node, child)
        {
            // A body that did what it could has failed for good now.
            let (cause, fault) = before.map_or((self.cause, self.fault), |before| (before.cause, before.fault));
            let goes_on = !state.is_over(node) && !can_recover(tree, state, node, fault);
            let finishes = ordering == Ordering::And && goes_on;
            self.failing = Some(Failing { node, child, cause, fault, finishes });
            self.failing
        } else {
            before
        }
    }

    /// Something below a cleanup ended: with the cleanup itself its node goes on to what it was given up for.
    fn clean(&mut self, node: NodeId, child: NodeId, goes_on: GoesOn) -> bool {
        let is_completed = self.completed.is_some_and(|completed| completed.node == child);
        let is_told = self.ended == Ended::Cleaned && node == self.from;
        if !is_completed && !is_told && self.failed != Some(child) {
            return false;
        }
        self.cleaned = Some(node);
        self.failing = None;
        (self.failed, self.fault) = (None, None);
        if let GoesOn::Failing(failing) = goes_on {
            (self.failed, self.fault, self.cause) = (Some(node), failing.fault, failing.cause);
        }
        true
    }
}

/// Whether a node that is complete now is done once more.
fn goes_on(tree: &TreeSpec, state: &State, node: NodeId) -> bool {
    tree.repeats.get(&node).is_some_and(|repeat| repeat.goes_on(state.iterations(node) + 1))
}

/// Whether a node is done more than this once.
pub(super) fn is_repeated(tree: &TreeSpec, state: &State, node: NodeId) -> bool {
    !tree.repeats.is_empty() && goes_on(tree, state, node)
}

/// Whether a node may be tried again after it failed, and could be complete then.
fn has_attempts(tree: &TreeSpec, state: &State, node: NodeId) -> bool {
    tree.limits(node).retries > state.status(node).failures && !is_never(tree, state, node)
}

/// Whether a node cannot be complete since behaviors below it can never run.
pub(super) fn is_never(tree: &TreeSpec, state: &State, node: NodeId) -> bool {
    if state.topology().within(node, state.infeasible()).next().is_none() {
        return false;
    }
    let mut children = state.topology().children(node);
    match Ordering::of(&tree.nodes[node.index()]) {
        None => true,
        Some(Ordering::And | Ordering::Then | Ordering::Cleanup) => children.any(|child| is_never(tree, state, child)),
        Some(Ordering::Or) => children.all(|child| is_never(tree, state, child)),
    }
}

/// Whether what is canceled below a node will be tried again with it or with something above it.
pub(super) fn begins_again(tree: &TreeSpec, state: &State, failing: Failing) -> bool {
    let mut above = tree.topology.path(failing.node).take_while(|node| *node > tree.topology.stem());
    failing.fault.is_some() && above.any(|node| has_attempts(tree, state, node))
}

/// Whether a node that fails, or something above it, can be tried again or choose another way. What never can run is
/// not tried again.
fn can_recover(tree: &TreeSpec, state: &State, failing: NodeId, fault: Option<Fault>) -> bool {
    let mut child = failing;
    for node in tree.topology.path(failing).take_while(|node| *node > tree.topology.stem()) {
        // What a cleanup comes to is nothing to those above.
        if node != child && tree.topology.is_cleanup(child) {
            return false;
        }
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
    let topology = state.topology();
    let is_done = || topology.nodes_below(way).any(|node| state.is_done(node));
    // A behavior may have kept two things: while one of them is left, what it was done for may still come.
    let is_holding = state.table().leases().any(|(_, lease)| {
        let is_kept = lease.kind == LeaseKind::Intention && topology.is_within(lease.behavior, way);
        is_kept || topology.is_within(lease.holder, way)
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
