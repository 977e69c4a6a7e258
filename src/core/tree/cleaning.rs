//! Cleanups: what is done where a node has failed or is given up, before that goes on (`semantics` 6, "Cleanup").

use super::ordering::{Ended, settle};
use super::{Outbox, Root, TOP};
use ambidex_model::state::Phase;
use ambidex_model::{Cause, NodeId, Reason, Record, Reopened, Time};

impl Root {
    /// Begins cleanups that are due and for which nothing has to end any more, the last in tree order first; ORs leave
    /// ways in which all is cleaned up.
    pub(super) fn begin_cleanups(&mut self, now: Time, out: &mut Outbox) {
        if self.state.topology().cleanups().is_empty() {
            return;
        }
        let cleanups = self.state.topology().cleanups().iter().rev();
        let nodes: Vec<NodeId> = cleanups.map(|cleanup| self.state.topology().parent(*cleanup)).collect();
        for node in nodes {
            if self.is_due(node) {
                self.is_wanted = true;
                self.edit(Record::Cleaning { at: now, node }, out);
            }
        }
        let is_ending = |way: &NodeId| self.state.phase(*way) == Phase::Ending;
        let chosen = self.ors.iter().filter_map(|or| Some((*or, self.state.status(*or).way.filter(is_ending)?)));
        for (or, way) in chosen.collect::<Vec<_>>() {
            if self.state.owed_cleanup(way, None).is_none() {
                self.is_wanted = true;
                self.edit(Record::Reopened { at: now, reopened: Reopened::new(way, or, Cause::Leave) }, out);
            }
        }
    }

    /// An OR leaves its way, at once or when what is to be cleaned up in it is.
    pub(super) fn leave_way(&mut self, now: Time, or: NodeId, way: NodeId, out: &mut Outbox) {
        self.is_wanted = true;
        match self.state.owed_cleanup(way, None) {
            Some(_) => self.edit(Record::Leaving { at: now, way }, out),
            None => self.edit(Record::Reopened { at: now, reopened: Reopened::new(way, or, Cause::Leave) }, out),
        }
    }

    /// A cleanup is over, since all of it is satisfied, or since nothing of it can be granted.
    pub(super) fn end_cleanup(&mut self, now: Time, node: NodeId, is_done: bool, out: &mut Outbox) {
        let settled = settle(&self.mission.tree, &self.state, node, Ended::Cleaned);
        self.is_wanted = true;
        let consequences = settled.consequences;
        self.edit(Record::Cleaned { at: now, node, is_done, consequences }, out);
        self.conclude(now, settled, out);
    }

    /// The first cleanup in tree order of which nothing is left to be done.
    pub(super) fn satisfied_cleanup(&self) -> Option<NodeId> {
        let is_satisfied = |node: &NodeId| {
            let cleanup = self.state.topology().children(*node).last();
            let is_met = |cleanup| self.reasons.get(&cleanup) == Some(&Reason::Satisfied);
            cleanup.is_some_and(|cleanup| is_met(cleanup) && !self.state.is_busy(cleanup))
        };
        self.state.cleaning().iter().copied().find(is_satisfied)
    }

    /// Whether a mission that is told to end has something to clean up still.
    pub(super) fn owes_cleanup(&self) -> bool {
        !self.is_grace_over() && self.state.owed_cleanup(TOP, None).is_some()
    }

    /// Whether all that the mission has for cleanups is used up.
    pub(super) fn is_grace_over(&self) -> bool {
        self.state.ending().is_some_and(|(_, until)| until <= self.turned)
    }

    /// Whether a cleanup is to be begun now.
    fn is_due(&self, node: NodeId) -> bool {
        let state = &self.state;
        // What is over above a node has seen to it.
        let is_left = |above: NodeId| !matches!(state.phase(above), Phase::Done | Phase::Failed);
        state.status(node).is_begun
            && !matches!(state.phase(node), Phase::Cleaning(_))
            && state.is_ending(node)
            && state.topology().path(node).all(is_left)
            && !state.is_busy(node)
            && state.owed_cleanup(node, Some(node)).is_none()
            && !self.is_grace_over()
            && !state.task_of(node).is_some_and(|task| self.is_out_of_grace(task))
    }
}
