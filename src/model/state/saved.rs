//! All that a run is at a moment at which no round is open: what a log begins with whose beginnings were put aside.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::State;
use crate::{Change, Names, NodeEntry, NodeId, Objection, Origin, Reason, Runs, Source, Time};

/// A run that takes work, to be gone on with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    /// Tree, table, world, what runs.
    pub state: State,
    /// What each node is, by id.
    pub nodes: Runs<NodeEntry>,
    /// What everything is called.
    pub names: Names,
    /// What parts of the tree were read from, each with its top.
    pub parts: BTreeMap<NodeId, Source>,
    /// What root keeps beside the state.
    pub root: SavedRoot,
}

/// What root keeps beside the state.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SavedRoot {
    /// When the last turn was.
    pub turned: Time,
    /// A round is to be opened.
    pub is_wanted: bool,
    /// The last round granted nothing while nothing ran.
    pub was_quiet: bool,
    /// How often work was asked for.
    pub asked_for: u64,
    /// How many grants to later tasks each task that waits has seen.
    pub seen: BTreeMap<NodeId, u32>,
    /// Whom behaviors have interrupted, with the progress at which they did.
    pub preempted: Vec<(NodeId, NodeId, u64)>,
    /// When the present time of nodes began that are done more than once.
    pub began: BTreeMap<NodeId, Time>,
    /// What others said and was refused since the world is as it is.
    pub denied: Vec<(Change, Origin, Objection)>,
    /// Behaviors that do not ask before something has become different, each with its reason.
    pub barred: BTreeMap<NodeId, Reason>,
    /// Behaviors that do not ask before there is progress, or not for everything.
    pub unheard: BTreeSet<NodeId>,
    /// An order in which all can be run that holds something; none where none is known.
    pub order: Option<Vec<NodeId>>,
    /// How many behaviors were left when there was no order to be found.
    pub lost: Option<u64>,
    /// The tasks that the order is about.
    pub scope: Option<BTreeSet<NodeId>>,
}
