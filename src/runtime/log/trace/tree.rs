//! Events of messages between nodes.

use tracing::{debug, trace};

use ambidex_model::{End, Message, Names, NodeId};

use super::TREE;
use ambidex_record::format;

/// Who tells whom, when.
pub(super) struct Edge {
    pub(super) at_s: f64,
    pub(super) round: u32,
    pub(super) from: NodeId,
    pub(super) to: NodeId,
}

/// An event whose first fields are those of the edge.
macro_rules! tell {
    ($level:ident, $edge:expr, $names:expr, $($rest:tt)+) => {
        $level!(
            target: TREE,
            round = $edge.round,
            from = $names.node($edge.from),
            to = $names.node($edge.to),
            at_s = $edge.at_s,
            $($rest)+
        )
    };
}

pub(super) fn sent(edge: &Edge, message: &Message, names: &Names) {
    match message {
        Message::Activation => tell!(trace, edge, names, "activation"),
        Message::Answer { .. } => answer(edge, message, names),
        Message::Verdict { granted, stopped } => tell!(
            trace,
            edge,
            names,
            granted = %format::nodes(granted.iter().copied(), names),
            stopped = (!stopped.is_empty()).then(|| display(format::nodes(stopped.iter().copied(), names))),
            "verdict"
        ),
        Message::Release { leaf, end } => release(edge, *leaf, *end, names),
    }
}

fn answer(edge: &Edge, message: &Message, names: &Names) {
    let Message::Answer { running, satisfied, potential, asking, request, blocked } = message else {
        return;
    };
    let says_no_itself = blocked.first().is_some_and(|one| one.leaf == edge.from);
    macro_rules! answer {
        ($level:ident) => {
            tell!(
                $level,
                edge,
                names,
                feasible = !asking.is_empty(),
                potential = *potential,
                running = *running,
                satisfied = *satisfied,
                asking = %format::nodes(asking.iter().copied(), names),
                claims = request.as_deref().map(|request| display(format::claims(request, names))),
                skips = request
                    .as_deref()
                    .filter(|request| !request.skips.is_empty())
                    .map(|request| display(format::skips(request, names))),
                reason = (!blocked.is_empty()).then(|| display(format::reasons(blocked, names))),
                "answer"
            )
        };
    }
    if request.is_some() || says_no_itself {
        answer!(debug);
    } else {
        answer!(trace);
    }
}

fn release(edge: &Edge, leaf: NodeId, end: End, names: &Names) {
    tell!(
        trace,
        edge,
        names,
        leaf = names.node(leaf),
        end = format::end(end),
        controller = format::at_fault(end, names),
        "release"
    );
}
