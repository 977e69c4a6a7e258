//! What the tasks of a run tell its supervisor.

use ambidex_model::{ControllerId, MissionEnd};

/// What tasks tell the supervisor.
#[derive(Debug)]
pub(super) enum Signal {
    /// It is configured.
    Attached(ControllerId),
    /// All are, and root was told to begin.
    Begun,
    /// Root has ended the mission.
    Finished(MissionEnd),
    /// It is gone before the mission began.
    Missing(ControllerId),
    /// Nothing moves any more.
    Safe,
}
