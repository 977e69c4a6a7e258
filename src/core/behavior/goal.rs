//! From a grant to a goal, and from an outcome to what is different in the world.

use super::slots;
use crate::world::{KnownPaths, View};
use ambidex_model::{
    BehaviorSpec, Change, Command, EffectTerm, End, Fault, Goal, Grant, Location, Outcome, Part, ResourceId, RobotSpec,
    Task,
};

/// The goal of a granted behavior, with positions as of the view it asked in and the path that it asked with.
pub fn goal(spec: &BehaviorSpec, grant: &Grant, view: &View, known: &mut KnownPaths) -> Goal {
    let parts = spec.commands.iter().map(|term| {
        let binding = grant.bindings[term.claim];
        let command = command(&term.task, grant, view, known);
        Part { resource: binding.resource, access: binding.access, mode: term.mode, command }
    });
    Goal { leaf: grant.leaf(), parts: parts.collect(), takes: spec.takes, timeout: spec.timeout }
}

fn command(task: &Task, grant: &Grant, view: &View, known: &mut KnownPaths) -> Command {
    let (geometry, world_state) = (view.geometry(), view.state.world());
    let holder = |claim: usize| {
        let resource = grant.bindings[claim].resource;
        let at = view.mission.robot.carried_at(resource).expect("what is grasped from or put into has a position");
        (at, Some(resource))
    };
    match *task {
        Task::DriveTo(place, stand) => {
            let path = known.path(&view.free_space, world_state.base, stand);
            Command::Drive { path: path.map_or_else(|_| vec![stand], <[_]>::to_vec), place: Some(place) }
        }
        Task::Stand => Command::Stand,
        Task::Grasp(object) => {
            let at = geometry.object(world_state, object).expect("a granted grasp knows where its object is");
            let place = match world_state.objects[object.index()] {
                Location::At(place) => Some(place),
                Location::In(_) | Location::Unknown => None,
            };
            Command::Grasp { object, at: world_state.base.to_local(at), place, holder: None }
        }
        Task::Put(object, place) => {
            let at = world_state.base.to_local(geometry.spot(object, place));
            Command::Put { object, at, place: Some(place), holder: None }
        }
        Task::GraspFrom(object, claim) => {
            let (at, holder) = holder(claim);
            Command::Grasp { object, at, place: None, holder }
        }
        Task::PutInto(object, claim) => {
            let (at, holder) = holder(claim);
            Command::Put { object, at, place: None, holder }
        }
        Task::LookAt(place) => {
            Command::Look { at: world_state.base.to_local(geometry.surface(place)), place: Some(place) }
        }
        Task::Call(ref call) => Command::Call(call.clone()),
    }
}

/// How a behavior ended, given what its controllers say of the world: a success that they contradict is none.
pub fn believed(spec: &BehaviorSpec, grant: &Grant, outcome: &Outcome) -> End {
    if outcome.end != End::Succeeded {
        return outcome.end;
    }
    let against = |effect: &EffectTerm| outcome.changes.iter().find_map(|change| contradicts(*change, effect, grant));
    match spec.effects.iter().find_map(against) {
        Some(gripper) => End::Failed(Fault::Contradicted(gripper)),
        None => End::Succeeded,
    }
}

/// The gripper of which a controller says what an effect denies.
fn contradicts(said: Change, effect: &EffectTerm, grant: &Grant) -> Option<ResourceId> {
    match (*effect, said) {
        (EffectTerm::Taken(object, claim), Change::Taken(held, gripper)) => {
            (gripper == grant.bindings[claim].resource && held != object).then_some(gripper)
        }
        (EffectTerm::Taken(_, claim), Change::Emptied(gripper)) => {
            (gripper == grant.bindings[claim].resource).then_some(gripper)
        }
        (EffectTerm::LetGo(object, claim), Change::Taken(held, gripper)) => {
            (gripper == grant.bindings[claim].resource && held == object).then_some(gripper)
        }
        (EffectTerm::Lies(object, _), Change::Taken(held, gripper)) => (held == object).then_some(gripper),
        (EffectTerm::Taken(..) | EffectTerm::LetGo(..) | EffectTerm::Lies(..), _) => None,
        (EffectTerm::Stands(_) | EffectTerm::Fact(..), _) => None,
    }
}

/// What is different after a behavior: its effects where it succeeded, else what follows for slots; then what its controllers
/// say.
pub fn changes(spec: &BehaviorSpec, grant: &Grant, outcome: &Outcome, robot: &RobotSpec) -> Vec<Change> {
    let (effects, of_slots): (&[EffectTerm], _) = match outcome.end {
        End::Succeeded => (&spec.effects, Vec::new()),
        End::Failed(_) | End::Canceled | End::Interrupted => {
            (&[], slots::follows(spec, grant, &outcome.changes, robot))
        }
    };
    let effects = effects.iter().map(|effect| match *effect {
        EffectTerm::Lies(object, place) => Change::Object(object, Location::At(place)),
        EffectTerm::Taken(object, claim) => Change::Taken(object, grant.bindings[claim].resource),
        EffectTerm::LetGo(_, claim) => Change::Emptied(grant.bindings[claim].resource),
        EffectTerm::Stands(pose) => Change::Base(pose),
        EffectTerm::Fact(fact, holds) => Change::Fact(fact, holds),
    });
    effects.chain(of_slots).chain(outcome.changes.iter().copied()).collect()
}
