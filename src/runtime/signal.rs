//! What the tasks of a run tell its supervisor.

use ambidex_model::{Change, ControllerId, MissionEnd, Uptake};

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
    /// It is gone before the mission began.
    Missing(ControllerId),
    /// Nothing moves any more.
    Safe,
}
