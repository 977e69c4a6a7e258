//! The tree: what every node is now, and why what waits does.

use ambidex_model::{End, NodeId};
use ambidex_record::{History, LeafState};

use super::snapshot::NodeRow;
use crate::text::phrase::did_it;

/// Every node in tree order.
pub(crate) fn rows(history: &History) -> Vec<NodeRow> {
    history.nodes().filter_map(|node| row(history, node)).collect()
}

fn row(history: &History, node: NodeId) -> Option<NodeRow> {
    let entry = history.header().nodes.get(node.index())?;
    let (state, counts) = (history.state(node), history.counts(node));
    Some(NodeRow {
        id: node.0,
        name: history.names().node(node).to_owned(),
        kind: entry.kind.word().to_owned(),
        parent: (node.0 > 0).then_some(entry.parent.0),
        state,
        done: counts.done,
        of: counts.of,
        potential: history.potential(node),
        progress: history.controllers().progress(node).filter(|_| state == LeafState::Active),
        reason: reason(history, node, state),
    })
}

/// Why a leaf does not run: a reason that root told is newer than a fault, since a grant takes the reason away.
pub(crate) fn reason(history: &History, node: NodeId, state: LeafState) -> Option<String> {
    let names = history.names();
    if state == LeafState::NotNeeded {
        return history.instead_of(node).map(|way| did_it(way, names));
    }
    let leaf = history.leaf(node).filter(|_| state.is_open())?;
    let fault = match leaf.last_end() {
        Some(End::Failed(fault)) => Some(fault.sentence(names)),
        Some(End::Canceled) => Some("it was told to end".into()),
        Some(End::Interrupted) => Some("it was interrupted by no fault of its own".into()),
        Some(End::Succeeded) | None => None,
    };
    let was = if history.end().is_some() && state == LeafState::Waiting { "was waiting: " } else { "" };
    let told = || history.reason(node).map(|reason| format!("{was}{}", reason.sentence(names)));
    match state {
        LeafState::Waiting if leaf.reason().is_some() => told(),
        LeafState::Waiting | LeafState::Failed | LeafState::Canceled | LeafState::NotAsked => fault.or_else(told),
        LeafState::Active | LeafState::Done | LeafState::Skipped | LeafState::NotNeeded => None,
    }
}
