//! Events of tasks that come and go.

use ambidex_model::{Granting, Hindrance, MissionEnd, Names, NodeId, ObjectId, PlaceId};
use tracing::{info, warn};

use super::MISSION;

pub(super) fn added(at_s: f64, node: u32, name: &str, is_task: bool) {
    match is_task {
        true => info!(target: MISSION, task = name, node, at_s, "task submitted"),
        false => info!(target: MISSION, part = name, node, at_s, "added to the tree"),
    }
}

pub(super) fn removed(at_s: f64, node: NodeId, names: &Names) {
    info!(target: MISSION, part = names.node(node), at_s, "taken out of the tree");
}

pub(super) fn granting(at_s: f64, task: Option<NodeId>, granting: Granting, names: &Names) {
    let task = task.map_or("all", |task| names.node(task));
    match granting {
        Granting::Freely => info!(target: MISSION, task, at_s, "goes on"),
        Granting::Paused => info!(target: MISSION, task, at_s, "paused"),
        Granting::Step => info!(target: MISSION, task, at_s, "takes a step"),
    }
}

pub(super) fn canceled(at_s: f64, task: NodeId, names: &Names) {
    info!(target: MISSION, task = names.node(task), at_s, "task canceled");
}

pub(super) fn ended(at_s: f64, task: NodeId, end: MissionEnd, names: &Names) {
    let task = names.node(task);
    match end {
        MissionEnd::Done | MissionEnd::Canceled => info!(target: MISSION, task, outcome = ?end, at_s, "task ended"),
        MissionEnd::Failed(_) | MissionEnd::Stalled | MissionEnd::ControllerLost(_) => {
            warn!(target: MISSION, task, outcome = ?end, at_s, "task ended");
        }
        MissionEnd::NotAttached | MissionEnd::NodeLost(_) | MissionEnd::TaskLost => {
            warn!(target: MISSION, task, outcome = ?end, at_s, "task ended");
        }
    }
}

pub(super) fn stalled(at_s: f64, tasks: &[NodeId], names: &Names) {
    let stalled = tasks.iter().map(|task| names.node(*task)).collect::<Vec<_>>().join(", ");
    match tasks.is_empty() {
        true => info!(target: MISSION, at_s, "no task is stalled any more"),
        false => warn!(target: MISSION, stalled, at_s, "nothing of these tasks can go on"),
    }
}

pub(super) fn object_added(at_s: f64, object: &str, place: PlaceId, names: &Names) {
    info!(target: MISSION, object, place = names.place(place), at_s, "came into the room");
}

pub(super) fn object_removed(at_s: f64, object: ObjectId, names: &Names) {
    info!(target: MISSION, object = names.object(object), at_s, "left the room");
}

pub(super) fn declined(at_s: f64, number: u64, why: Hindrance, names: &Names) {
    info!(target: MISSION, number, why = why.sentence(names), at_s, "work was refused");
}
