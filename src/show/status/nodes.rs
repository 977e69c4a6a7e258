//! The tree: what every node is now, and why what waits does.

use std::collections::BTreeMap;

use crate::course::Course;
use crate::why::NotAsked;
use crate::{LeafState, fault_sentence, last_reasons};
use ambidex_model::{ControllerId, End, Header, Mode, NodeEntry, NodeId};

use super::Status;
use super::snapshot::NodeRow;

/// What is below a node, itself included.
#[derive(Debug, Clone, Copy, Default)]
struct Below {
    of: usize,
    done: usize,
    skipped: usize,
    active: usize,
    canceled: usize,
}

impl Status {
    pub(super) fn nodes(&self, header: &Header) -> Vec<NodeRow> {
        let course = Course::new(&self.tally);
        let not_asked = NotAsked::new(header, |leaf| course.standing(leaf));
        let reasons: BTreeMap<_, _> = last_reasons(&self.tally).into_iter().collect();
        let progress = self.progress(header);
        // None of an inner node.
        let is_leaf = |node: &NodeId| header.nodes[node.index()].kind.is_behavior();
        let nodes = (0..header.nodes.len()).map(NodeId::from);
        let states: Vec<_> = nodes.map(|node| Some(node).filter(is_leaf).map(|leaf| course.state(leaf))).collect();
        let below = below(header, &states);
        let row = |(index, entry): (usize, &NodeEntry)| {
            let node = NodeId::from(index);
            let state = match states[index] {
                Some(state) => state,
                None => self.inner_state(node, below[index], not_asked.is_done(node)),
            };
            let reason = || reasons.get(&node)?.as_ref().map(|reason| reason.sentence(&header.names));
            let fault = || self.fault(node, header, &course);
            let reason = match state {
                LeafState::Active | LeafState::Done | LeafState::Skipped => None,
                // A reason that root told is newer than a fault: a grant takes the reason away.
                LeafState::Waiting if self.tally.reasons.contains_key(&node) => reason(),
                LeafState::Waiting | LeafState::Failed | LeafState::Canceled => fault().or_else(reason),
            };
            NodeRow {
                id: node.0,
                name: header.names.node(node).to_owned(),
                kind: entry.kind.word().to_owned(),
                parent: (index > 0).then_some(entry.parent.0),
                state,
                done: below[index].done,
                of: below[index].of,
                potential: self.potentials.get(index).copied().flatten(),
                progress: progress.get(&node).copied().filter(|_| state == LeafState::Active),
                reason,
            }
        };
        header.nodes.iter().enumerate().map(row).collect()
    }

    fn inner_state(&self, node: NodeId, below: Below, is_done: bool) -> LeafState {
        let is_over = self.tally.end.is_some();
        if self.failed.contains(&node) {
            return LeafState::Failed;
        }
        match below {
            Below { active: 1.., .. } => LeafState::Active,
            Below { of: 1.., done, skipped, .. } if is_done && done == skipped => LeafState::Skipped,
            Below { of: 1.., .. } if is_done => LeafState::Done,
            Below { canceled: 1.., .. } if is_over => LeafState::Canceled,
            Below { .. } => LeafState::Waiting,
        }
    }

    /// At what a leaf ended when it ran last.
    fn fault(&self, leaf: NodeId, header: &Header, course: &Course) -> Option<String> {
        match course.runs(leaf).last()?.end? {
            End::Failed(fault) => Some(fault_sentence(fault, &header.names)),
            End::Canceled => Some("it was told to end".into()),
            End::Succeeded => None,
        }
    }

    /// How far each running leaf is: the least of the commands that end it.
    fn progress(&self, header: &Header) -> BTreeMap<NodeId, f64> {
        let controllers = (0..header.names.controllers.len()).map(ControllerId::from);
        let commands =
            controllers.flat_map(|id| self.crew.commands(id)).filter(|command| command.mode == Mode::Achieve);
        let mut least = BTreeMap::new();
        for (leaf, progress) in commands.flat_map(|command| command.leaves.iter().map(|&leaf| (leaf, command.progress)))
        {
            let known = least.entry(leaf).or_insert(progress);
            *known = progress.min(*known);
        }
        least
    }
}

/// Sums over every node's leaves; children stand behind their parents.
fn below(header: &Header, states: &[Option<LeafState>]) -> Vec<Below> {
    let mut below = vec![Below::default(); states.len()];
    for (index, state) in states.iter().enumerate().rev() {
        if let Some(state) = state {
            let is = |wanted: LeafState| usize::from(*state == wanted);
            let skipped = is(LeafState::Skipped);
            below[index] = Below {
                of: 1,
                done: is(LeafState::Done) + skipped,
                skipped,
                active: is(LeafState::Active),
                canceled: is(LeafState::Canceled),
            };
        }
        let parent = header.nodes[index].parent.index();
        if parent < index {
            let own = below[index];
            let sum = &mut below[parent];
            sum.of += own.of;
            sum.done += own.done;
            sum.skipped += own.skipped;
            sum.active += own.active;
            sum.canceled += own.canceled;
        }
    }
    below
}
