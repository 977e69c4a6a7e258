//! Objects that leave their grippers on purpose: who holds them is configured anew with an empty gripper, and once it
//! says so the world is told. Goals wait for it, so that none finds the gripper unready.

use std::collections::{BTreeMap, VecDeque};
use std::mem;

use super::script::Plan;
use super::{Dispatch, Effect};
use ambidex_model::{
    Change, ControllerId, ControllerState, End, Goal, Location, NodeId, ObjectId, Outcome, PlaceId, Pose, Time,
};

/// What is on its way to the ground, and what waits for that.
#[derive(Debug, Default)]
pub(super) struct Drops {
    letting_go: BTreeMap<ControllerId, ObjectId>,
    waiting: VecDeque<(Goal, Plan)>,
}

impl Drops {
    pub(super) fn is_letting_go(&self, id: ControllerId) -> bool {
        self.letting_go.contains_key(&id)
    }
}

impl Dispatch {
    /// A goal begins, after what it drops on purpose has been dropped.
    pub(super) fn attempt(&mut self, now: Time, goal: Goal) {
        let plan = self.script.begin(goal.leaf);
        for object in &plan.drops {
            for (id, held) in self.dropping(&goal, *object) {
                self.drop_object(now, id, held);
            }
        }
        if self.drops.letting_go.is_empty() {
            self.start(now, goal, &plan);
        } else {
            self.drops.waiting.push_back((goal, plan));
        }
    }

    /// A controller was configured, or is gone: if it was to let go of something, it has.
    pub(super) fn let_go(&mut self, now: Time, id: ControllerId, state: Option<ControllerState>) {
        let Some(object) = self.drops.letting_go.remove(&id) else { return };
        // A real one knows better what it holds; what a lost one holds nobody knows.
        if state.is_some_and(|state| state.holds() != Some(object)) {
            let is_held = self.holders().iter().any(|(other, held)| (*other, *held) != (id, object) && *held == object);
            let dropped = if is_held { self.emptied(id) } else { vec![self.fallen(object)] };
            self.effects.extend(dropped.into_iter().map(Effect::Dropped));
        }
        self.start_waiting(now);
    }

    /// What others still hold does not fall.
    fn emptied(&self, id: ControllerId) -> Vec<Change> {
        self.mission.robot.moved_by(id).map(Change::Emptied).collect()
    }

    fn fallen(&self, object: ObjectId) -> Change {
        Change::Object(object, self.nearest_place().map_or(Location::Unknown, Location::At))
    }

    /// Goals that have not begun end before they do.
    pub(super) fn stop_waiting(&mut self, is_meant: impl Fn(NodeId) -> bool) {
        for (goal, plan) in mem::take(&mut self.drops.waiting) {
            if is_meant(goal.leaf) {
                let outcome = Outcome { end: End::Canceled, changes: Vec::new() };
                self.effects.push(Effect::Ended(goal.leaf, outcome));
            } else {
                self.drops.waiting.push_back((goal, plan));
            }
        }
    }

    /// Who lets go of what: of one object, or of all in the grippers that a goal commands, else of all that is carried.
    fn dropping(&self, goal: &Goal, object: Option<ObjectId>) -> Vec<(ControllerId, ObjectId)> {
        let (mut holders, own) = (self.holders(), self.commanded(goal));
        let has_own = holders.iter().any(|(id, _)| own.contains(id));
        holders.retain(|(id, held)| match object {
            Some(object) => object == *held,
            None => !has_own || own.contains(id),
        });
        holders
    }

    /// The controllers that are there and hold an object, each with it.
    fn holders(&self) -> Vec<(ControllerId, ObjectId)> {
        let states = self.states.iter().zip(&self.attachments).enumerate();
        let ready = states.filter(|(_, (_, attachment))| attachment.is_ready());
        ready.filter_map(|(index, (state, _))| Some((index.into(), state.holds()?))).collect()
    }

    fn drop_object(&mut self, now: Time, id: ControllerId, object: ObjectId) {
        let ControllerState::Arm { gripper, velocity, .. } = self.states[id.index()] else { return };
        if self.is_ending || self.drops.letting_go.insert(id, object).is_some() {
            return;
        }
        self.states[id.index()] = ControllerState::Arm { gripper, velocity, holds: None }.at_rest();
        self.configure(now, id);
    }

    fn start_waiting(&mut self, now: Time) {
        if !self.drops.letting_go.is_empty() {
            return;
        }
        for (goal, plan) in mem::take(&mut self.drops.waiting) {
            self.start(now, goal, &plan);
        }
    }

    /// The controllers that a goal commands.
    fn commanded(&self, goal: &Goal) -> Vec<ControllerId> {
        let resources = &self.mission.robot.resources;
        goal.parts.iter().filter_map(|part| resources[part.resource.index()].controller).collect()
    }

    /// The place whose stand is the nearest to the base, in the plane.
    fn nearest_place(&self) -> Option<PlaceId> {
        let driven = self.states.iter().find_map(|state| match state {
            ControllerState::Base { pose, .. } => Some(*pose),
            ControllerState::Arm { .. } | ControllerState::Head { .. } | ControllerState::Device => None,
        });
        let base: Pose = driven.unwrap_or(self.mission.start.base);
        let places = self.mission.world.places.iter().enumerate();
        let distances = places.map(|(index, place)| (PlaceId::from(index), base.distance_m(&place.stand)));
        distances.min_by(|(_, one), (_, other)| one.total_cmp(other)).map(|(id, _)| id)
    }
}
