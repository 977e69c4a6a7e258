//! One controller's attachment: absent, configuring, ready, lost.

use nalgebra::Vector3;

use crate::model::{
    Change, CommandId, ControllerId, ControllerKind, ControllerState, ResourceId, RobotSpec, Situation, Whereabouts,
};

/// How far a controller's attachment is.
#[derive(Debug, Clone, Default)]
pub(super) struct Attachment {
    generation: u32,
    next_number: u32,
    phase: Phase,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
enum Phase {
    #[default]
    Absent,
    Configuring,
    Ready(ControllerState),
}

impl Attachment {
    /// Begins a new attachment and gives its generation.
    pub(super) fn attach(&mut self) -> u32 {
        self.generation += 1;
        self.next_number = 0;
        self.phase = Phase::Configuring;
        self.generation
    }

    pub(super) fn expects(&self, generation: u32) -> bool {
        self.phase == Phase::Configuring && self.generation == generation
    }

    pub(super) fn configured(&mut self, state: ControllerState) {
        self.phase = Phase::Ready(state);
    }

    pub(super) fn lose(&mut self) {
        self.phase = Phase::Absent;
    }

    pub(super) fn is_ready(&self) -> bool {
        self.state().is_some()
    }

    /// The state it answered its configuration with.
    pub(super) fn state(&self) -> Option<ControllerState> {
        match self.phase {
            Phase::Ready(state) => Some(state),
            Phase::Absent | Phase::Configuring => None,
        }
    }

    pub(super) fn next_command(&mut self) -> CommandId {
        self.next_number += 1;
        CommandId { generation: self.generation, number: self.next_number }
    }
}

/// Where a simulated controller starts.
pub(super) fn start_state(robot: &RobotSpec, start: &Situation, id: ControllerId) -> ControllerState {
    match robot.controllers[id.index()].kind {
        ControllerKind::Base(_) => ControllerState::Base { pose: start.base, velocity: Vector3::zeros() },
        ControllerKind::Arm(arm) => {
            let holds = resources_of(robot, id).find_map(|resource| start.held_by(resource));
            ControllerState::Arm { gripper: arm.tuck, velocity: Vector3::zeros(), holds }
        }
        ControllerKind::Head(_) => ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] },
    }
}

/// The start corrected by what the controllers say; theirs wins.
pub(super) fn situation(
    robot: &RobotSpec,
    start: &Situation,
    states: impl Iterator<Item = (ControllerId, ControllerState)>,
) -> Situation {
    let mut situation = start.clone();
    for (id, state) in states {
        match state {
            ControllerState::Base { pose, .. } => {
                situation.apply(Change::Base(pose));
            }
            ControllerState::Arm { holds, .. } => {
                for resource in resources_of(robot, id) {
                    situation.apply(match holds.filter(|object| object.index() < start.objects.len()) {
                        Some(object) => Change::Object(object, Whereabouts::In(resource)),
                        None => Change::Emptied(resource),
                    });
                }
            }
            ControllerState::Head { .. } => {}
        }
    }
    situation
}

fn resources_of(robot: &RobotSpec, id: ControllerId) -> impl Iterator<Item = ResourceId> + '_ {
    let ids = (0..robot.resources.len()).map(ResourceId::from);
    ids.filter(move |resource| robot.resources[resource.index()].controller == Some(id))
}
