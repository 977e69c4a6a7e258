//! What a node has come to.

use serde::{Deserialize, Serialize};

use crate::{Blocked, Failing, Fault, NodeId, Reason, ResourceId, Time};

/// A node's part of the state.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// How far it is.
    pub phase: Phase,
    /// The child through which something was granted last. An OR is committed to it; none when it is to choose again.
    pub way: Option<NodeId>,
    /// How often it failed.
    pub failures: u32,
    /// Whether its behavior completed at least once.
    pub has_completed: bool,
    /// Whether its behavior runs and was told to end.
    pub is_stopping: bool,
    /// Whether something below it was granted since it last began.
    pub is_begun: bool,
    /// Why it does not ask although it is not done.
    pub bar: Option<Box<Bar>>,
    /// How it failed, while it waits before it asks again.
    pub wait: Option<Box<Wait>>,
    /// Resources with which it failed, each once, in resource order.
    pub failed_with: Vec<ResourceId>,
}

/// How far a node is. Whether something below it runs, [`super::State::running`] says.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// It is not done, nor has it failed.
    #[default]
    Pending,
    /// Its goal is reached.
    Done,
    /// It will have failed when nothing below it runs any more, or nothing is left there that can be finished.
    Failing(Failing),
    /// It has failed for good.
    Failed,
    /// It is canceled, or an OR is about to leave it: it waits for what runs below it to end, and for cleanups.
    Ending,
    /// Its body has failed or is given up, and its cleanup is done.
    Cleaning(GoesOn),
}

/// What a node goes on to when its cleanup is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum GoesOn {
    /// It has failed.
    Failing(Failing),
    /// It is canceled, or left.
    Ending,
    /// One above it has failed, is canceled or left.
    Pending,
}

/// A node that is done more than once waits for its next time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pause {
    /// Since when, robot time.
    pub since: Time,
    /// Until when, robot time.
    pub until: Time,
}

impl Pause {
    /// Why nothing at or below the node is asked.
    pub fn reason(&self, node: NodeId) -> Reason {
        Reason::NotYet { node, wait_ms: self.until.since_ms(self.since) }
    }
}

/// A behavior was sent back, since a later one needs what it makes so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Redone {
    /// The progress at which it was: it is sent back once in each.
    pub progress: u64,
    /// The behavior that needs it; none once it has been done again.
    pub leaf: Option<NodeId>,
}

/// A node waits before it asks again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Wait {
    /// Since when, robot time.
    pub since: Time,
    /// Until when, robot time.
    pub until: Time,
    /// How it failed.
    pub fault: Fault,
}

impl Wait {
    /// Why it does not ask.
    pub fn reason(&self) -> Reason {
        Reason::BackingOff { wait_ms: self.until.since_ms(self.since), fault: self.fault }
    }
}

/// What would not do a behavior, for reach or kind.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unfit {
    /// The progress at which that was.
    pub progress: u64,
    /// Which, in resource order.
    pub resources: Vec<ResourceId>,
}

/// A behavior whose lease lapsed does not ask before there is progress.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bar {
    /// The progress at which it holds.
    pub progress: u64,
    /// For whom it was done, and what that one lacks.
    pub heir: Blocked,
}
