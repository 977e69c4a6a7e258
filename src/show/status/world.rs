//! The world: where the mission starts, what controllers say, and what root changed since.

use ambidex_model::{
    Change, ControllerId, ControllerMessage, ControllerState, FromController, Header, Location, Names, ObjectId, Pose,
    ResourceId,
};

use super::snapshot::{FactRow, ObjectRow, WorldRow};

/// A running fold of changes. Ids that are not of the mission are passed over.
#[derive(Debug, Clone, Default)]
pub(super) struct World {
    base: Option<Pose>,
    objects: Vec<Location>,
    facts: Vec<bool>,
    movers: Vec<Option<ControllerId>>,
}

impl World {
    pub(super) fn new(header: &Header) -> Self {
        let names = &header.names;
        let mut world = Self {
            base: None,
            objects: vec![Location::Unknown; names.objects.len()],
            facts: vec![false; names.facts.len()],
            movers: header.movers.clone(),
        };
        if let Some(start) = &header.start {
            world.base = Some(start.base);
            world.objects.iter_mut().zip(&start.objects).for_each(|(known, at)| *known = *at);
            world.facts.iter_mut().zip(&start.facts).for_each(|(known, holds)| *known = *holds);
        }
        world
    }

    pub(super) fn apply(&mut self, change: Change) {
        match change {
            Change::Base(pose) => self.base = Some(pose),
            Change::Object(object, at) => {
                if let Some(known) = self.objects.get_mut(object.index()) {
                    *known = at;
                }
            }
            Change::Emptied(resource) => {
                let held = |at: &&mut Location| **at == Location::In(resource);
                self.objects.iter_mut().filter(held).for_each(|at| *at = Location::Unknown);
            }
            Change::Fact(fact, holds) => {
                if let Some(known) = self.facts.get_mut(fact.index()) {
                    *known = holds;
                }
            }
        }
    }

    /// A controller that was configured says how things are, which wins; a base says where it is all the time.
    pub(super) fn hear(&mut self, controller: ControllerId, message: &ControllerMessage) {
        let ControllerMessage::Heard { message } = message else {
            return;
        };
        let (state, is_new) = match message {
            FromController::Configured { state, .. } => (state, true),
            FromController::Feedback { state, .. } | FromController::Result { state, .. } => (state, false),
            FromController::Accepted { .. } | FromController::Rejected { .. } => return,
        };
        match *state {
            ControllerState::Base { pose, .. } => self.base = Some(pose),
            ControllerState::Arm { holds, .. } if is_new => {
                let moved = (0..self.movers.len()).filter(|&index| self.movers[index] == Some(controller));
                for resource in moved.map(ResourceId::from).collect::<Vec<_>>() {
                    self.apply(match holds {
                        Some(object) => Change::Object(object, Location::In(resource)),
                        None => Change::Emptied(resource),
                    });
                }
            }
            ControllerState::Arm { .. } | ControllerState::Head { .. } => {}
        }
    }

    pub(super) fn held_by(&self, resource: ResourceId) -> Option<ObjectId> {
        self.objects.iter().position(|&at| at == Location::In(resource)).map(ObjectId::from)
    }

    pub(super) fn row(&self, names: &Names) -> WorldRow {
        let object = |(name, at): (&String, &Location)| {
            let (at, held_by) = match *at {
                Location::At(place) => (Some(names.place(place).to_owned()), None),
                Location::In(resource) => (None, Some(names.resource(resource).to_owned())),
                Location::Unknown => (None, None),
            };
            ObjectRow { name: name.clone(), at, held_by }
        };
        let fact = |(name, holds): (&String, &bool)| FactRow { name: name.clone(), holds: *holds };
        WorldRow {
            base: self.base.map(|pose| [pose.at.x, pose.at.y, pose.heading]),
            objects: names.objects.iter().zip(&self.objects).map(object).collect(),
            facts: names.facts.iter().zip(&self.facts).map(fact).collect(),
        }
    }
}
