//! What a node has come to.

use crate::{Blocked, Failing, Fault, NodeId, ResourceId, Time};

/// A node's part of the state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Status {
    /// How far it is.
    pub phase: Phase,
    /// The child through which something was granted last. An OR is committed to it; none when it is to choose again.
    pub way: Option<NodeId>,
    /// How often its behavior failed.
    pub failures: u32,
    /// Whether its behavior completed at least once.
    pub has_completed: bool,
    /// Whether its behavior runs and was told to end.
    pub is_stopping: bool,
    /// Why it does not ask although it is not done.
    pub bar: Option<Box<Bar>>,
    /// How it failed, while it waits before it asks again.
    pub wait: Option<Box<Wait>>,
    /// Resources with which it failed, each once, in resource order.
    pub failed_with: Vec<ResourceId>,
}

/// How far a node is. Whether something below it runs, [`super::State::running`] says.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Phase {
    /// It is not done, nor has it failed.
    #[default]
    Pending,
    /// Its goal is reached.
    Done,
    /// It will have failed when nothing below it runs any more.
    Failing(Failing),
    /// It has failed for good.
    Failed,
}

/// A behavior waits before it asks again.
#[derive(Debug, Clone, PartialEq)]
pub struct Wait {
    /// Since when, robot time.
    pub since: Time,
    /// Until when, robot time.
    pub until: Time,
    /// How it failed.
    pub fault: Fault,
}

/// A behavior whose lease lapsed does not ask before there is progress.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// The progress at which it holds.
    pub progress: u64,
    /// For whom it was done, and what that one lacks.
    pub heir: Blocked,
}
