//! What the tasks of a run tell its supervisor.

use std::fmt;
use std::pin::Pin;
use std::sync::Arc;

use ambidex_model::{Change, ControllerId, MissionEnd, MissionSpec, NodeId, Uptake, Work, Worked};

/// What tasks tell the supervisor.
#[derive(Debug)]
pub(super) enum Signal {
    /// It is configured.
    Attached(ControllerId),
    /// All are, and root was told to begin.
    Begun,
    /// Root has ended the mission.
    Finished(MissionEnd),
    /// What root made of what it was asked to change.
    TakenUp(Change, Uptake),
    /// What comes with work was read, or why it cannot be.
    Read(Result<Box<Work>, String>),
    /// What came of work that was asked for, counted from 1.
    Worked(u64, Worked),
    /// The mission is another one from now on.
    Mission(Arc<MissionSpec>),
    /// Nodes came: their tasks are to be started.
    Spawned(Vec<Spawned>),
    /// It is gone before the mission began.
    Missing(ControllerId),
    /// Nothing moves any more.
    Safe,
}

/// The task of a node that came.
pub(super) struct Spawned {
    pub(super) node: NodeId,
    /// What it does until it is gone.
    pub(super) life: Pin<Box<dyn Future<Output = ()> + Send>>,
}

impl fmt::Debug for Spawned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Spawned").field("node", &self.node).finish_non_exhaustive()
    }
}
