//! How far a run is, in one line for whoever supervises many.

use ambidex_model::state::Stage;
use ambidex_model::{ControllerId, NodeId};
use ambidex_record::{History, MissionOutcome, Presence};

use crate::text::count;

/// How far a run is: for whom it waits, how much is done, how it ended.
pub fn stage(history: &History) -> String {
    let mission = &history.header().mission;
    if let Some(end) = history.end() {
        return format!("{mission}: {}", MissionOutcome::from(end).word());
    }
    let state = history.state_of_run();
    match (state.stage(), absent(history).as_slice()) {
        (Stage::Waiting, absent @ [_, ..]) => return format!("{mission}: waiting for {}", absent.join(", ")),
        (Stage::Waiting | Stage::Running | Stage::Over(_), _) => {}
    }
    let counts = history.counts(NodeId(0));
    let done = format!("{} of {} done", counts.done, count(counts.of, "behavior"));
    match state.ending() {
        Some((end, _)) => format!("{mission}: is to end ({}), {done}", MissionOutcome::from(end).word()),
        None => format!("{mission}: {done}, step {}", history.step_count()),
    }
}

/// Controllers that are not there, in the order of the robot file.
pub fn absent(history: &History) -> Vec<&str> {
    let names = history.names();
    let is_absent =
        |id: &ControllerId| history.controllers().view(*id).is_none_or(|view| view.presence == Presence::Lost);
    let ids = (0..names.controllers.len()).map(ControllerId::from);
    ids.filter(is_absent).map(|id| names.controller(id)).collect()
}
