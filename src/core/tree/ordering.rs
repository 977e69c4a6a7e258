//! What AND, OR and THEN differ in: whom they ask, what they pass on, when they are complete (III-A, III-C).

use std::sync::Arc;

use super::Answer;
use super::branch::{Branch, Child, Open};
use crate::world::View;
use ambidex_model::{Blocked, Completion, LeaseKind, NodeRange, Reason};

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
    /// Whom a round asks at once.
    pub(super) fn first(self, node: &mut Branch) -> Vec<usize> {
        node.committed = committed(node);
        let not_done = |child: &Child| !child.is_done;
        match self {
            Self::And => indices(&node.children, not_done).collect(),
            Self::Then => indices(&node.children, not_done).take(1).collect(),
            Self::Or => match node.committed {
                Some(child) => vec![child],
                None => indices(&node.children, |child| !child.has_failed).collect(),
            },
        }
    }

    /// Whom an answer makes it ask too: a THEN goes on behind a satisfied child, with it as skipped (III-C.2).
    pub(super) fn next(self, node: &Branch, answered: usize) -> Option<(usize, Arc<[NodeRange]>)> {
        match self {
            Self::And | Self::Or => None,
            Self::Then => {
                let open = node.open.as_ref()?;
                let is_satisfied = open.asked.get(&answered)?.as_ref()?.is_satisfied;
                let behind = node.children.iter().skip(answered + 1).position(|child| !child.is_done)?;
                let next = answered + 1 + behind;
                let first = *open.asked.keys().next()?;
                let skip = NodeRange { from: node.children[first].id, to: node.children[next].id };
                let above = open.activation.skips.iter().copied();
                (is_satisfied && !node.is_busy(&open.activation.view)).then(|| (next, above.chain([skip]).collect()))
            }
        }
    }

    /// What the node says when all it asked have answered.
    pub(super) fn answer(self, node: &Branch, view: &View, mut answers: Vec<(usize, Answer)>) -> Answer {
        let all = answers.iter().all(|(_, answer)| answer.is_satisfied);
        let is_satisfied = match self {
            Self::And => all,
            Self::Or => answers.iter().any(|(_, answer)| answer.is_satisfied),
            Self::Then => all && answers.last().is_some_and(|(last, _)| is_last_to_do(node, *last)),
        };
        let mut own = Answer { is_satisfied, ..Answer::default() };
        for (_, answer) in &mut answers {
            own.absorb(answer);
        }
        if node.is_busy(view) {
            own.is_satisfied = false;
            own.is_running = true;
        }
        own.passed_on = own.blocked.len();
        match self {
            Self::And => {
                let requests = answers.into_iter().flat_map(|(_, answer)| answer.requests).collect();
                let merged = node.allocator.merge(view, requests);
                own.requests = merged.kept;
                own.blocked.extend(merged.refused);
            }
            Self::Then => own.requests = answers.pop().map(|(_, answer)| answer.requests).unwrap_or_default(),
            Self::Or => choose(node, answers, &mut own),
        }
        own
    }

    /// What a grant below a child settles: behind a skip the skipped are done, an OR has chosen.
    pub(super) fn commit(self, node: &mut Branch, child: usize, open: &Open) {
        match self {
            Self::And => {}
            Self::Or => node.committed = Some(child),
            Self::Then => {
                for &skipped in open.asked.keys().filter(|&&asked| asked < child) {
                    node.children[skipped].is_done = true;
                }
            }
        }
    }

    /// Whether the node fails now that a child has; an OR is free again.
    pub(super) fn fails(self, node: &mut Branch) -> bool {
        match self {
            Self::And | Self::Then => true,
            Self::Or => {
                node.committed = None;
                node.children.iter().all(|child| child.has_failed)
            }
        }
    }

    /// What is complete when a child is, and who inherits.
    pub(super) fn complete(self, node: &Branch, child: Completion) -> Completion {
        let is_complete = node.children.iter().all(|child| child.is_done);
        match self {
            Self::And if !is_complete => child,
            Self::Then if !is_complete => Completion { heir: Some(node.id), ..child },
            Self::And | Self::Or | Self::Then => Completion { node: node.id, heir: None },
        }
    }
}

/// Whether every child behind this one is done.
fn is_last_to_do(node: &Branch, child: usize) -> bool {
    node.children[child + 1..].iter().all(|behind| behind.is_done)
}

/// The child an OR is committed to; after a lapse that leaves it with nothing done and nothing held, none.
fn committed(node: &Branch) -> Option<usize> {
    let child = node.committed?;
    let below = node.children[child].below;
    let view = &node.open.as_ref()?.activation.view;
    let is_done = node.done_below.range(below.from..below.to).next().is_some();
    let is_running = node.running.range(below.from..below.to).next().is_some();
    // A behavior may have kept two things: while one of them is left, what it was done for may still come.
    let is_holding = view.table.leases().any(|(_, lease)| {
        let is_kept = lease.kind == LeaseKind::Intention && below.contains(lease.behavior);
        is_kept || below.contains(lease.holder)
    });
    (!node.has_lapsed || is_done || is_running || is_holding).then_some(child)
}

/// An OR passes on its best child: the greatest potential, the first among equals.
fn choose(node: &Branch, answers: Vec<(usize, Answer)>, own: &mut Answer) {
    let potential = |answer: &Answer| answer.potential().unwrap_or(0.0);
    let satisfied = answers.iter().find(|(_, answer)| answer.is_satisfied).map(|(child, _)| *child);
    let best = answers
        .iter()
        .filter(|(_, answer)| !answer.requests.is_empty())
        .max_by(|(a, one), (b, other)| potential(one).total_cmp(&potential(other)).then(b.cmp(a)))
        .map(|(child, _)| *child);
    let best = satisfied.or(best);
    for (child, answer) in answers {
        if Some(child) == best {
            own.requests = answer.requests;
        } else if let Some(best) = best {
            let reason = Reason::Alternative { chosen: node.children[best].id };
            let others = answer.requests.iter();
            own.blocked.extend(others.map(|request| Blocked { leaf: request.leaf, reason: reason.clone() }));
        }
    }
}

fn indices(children: &[Child], is_wanted: impl Fn(&Child) -> bool) -> impl Iterator<Item = usize> {
    let wanted = children.iter().enumerate().filter(move |(_, child)| is_wanted(child));
    wanted.map(|(index, _)| index)
}
