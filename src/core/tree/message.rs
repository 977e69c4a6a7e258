//! What nodes tell each other. Payloads lie behind pointers, so that a message is small.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;
use std::sync::Arc;

use crate::world::View;
use ambidex_model::state::State;
use ambidex_model::{Blocked, Grant, Message, NodeId, NodeRange, Outcome, Reason, Request, Topology};

/// From a parent to a child.
#[derive(Debug, Clone)]
pub enum Down {
    /// The state of resources and world: answer once.
    Activation(Activation),
    /// What came of the answer, and what is to end.
    Verdict(Arc<Verdict>),
}

/// From a child to its parent.
#[derive(Debug, Clone)]
pub enum Up {
    /// The one answer to an activation.
    Answer {
        /// The child that answers.
        from: NodeId,
        /// The round that is answered.
        round: u32,
        /// Shared with the node that says it: what is said again is the same pointer, and nothing is allocated.
        answer: Arc<Answer>,
        /// What is different since its last answer below it; none where nothing is.
        news: Option<Box<News>>,
    },
    /// A behavior ended.
    Release(Box<Release>),
}

/// What an activation carries.
#[derive(Debug, Clone)]
pub struct Activation {
    /// The snapshot of the round.
    pub view: Arc<View>,
    /// What was skipped on the way down.
    pub skips: Arc<Vec<NodeRange>>,
    /// Whom below it is for.
    pub scope: Scope,
}

/// Who below a node is asked in a round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// Those that might say something else than in the last round.
    Changed,
    /// Everybody; the answer tells what is different from the last round.
    All,
    /// Everybody, for the first time or after rounds without a question: the answer tells everything.
    Anew,
}

/// What a node says for everything below it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    /// Something below runs.
    pub is_running: bool,
    /// The goal is met.
    pub is_satisfied: bool,
    /// What is asked for; potential and line stand in each.
    pub requests: Requests,
    /// Why a leaf does not ask; none of a task node, nor of a leaf that asks or runs.
    pub reason: Option<Reason>,
    /// What a leaf would ask for without those that are less urgent or run; only of one that may come before others.
    pub wish: Option<Arc<Request>>,
}

/// Requests that go up together, shared by all that pass them on.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Requests {
    /// Nobody asks.
    #[default]
    None,
    /// As of a leaf: nothing is allocated beside the request.
    One(Arc<Request>),
    /// Best first.
    Several(Arc<[Arc<Request>]>),
}

/// What has become different below a node: first these ranges are not asked any more, then the leaves are told of.
#[derive(Debug, Clone, Default)]
pub struct News {
    /// Nodes that are asked no more.
    pub withdrawn: Vec<NodeRange>,
    /// Leaves that do not ask, or whose request went no further, each with its reason; without one, nothing keeps it
    /// from asking any more.
    pub reasons: Vec<(NodeId, Option<Reason>)>,
    /// Leaves whose wish is another one now.
    pub wishes: Vec<(NodeId, Option<Arc<Request>>)>,
    /// How many of `reasons` came from below; the others are this node's own word.
    pub passed_on: usize,
}

/// The end of a behavior on its way to root, the same on every edge.
#[derive(Debug, Clone)]
pub struct Release {
    /// The last round its leaf took part in.
    pub round: u32,
    /// The behavior that ended.
    pub leaf: NodeId,
    /// How it ended.
    pub outcome: Outcome,
}

/// What root decided in a round.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// The round that it ends, or the last one before it where it only stops.
    pub round: u32,
    /// What starts now.
    pub granted: BTreeMap<NodeId, Grant>,
    /// What runs and is to end.
    pub stopped: BTreeSet<NodeId>,
    /// The view in which it was decided; none where it only stops.
    pub view: Option<Arc<View>>,
    /// The tree that it goes down.
    pub topology: Arc<Topology>,
}

impl Verdict {
    /// What starts or is to end at or below a node.
    pub(super) fn about(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        let granted = self.topology.within(node, &self.granted).map(|(leaf, _)| leaf);
        granted.chain(self.topology.of_set(node, &self.stopped))
    }

    /// Nothing starts, and this ends.
    pub(super) fn stopping(state: &State, stopped: BTreeSet<NodeId>) -> Self {
        let (granted, topology) = (BTreeMap::new(), Arc::clone(state.topology()));
        Self { round: state.round(), granted, stopped, view: None, topology }
    }
}

impl Answer {
    /// Potential of the node: the greatest of what it asks for; none where nothing does (`semantics` 4).
    pub fn potential(&self) -> Option<f64> {
        self.requests.iter().map(|request| request.potential).max_by(f64::total_cmp)
    }
}

impl Requests {
    /// Whether both are the very same.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        std::iter::zip(self.iter(), other.iter()).all(|(one, other)| Arc::ptr_eq(one, other))
            && self.len() == other.len()
    }
}

impl FromIterator<Arc<Request>> for Requests {
    fn from_iter<T: IntoIterator<Item = Arc<Request>>>(requests: T) -> Self {
        let mut requests = requests.into_iter();
        match (requests.next(), requests.next()) {
            (Some(first), Some(second)) => Self::Several([first, second].into_iter().chain(requests).collect()),
            (Some(one), None) => Self::One(one),
            (None, _) => Self::None,
        }
    }
}

impl Deref for Requests {
    type Target = [Arc<Request>];

    fn deref(&self) -> &[Arc<Request>] {
        match self {
            Self::None => &[],
            Self::One(request) => std::slice::from_ref(request),
            Self::Several(requests) => requests,
        }
    }
}

impl News {
    /// Takes in what became different below a child.
    pub(super) fn absorb(&mut self, news: Self) {
        if self.withdrawn.is_empty() && self.reasons.is_empty() {
            (self.withdrawn, self.reasons) = (news.withdrawn, news.reasons);
            self.wishes.extend(news.wishes);
        } else {
            self.wishes.extend(news.wishes);
            self.withdrawn.extend(news.withdrawn);
            self.reasons.extend(news.reasons);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.withdrawn.is_empty() && self.reasons.is_empty() && self.wishes.is_empty()
    }
}

impl Down {
    /// The round it is said in.
    pub fn round(&self) -> u32 {
        match self {
            Self::Activation(activation) => activation.view.round,
            Self::Verdict(verdict) => verdict.round,
        }
    }

    /// The message as the journal shows it; `to` is the node that the edge leads to.
    pub fn record(&self, to: NodeId) -> Message {
        match self {
            Self::Activation(_) => Message::Activation,
            Self::Verdict(verdict) => Message::Verdict {
                granted: verdict.topology.within(to, &verdict.granted).map(|(leaf, _)| leaf).collect(),
                stopped: verdict.topology.of_set(to, &verdict.stopped).collect(),
            },
        }
    }
}

impl Up {
    /// The round it belongs to.
    pub fn round(&self) -> u32 {
        match self {
            Self::Answer { round, .. } => *round,
            Self::Release(release) => release.round,
        }
    }

    /// The message as the journal shows it.
    pub fn record(&self, from: NodeId) -> Message {
        match self {
            Self::Answer { answer, news, .. } => {
                let own = news.iter().flat_map(|news| &news.reasons[news.passed_on..]);
                let own = own.filter_map(|(leaf, reason)| Some((*leaf, reason.clone()?)));
                let of_leaf = answer.reason.clone().map(|reason| (from, reason));
                Message::Answer {
                    running: answer.is_running,
                    satisfied: answer.is_satisfied,
                    potential: answer.potential(),
                    asking: answer.requests.iter().map(|request| request.leaf).collect(),
                    request: answer.requests.iter().find(|request| request.leaf == from).cloned(),
                    blocked: of_leaf.into_iter().chain(own).map(|(leaf, reason)| Blocked { leaf, reason }).collect(),
                }
            }
            Self::Release(release) => Message::Release { leaf: release.leaf, end: release.outcome.end },
        }
    }
}
