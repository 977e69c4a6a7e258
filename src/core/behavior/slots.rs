//! What no controller tells of: what a slot of the robot holds follows from what hands say that put into it or take from it.

use super::spots;
use ambidex_model::state::State;
use ambidex_model::{BehaviorSpec, Change, EffectTerm, Grant, Location, MissionSpec, ResourceId, RobotSpec};

/// What is so of slots by what controllers say while or after a behavior runs that has not succeeded.
pub(super) fn follows(spec: &BehaviorSpec, grant: &Grant, said: &[Change], robot: &RobotSpec) -> Vec<Change> {
    let resource = |claim: usize| grant.bindings[claim].resource;
    let is_slot = |resource: ResourceId| is_slot(resource, robot);
    let is_said = |change| said.contains(&change);
    let has = |wanted: &dyn Fn(&EffectTerm) -> bool| spec.effects.iter().any(wanted);
    let follow = |effect: &EffectTerm| {
        match *effect {
        // A hand that let go of it has put it there.
        EffectTerm::Taken(object, slot) if is_slot(resource(slot)) => has(&|other| {
            matches!(*other, EffectTerm::LetGo(of, hand) if of == object && is_said(Change::Emptied(resource(hand))))
        })
        .then_some(Change::Taken(object, resource(slot))),
        // A hand that has it has taken it out.
        EffectTerm::LetGo(object, slot) if is_slot(resource(slot)) => has(&|other| {
            matches!(*other, EffectTerm::Taken(of, hand) if of == object && is_said(Change::Taken(object, resource(hand))))
        })
        .then_some(Change::Emptied(resource(slot))),
        EffectTerm::Taken(..) | EffectTerm::LetGo(..) => None,
        EffectTerm::Lies(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => None,
    }
    };
    spec.effects.iter().filter_map(follow).collect()
}

/// A change from outside as it must have come about: an object that has left its gripper while somebody was putting it
/// down lies there, or is in the slot where it was to be, though nobody was told.
pub(crate) fn understood(change: Change, state: &State, mission: &MissionSpec) -> Vec<Change> {
    let running = state.running().iter().filter_map(|(leaf, grant)| {
        let spec = mission.tree.behavior(*leaf)?.asked(&grant.request);
        Some((spec, grant))
    });
    let running: Vec<_> = running.collect();
    if let Change::Emptied(gripper) = change
        && let Some(held) = state.world().held_only_by(gripper)
        && let Some(change) = running.iter().find_map(|(spec, grant)| {
            let place = spec.effects.iter().find_map(|effect| effect.lays(held))?;
            Some(spots::laid(held, place, grant))
        })
    {
        return vec![change];
    }
    let follow = running.iter().flat_map(|(spec, grant)| follows(spec, grant, &[change], &mission.robot));
    let mut all: Vec<Change> = follow.collect();
    if all.is_empty() {
        all = taken_out(change, state, &mission.robot);
    }
    all.push(change);
    all
}

/// A hand that comes to have what a slot held has taken it out, whatever became of the behavior that it did it for.
fn taken_out(change: Change, state: &State, robot: &RobotSpec) -> Vec<Change> {
    let Change::Taken(object, hand) = change else { return Vec::new() };
    let Some(Location::In(holders)) = state.world().objects.get(object.index()) else { return Vec::new() };
    if holders.contains(hand) {
        return Vec::new();
    }
    let slots = holders.as_slice().iter().filter(|holder| is_slot(**holder, robot));
    slots.map(|slot| Change::Emptied(*slot)).collect()
}

/// Whether no controller moves it.
fn is_slot(resource: ResourceId, robot: &RobotSpec) -> bool {
    robot.resources[resource.index()].controller.is_none()
}
