//! From a grant to a goal, and from an outcome to what is different in the world.

use super::{slots, spots};
use crate::world::View;
use ambidex_model::{
    BehaviorSpec, Change, Command, EffectTerm, End, Fault, Goal, Grant, Location, Outcome, Part, Pose, Request,
    ResourceId, RobotSpec, Task,
};

/// The way that a granted behavior drives: from where the base stands over way points to the goal; none where it drives
/// nowhere or no way is free.
pub(crate) fn way(request: &Request, view: &View) -> Vec<Pose> {
    let spec = view.mission.tree.behavior(request.leaf).map(|spec| spec.asked(request));
    let stand = spec.and_then(|spec| spec.commands.iter().find_map(|term| term.task.driven_to()));
    let way = stand.and_then(|stand| view.ways.to(stand).ok());
    way.map(|way| [&[view.state.world().base], way].concat()).unwrap_or_default()
}

/// The goal of a granted behavior, with positions as of the view it asked in.
pub fn goal(spec: &BehaviorSpec, grant: &Grant, view: &View) -> Goal {
    let parts = spec.commands.iter().map(|term| {
        let binding = grant.bindings[term.claim];
        let command = command(&term.task, grant, view);
        Part { resource: binding.resource, access: binding.access, mode: term.mode, command }
    });
    Goal { leaf: grant.leaf(), parts: parts.collect(), takes: spec.takes, timeout: spec.timeout }
}

fn command(task: &Task, grant: &Grant, view: &View) -> Command {
    let (world, world_state) = (&view.mission.world, view.state.world());
    let holder = |claim: usize| {
        let resource = grant.bindings[claim].resource;
        let at = view.mission.robot.carried_at(resource).expect("what is grasped from or put into has a position");
        (at, Some(resource))
    };
    match *task {
        Task::DriveTo(place, stand) => {
            let path = grant.way.get(1..).map_or_else(|| vec![stand], <[_]>::to_vec);
            Command::Drive { path, place: Some(place) }
        }
        Task::Stand => Command::Stand,
        Task::Grasp(object) => {
            let at = world.object(world_state, object).expect("a granted grasp knows where its object is");
            let place = match world_state.objects[object.index()] {
                Location::At(place) => Some(place),
                Location::In(_) | Location::Unknown => None,
            };
            Command::Grasp { object, at: world_state.base.to_local(at), place, holder: None }
        }
        Task::Put(object, place) => {
            let at = world_state.base.to_local(world.spot(object, place, grant.request.spot(object)));
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
            Command::Look { at: world_state.base.to_local(world.surface(place)), place: Some(place) }
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
        EffectTerm::Lies(object, place) => spots::laid(object, place, grant),
        EffectTerm::Taken(object, claim) => Change::Taken(object, grant.bindings[claim].resource),
        EffectTerm::LetGo(_, claim) => Change::Emptied(grant.bindings[claim].resource),
        EffectTerm::Stands(pose) => Change::Base(pose),
        EffectTerm::Fact(fact, holds) => Change::Fact(fact, holds),
    });
    effects.chain(of_slots).chain(outcome.changes.iter().copied()).collect()
}
