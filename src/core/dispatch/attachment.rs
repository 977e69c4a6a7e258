//! One controller's attachment: absent, configuring, ready, lost.

use nalgebra::Vector3;

use ambidex_model::{CommandId, ControllerId, ControllerKind, ControllerState, Loss, MissionSpec, Time};

/// How often a controller is configured that does not answer, before it counts as lost.
const TRIES: u32 = 3;

/// How far a controller's attachment is.
#[derive(Debug, Clone, Default)]
pub(super) struct Attachment {
    generation: u32,
    next_number: u32,
    phase: Phase,
    /// How it came to be away, if it is.
    loss: Option<Loss>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
enum Phase {
    #[default]
    Absent,
    Configuring {
        deadline: Time,
        tries: u32,
    },
    Ready(ControllerState),
}

impl Attachment {
    /// One that counts on from an earlier one.
    pub(super) fn after(generation: u32) -> Self {
        Self { generation, ..Self::default() }
    }

    /// Begins a new attachment, to be answered in time, and gives its generation; none after too many tries.
    pub(super) fn attach(&mut self, deadline: Time) -> Option<u32> {
        let tries = match self.phase {
            Phase::Configuring { tries, .. } => tries + 1,
            Phase::Absent | Phase::Ready(_) => 1,
        };
        self.phase = if tries > TRIES { Phase::Absent } else { Phase::Configuring { deadline, tries } };
        self.generation += 1;
        (self.next_number, self.loss) = (0, None);
        (tries <= TRIES).then_some(self.generation)
    }

    pub(super) fn expects(&self, generation: u32) -> bool {
        matches!(self.phase, Phase::Configuring { .. }) && self.generation == generation
    }

    /// By when the configuration must be answered.
    pub(super) fn deadline(&self) -> Option<Time> {
        match self.phase {
            Phase::Configuring { deadline, .. } => Some(deadline),
            Phase::Absent | Phase::Ready(_) => None,
        }
    }

    pub(super) fn configured(&mut self, state: ControllerState) {
        self.phase = Phase::Ready(state);
    }

    pub(super) fn lose(&mut self, why: Loss) {
        (self.phase, self.loss) = (Phase::Absent, Some(why));
    }

    /// How it came to be away, if it is.
    pub(super) fn loss(&self) -> Option<Loss> {
        self.loss
    }

    pub(super) fn is_ready(&self) -> bool {
        self.state().is_some()
    }

    /// The state it answered its configuration with.
    pub(super) fn state(&self) -> Option<ControllerState> {
        match self.phase {
            Phase::Ready(state) => Some(state),
            Phase::Absent | Phase::Configuring { .. } => None,
        }
    }

    pub(super) fn next_command(&mut self) -> CommandId {
        self.next_number += 1;
        CommandId { generation: self.generation, number: self.next_number }
    }
}

/// What is known of a controller from before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LastKnown {
    /// What it is configured with; a real one answers with its own state.
    pub state: ControllerState,
    /// How often it had attached: no command of another attachment is called as one of before.
    pub generation: u32,
}

/// What is known of every controller when a mission begins, by controller.
pub fn at_start(mission: &MissionSpec) -> Vec<LastKnown> {
    let controllers = (0..mission.robot.controllers.len()).map(ControllerId::from);
    controllers.map(|id| LastKnown { state: state(mission, id), generation: 0 }).collect()
}

fn state(mission: &MissionSpec, id: ControllerId) -> ControllerState {
    match mission.robot.controllers[id.index()].kind {
        ControllerKind::Base(_) => ControllerState::Base { pose: mission.start.base, velocity: Vector3::zeros() },
        ControllerKind::Arm(arm) => {
            let holds = mission.robot.moved_by(id).find_map(|resource| mission.start.held_by(resource));
            ControllerState::Arm { gripper: arm.tuck, velocity: Vector3::zeros(), holds }
        }
        ControllerKind::Head(_) => ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] },
        ControllerKind::Device => ControllerState::Device,
    }
}

/// Whether such a state can come from this controller: of its kind, and about objects that there are.
pub(super) fn is_credible(mission: &MissionSpec, id: ControllerId, state: &ControllerState) -> bool {
    match (state, mission.robot.controllers[id.index()].kind) {
        (ControllerState::Base { .. }, ControllerKind::Base(_))
        | (ControllerState::Head { .. }, ControllerKind::Head(_))
        | (ControllerState::Device, ControllerKind::Device) => true,
        (ControllerState::Arm { holds, .. }, ControllerKind::Arm(_)) => {
            holds.is_none_or(|object| object.index() < mission.start.objects.len())
        }
        (
            ControllerState::Base { .. }
            | ControllerState::Arm { .. }
            | ControllerState::Head { .. }
            | ControllerState::Device,
            _,
        ) => false,
    }
}
