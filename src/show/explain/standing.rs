//! What every leaf is at a moment of the journal.

use std::collections::{BTreeMap, BTreeSet};

use crate::LeafState;
use crate::why::NotAsked;
use ambidex_model::{End, Grant, Header, MissionEnd, NodeId, Reason, Record, Time};

/// The leaves' states, kept from record to record.
#[derive(Debug, Clone)]
pub(super) struct Standing {
    header: Header,
    states: BTreeMap<NodeId, LeafState>,
    started: BTreeMap<NodeId, Time>,
    begun: BTreeSet<NodeId>,
    met: BTreeSet<NodeId>,
}

impl Standing {
    pub(super) fn new(header: &Header) -> Self {
        Self {
            header: header.clone(),
            states: BTreeMap::new(),
            started: BTreeMap::new(),
            begun: BTreeSet::new(),
            met: BTreeSet::new(),
        }
    }

    pub(super) fn header(&self) -> &Header {
        &self.header
    }

    pub(super) fn state(&self, leaf: NodeId) -> LeafState {
        self.states.get(&leaf).copied().unwrap_or(LeafState::Waiting)
    }

    pub(super) fn is_done(&self, leaf: NodeId) -> bool {
        matches!(self.state(leaf), LeafState::Done | LeafState::Skipped)
    }

    /// Since when a running leaf runs.
    pub(super) fn started(&self, leaf: NodeId) -> Option<Time> {
        self.started.get(&leaf).copied()
    }

    /// What runs, in tree order.
    pub(super) fn running(&self) -> impl Iterator<Item = NodeId> {
        self.states.iter().filter(|(_, state)| **state == LeafState::Active).map(|(leaf, _)| *leaf)
    }

    /// Leaves among nodes that are skipped by a grant and were not done before.
    pub(super) fn skipped(&self, grant: &Grant) -> Vec<NodeId> {
        let skipped = grant.skipped(self.header.nodes.len());
        skipped.filter(|node| self.is_behavior(*node) && !self.is_done(*node)).collect()
    }

    /// What is done in the end because its goal is met, though nobody could go on from it.
    pub(super) fn met(&self) -> impl Iterator<Item = NodeId> {
        self.met.iter().copied().filter(|leaf| self.state(*leaf) == LeafState::Waiting)
    }

    /// Why leaves that wait were not asked.
    pub(super) fn not_asked(&self) -> NotAsked<'_> {
        NotAsked::new(&self.header, |leaf| (self.is_done(leaf), self.is_done(leaf) || self.begun.contains(&leaf)))
    }

    /// Takes the next record, after it was told.
    pub(super) fn add(&mut self, record: &Record) {
        match record {
            Record::Decided { at, granted, refused, reopened, .. } => {
                for one in refused {
                    if one.reason == Reason::Satisfied {
                        self.met.insert(one.leaf);
                    } else {
                        self.met.remove(&one.leaf);
                    }
                }
                for grant in granted {
                    for leaf in self.skipped(grant) {
                        self.states.insert(leaf, LeafState::Skipped);
                    }
                    self.states.insert(grant.leaf(), LeafState::Active);
                    self.started.insert(grant.leaf(), *at);
                    self.begun.insert(grant.leaf());
                }
                if let Some(reopened) = reopened {
                    self.states.remove(&reopened.leaf);
                }
            }
            Record::Released { leaf, end, .. } => {
                self.started.remove(leaf);
                match end {
                    End::Succeeded => self.states.insert(*leaf, LeafState::Done),
                    End::Failed(_) | End::Canceled => self.states.remove(leaf),
                };
            }
            Record::Ended { end: MissionEnd::Done, .. } => {
                let met: Vec<NodeId> = self.met().collect();
                self.states.extend(met.into_iter().map(|leaf| (leaf, LeafState::Skipped)));
            }
            Record::Header(_)
            | Record::Sent { .. }
            | Record::World { .. }
            | Record::Resource { .. }
            | Record::Controller { .. }
            | Record::Ended { .. } => {}
        }
    }

    fn is_behavior(&self, node: NodeId) -> bool {
        self.header.nodes.get(node.index()).is_some_and(|entry| entry.kind.is_behavior())
    }
}
