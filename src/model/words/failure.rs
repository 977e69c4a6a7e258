//! What goes wrong on purpose, so that it can be seen what a mission makes of it.

use std::time::Duration;

use super::{Change, ControllerId, NodeId, ObjectId, Time};

/// Everything that goes wrong on purpose in one run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Failures {
    /// What happens at moments since the mission began, in their order.
    pub mishaps: Vec<(Time, Mishap)>,
    /// What behaviors do wrong.
    pub flaws: Vec<Flaw>,
}

/// Something that happens to the robot or the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mishap {
    /// The process of a controller ends.
    Lose(ControllerId),
    /// The process of a controller is there and does nothing any more.
    Hang(ControllerId),
    /// The emergency stop of a controller is pressed.
    Inhibit(ControllerId),
    /// A lost controller is started again; one that hung goes on; an emergency stop is released.
    Return(ControllerId),
    /// The world changes from outside.
    World(Change),
    /// The disk that the log is written to.
    Disk(Disk),
    /// The mission is told to end.
    Cancel,
}

/// How a disk takes what is written to it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Disk {
    /// As any does.
    #[default]
    Well,
    /// It has no room left.
    Full,
    /// Each write takes half a second.
    Slow,
}

/// What a behavior does wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flaw {
    /// The behavior.
    pub leaf: NodeId,
    /// In which of its attempts, counted from 1; none for all.
    pub attempt: Option<u32>,
    /// What.
    pub kind: FlawKind,
}

/// What can go wrong in an attempt of a behavior.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlawKind {
    /// A controller gives up at the end of what it does.
    Fails,
    /// It never ends by itself: its timeout comes.
    Hangs,
    /// It ends by itself only when so much more robot time than it needs at least is over.
    Late(Duration),
    /// As it begins, a gripper loses this object, or without one all that its grippers hold; the behavior goes on.
    Drops(Option<ObjectId>),
}

impl Flaw {
    /// Whether an attempt is meant.
    pub fn is_of(&self, leaf: NodeId, attempt: u32) -> bool {
        self.leaf == leaf && self.attempt.is_none_or(|of| of == attempt)
    }
}
