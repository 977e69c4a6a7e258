//! Work that repeats: what is complete begins anew (`semantics` 6, "Work that repeats").

use super::ordering::is_repeated;
use super::{Outbox, Root, Verdict};
use ambidex_model::{Cause, NodeId, Reason, Record, Reopened, Time};

impl Root {
    /// A node that is complete is done once more, when its time comes.
    pub(super) fn repeat(&mut self, now: Time, node: NodeId, out: &mut Outbox) {
        let tree = &self.mission.tree;
        let began = self.began.remove(&node).unwrap_or(self.turned);
        let every = tree.repeats.get(&node).and_then(|repeat| repeat.every);
        let until = every.map(|every| began + every).filter(|until| *until > self.turned);
        let topology = &tree.topology;
        self.began.retain(|begun, _| !topology.is_within(*begun, node));
        // What is late is not made up for.
        self.began.extend(every.map(|_| (node, until.unwrap_or(self.turned))));
        let reset = topology.nodes_below(node).collect();
        let reopened = Reopened { reset, ..Reopened::new(node, node, Cause::Repeat { since: self.turned, until }) };
        self.is_wanted = true;
        self.edit(Record::Reopened { at: now, reopened }, out);
    }

    /// A cleanup that is over is as before it was begun, and so is what repeats in it.
    pub(super) fn forget_cleaned(&mut self, record: &Record) {
        let (Record::Released { consequences, .. } | Record::Cleaned { consequences, .. }) = record else { return };
        let Some(node) = consequences.cleaned.filter(|_| !self.began.is_empty()) else { return };
        let topology = self.state.topology();
        let Some(cleanup) = topology.children(node).last() else { return };
        self.began.retain(|begun, _| !topology.is_within(*begun, cleanup));
    }

    /// The first time of a node begins with the first grant below it.
    pub(super) fn note_begun(&mut self, verdict: &Verdict) {
        let tree = &self.mission.tree;
        if tree.repeats.is_empty() {
            return;
        }
        for node in verdict.granted.keys().flat_map(|leaf| tree.topology.path(*leaf)) {
            if tree.repeats.get(&node).is_some_and(|repeat| repeat.every.is_some()) {
                self.began.entry(node).or_insert(self.turned);
            }
        }
    }

    /// Where all of a node that is done more than once is satisfied, that was one time; where all of a cleanup is, it is
    /// over. The first in tree order, one in a round.
    pub(super) fn end_satisfied(&mut self, now: Time, out: &mut Outbox) {
        if self.is_over() {
            return;
        }
        let tree = &self.mission.tree;
        let is_satisfied = |node: &NodeId| {
            self.reasons.get(node) == Some(&Reason::Satisfied)
                && is_repeated(tree, &self.state, *node)
                && !self.state.is_busy(*node)
                && !self.state.is_over(*node)
        };
        let repeated = tree.repeats.keys().copied().find(is_satisfied);
        match (repeated, self.satisfied_cleanup()) {
            (Some(node), _) => self.repeat(now, node, out),
            (None, Some(node)) => self.end_cleanup(now, node, true, out),
            (None, None) => {}
        }
    }
}
