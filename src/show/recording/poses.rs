//! Where the base is on the map, and where grippers, slots and heads are on the robot.

use std::collections::BTreeMap;

use ambidex_model::{
    ControllerId, ControllerKind, ControllerMessage, ControllerState, MissionSpec, Names, Pose as PlanePose, Record,
    ResourceId, ToController,
};
use ambidex_record::History;
use nalgebra::Point3;

use super::foxglove::{FrameTransform, FrameTransforms, Pose, PoseInFrame, Quaternion};
use super::message::{Moment, Topic};

/// The frame of the map.
pub(super) const MAP: &str = "map";
/// The frame of the base.
pub(super) const BASE: &str = "base";

/// What was told of frames.
#[derive(Debug, Default)]
pub(super) struct Poses {
    base: Option<PlanePose>,
    /// Where the axes of heads cross, base frame, meters.
    necks: BTreeMap<ControllerId, Point3<f64>>,
    /// Where what a resource is can be found, in the base frame.
    parts: BTreeMap<ResourceId, Pose>,
}

impl Poses {
    /// Nothing was told of frames; arms are where they carry things, slots where they are.
    pub(super) fn new(mission: Option<&MissionSpec>) -> Self {
        let carried = |mission: &MissionSpec| {
            let resources = (0..mission.robot.resources.len()).map(ResourceId::from);
            resources.filter_map(|id| Some((id, mission.robot.carried_at(id)?.into()))).collect()
        };
        Self { parts: mission.map(carried).unwrap_or_default(), ..Self::default() }
    }

    /// Whether a resource has a frame.
    pub(super) fn has(&self, resource: ResourceId, names: &Names) -> bool {
        self.parts.contains_key(&resource) && has_frame(names.resource(resource))
    }

    /// Tells what is different after a record, or all anew.
    pub(super) fn tell(&mut self, history: &History, record: &Record, is_anew: bool, moment: &mut Moment) {
        let moved = if let Record::Controller { controller, message, .. } = record {
            self.hear(*controller, message, history)
        } else {
            Vec::new()
        };
        let moved: Vec<ResourceId> = if is_anew { self.parts.keys().copied().collect() } else { moved };
        let mut transforms = Vec::new();
        if let Some(base) = history.base().filter(|base| is_anew || self.base != Some(*base)) {
            self.base = Some(base);
            let (timestamp, pose) = (moment.stamp(), Pose::from(base));
            moment.say(Topic::Pose, &PoseInFrame { timestamp, frame_id: MAP, pose });
            transforms.push(FrameTransform::new(timestamp, MAP, BASE, pose));
        }
        for part in moved {
            let frame = history.names().resource(part);
            if has_frame(frame) {
                transforms.push(FrameTransform::new(moment.stamp(), BASE, frame, self.parts[&part]));
            }
        }
        if !transforms.is_empty() {
            moment.say(Topic::Transforms, &FrameTransforms { transforms });
        }
    }

    /// Takes what a controller is told and says; the resources that are somewhere else now.
    fn hear(&mut self, controller: ControllerId, message: &ControllerMessage, history: &History) -> Vec<ResourceId> {
        let state = match message {
            ControllerMessage::Told { message: ToController::Configure { limits, .. }, .. } => {
                if let ControllerKind::Head(head) = limits {
                    self.necks.insert(controller, head.neck);
                }
                None
            }
            ControllerMessage::Heard { message } => message.state(),
            ControllerMessage::Told { .. } | ControllerMessage::Joined { .. } | ControllerMessage::Attached => None,
            ControllerMessage::Refused { .. } | ControllerMessage::Misreported { .. } => None,
            ControllerMessage::Lost { .. } | ControllerMessage::Diagnosed { .. } => None,
        };
        let Some(pose) = state.and_then(|state| self.pose(controller, &state)) else { return Vec::new() };
        let movers = history.header().movers.iter().enumerate();
        let moved = movers.filter(|(_, mover)| **mover == Some(controller)).map(|(index, _)| ResourceId::from(index));
        let moved: Vec<ResourceId> = moved.collect();
        self.parts.extend(moved.iter().map(|part| (*part, pose)));
        moved
    }

    /// Where what a controller moves is in the base frame, as it says.
    fn pose(&self, controller: ControllerId, state: &ControllerState) -> Option<Pose> {
        match state {
            ControllerState::Arm { gripper, .. } => Some((*gripper).into()),
            ControllerState::Head { angles: [pan, tilt], .. } => {
                let neck = *self.necks.get(&controller)?;
                Some(Pose::new(neck.into(), Quaternion::turned(*pan, *tilt)))
            }
            ControllerState::Base { .. } | ControllerState::Device => None,
        }
    }
}

/// Whether a part can have a frame of its name: not one that is called as the map or the base.
fn has_frame(name: &str) -> bool {
    name != MAP && name != BASE
}
