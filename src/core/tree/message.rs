//! What nodes tell each other. Payloads lie behind pointers, so that a message is small.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::world::View;
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
    Answer(Box<Answer>),
    /// A behavior ended.
    Release(Box<Release>),
}

/// What an activation carries.
#[derive(Debug, Clone)]
pub struct Activation {
    /// The snapshot of the round.
    pub view: Arc<View>,
    /// What was skipped on the way down.
    pub skips: Arc<[NodeRange]>,
}

/// The answer of a node for everything below it.
#[derive(Debug, Clone, Default)]
pub struct Answer {
    /// The round that is answered.
    pub round: u32,
    /// Something below runs.
    pub is_running: bool,
    /// The goal is met.
    pub is_satisfied: bool,
    /// What is asked for; potential and line stand in each.
    pub requests: Vec<Arc<Request>>,
    /// Activated leaves that do not ask, or whose request went no further, each with its reason.
    pub blocked: Vec<Blocked>,
    /// How many of `blocked` came from below; the others are this node's own word.
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
#[derive(Debug, Clone, Default)]
pub struct Verdict {
    /// The round that it ends, or the last one before it where it only stops.
    pub round: u32,
    /// What starts now.
    pub granted: BTreeMap<NodeId, Grant>,
    /// Why every other activated leaf does not.
    pub refused: BTreeMap<NodeId, Reason>,
    /// What runs and is to end.
    pub stopped: BTreeSet<NodeId>,
    /// The view in which it was decided; none where it only stops.
    pub view: Option<Arc<View>>,
}

impl Verdict {
    /// What starts or is to end at or below a node.
    pub(super) fn about(&self, topology: &Topology, node: NodeId) -> impl Iterator<Item = NodeId> {
        let below = node..topology.end(node);
        let granted = self.granted.range(below.clone()).map(|(&leaf, _)| leaf);
        granted.chain(self.stopped.range(below).copied())
    }
}

impl Answer {
    /// Potential of the node: the greatest of what it asks for; none where nothing does (`semantics` 4).
    pub fn potential(&self) -> Option<f64> {
        self.requests.iter().map(|request| request.potential).max_by(f64::total_cmp)
    }

    /// Takes in what a child said of its leaves, but not its requests.
    pub(super) fn absorb(&mut self, child: &Self) {
        self.is_running |= child.is_running;
        self.blocked.extend_from_slice(&child.blocked);
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

    /// The message as the journal shows it; `below` is the run of nodes that the edge leads to.
    pub fn record(&self, below: NodeRange) -> Message {
        match self {
            Self::Activation(_) => Message::Activation,
            Self::Verdict(verdict) => Message::Verdict {
                granted: verdict.granted.range(below.from..below.to).map(|(&leaf, _)| leaf).collect(),
                refused: verdict.refused.get(&below.from).cloned(),
                stopped: verdict.stopped.range(below.from..below.to).copied().collect(),
            },
        }
    }
}

impl Up {
    /// The round it belongs to.
    pub fn round(&self) -> u32 {
        match self {
            Self::Answer(answer) => answer.round,
            Self::Release(release) => release.round,
        }
    }

    /// The message as the journal shows it.
    pub fn record(&self, from: NodeId) -> Message {
        match self {
            Self::Answer(answer) => Message::Answer {
                running: answer.is_running,
                satisfied: answer.is_satisfied,
                potential: answer.potential(),
                asking: answer.requests.iter().map(|request| request.leaf).collect(),
                request: answer.requests.iter().find(|request| request.leaf == from).cloned(),
                blocked: answer.blocked[answer.passed_on..].to_vec(),
            },
            Self::Release(release) => Message::Release { leaf: release.leaf, end: release.outcome.end },
        }
    }
}
