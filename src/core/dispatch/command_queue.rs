//! What one controller is doing: one command at a time, others queue behind it.

use std::collections::{BTreeSet, VecDeque};

use ambidex_model::{Command, CommandId, Mode, NodeId, Part, Time};

/// A command under way.
#[derive(Debug)]
pub(super) struct Active {
    pub(super) id: CommandId,
    pub(super) part: Part,
    /// Behaviors that share it.
    pub(super) holders: BTreeSet<NodeId>,
    /// By when the controller must have taken or ended it.
    pub(super) deadline: Option<Time>,
    pub(super) is_canceled: bool,
}

/// One controller's part.
#[derive(Debug, Default)]
pub(super) struct CommandQueue {
    pub(super) current: Option<Active>,
    pub(super) waiting: VecDeque<(NodeId, Part)>,
}

impl CommandQueue {
    pub(super) fn is_idle(&self) -> bool {
        self.current.is_none() && self.waiting.is_empty()
    }

    pub(super) fn knows(&self, id: CommandId) -> bool {
        self.current.as_ref().is_some_and(|active| active.id == id)
    }

    pub(super) fn deadline(&self) -> Option<Time> {
        self.current.as_ref()?.deadline
    }

    pub(super) fn accepted(&mut self) {
        if let Some(active) = &mut self.current
            && !active.is_canceled
        {
            active.deadline = None;
        }
    }

    /// The command that lasts and that this part can share.
    pub(super) fn shared(&mut self, part: &Part) -> Option<&mut Active> {
        let active = self.current.as_mut()?;
        let lasts = active.part.mode == Mode::Maintain && part.mode == Mode::Maintain;
        let is_same = active.part.resource == part.resource
            && active.part.access.joins(part.access)
            && is_same(&active.part.command, &part.command);
        (lasts && is_same && !active.is_canceled).then_some(active)
    }
}

/// Whether two commands are the same thing to keep up: whoever shares a channel looks at the same point, but may call
/// anything.
fn is_same(a: &Command, b: &Command) -> bool {
    match (a, b) {
        (Command::Call(a), Command::Call(b)) => a == b,
        (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
    }
}
