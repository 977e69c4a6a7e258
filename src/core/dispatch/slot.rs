//! What one controller is doing: one command at a time, others queue behind it.

use std::collections::{BTreeSet, VecDeque};

use ambidex_model::{Access, Command, CommandId, Mode, NodeId, ResourceId, Time};

/// What is to be done for a part of a goal.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Work {
    pub(super) resource: ResourceId,
    pub(super) access: Access,
    pub(super) mode: Mode,
    pub(super) command: Command,
}

/// A command under way.
#[derive(Debug)]
pub(super) struct Active {
    pub(super) id: CommandId,
    pub(super) work: Work,
    /// For whom.
    pub(super) holders: BTreeSet<NodeId>,
    /// By when the controller must have taken or ended it.
    pub(super) due: Option<Time>,
    pub(super) is_canceled: bool,
}

/// One controller's work.
#[derive(Debug, Default)]
pub(super) struct Slot {
    pub(super) current: Option<Active>,
    pub(super) queue: VecDeque<(NodeId, Work)>,
}

impl Slot {
    pub(super) fn is_idle(&self) -> bool {
        self.current.is_none() && self.queue.is_empty()
    }

    pub(super) fn knows(&self, id: CommandId) -> bool {
        self.current.as_ref().is_some_and(|active| active.id == id)
    }

    pub(super) fn deadline(&self) -> Option<Time> {
        self.current.as_ref()?.due
    }

    pub(super) fn accepted(&mut self) {
        if let Some(active) = &mut self.current
            && !active.is_canceled
        {
            active.due = None;
        }
    }

    /// The command that lasts and that this work can share.
    pub(super) fn shared(&mut self, work: &Work) -> Option<&mut Active> {
        let active = self.current.as_mut()?;
        let lasts = active.work.mode == Mode::Maintain && work.mode == Mode::Maintain;
        let is_same = active.work.resource == work.resource
            && active.work.access.joins(work.access)
            && is_same(&active.work.command, &work.command);
        (lasts && is_same && !active.is_canceled).then_some(active)
    }
}

/// Whether two commands are the same thing to keep up.
fn is_same(a: &Command, b: &Command) -> bool {
    std::mem::discriminant(a) == std::mem::discriminant(b)
}
