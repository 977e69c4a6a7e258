//! Behaviors as data: what a leaf asks for, promises and changes, read from its terms, the view and its line.

mod candidates;
mod condition;
mod goal;
mod holding;
mod slots;
mod spots;

use candidates::Serving;
pub(crate) use candidates::{could_serve, lacks_for_good, too_few};
pub(crate) use condition::{becomes_so, driven_to, is_at, is_needed, lacking, makes_so, promised, singles, stand};
pub use condition::{check, stands};
pub(crate) use goal::way;
pub use goal::{believed, changes, goal};
pub(crate) use slots::understood;

use crate::world::View;
use ambidex_model::{
    BehaviorSpec, Distance, Lineage, Measured, NodeId, ObjectId, Pose, Potential, Reason, Request, ResourceId, Task,
    TypeId,
};

/// What a behavior says to an activation.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// Its goal is met.
    Satisfied,
    /// It wants to run.
    Request(Request),
    /// It cannot run now.
    Blocked(Reason),
}

/// Of a hand and an object that it would take, the first behavior that would need it to reach farther than it does; told by
/// whoever knows what comes later.
pub type Ahead<'a> = &'a dyn Fn(ResourceId, ObjectId) -> Option<NodeId>;

/// Where a behavior asks from.
#[derive(Clone, Copy)]
pub struct Asking<'a> {
    /// What is so.
    pub view: &'a View,
    /// Whose leases are its own.
    pub line: &'a Lineage<'a>,
    /// What is asked later of what it takes.
    pub ahead: Ahead<'a>,
}

/// Whether the behavior's goal is met.
pub fn is_satisfied(spec: &BehaviorSpec, view: &View, line: &Lineage<'_>) -> bool {
    check(&spec.satisfied, view, line).is_ok()
}

/// What a behavior says that was sent back by a leaf: it is not satisfied while it is needed, whatever its goal, and is
/// once it is not.
pub fn answer_again(spec: &BehaviorSpec, asking: &Asking<'_>, by: NodeId) -> Answer {
    if !is_needed(spec, asking.view, by) {
        return Answer::Satisfied;
    }
    request(spec, asking, None).map_or_else(Answer::Blocked, Answer::Request)
}

/// What a behavior that is not done says (III-B, III-C).
pub fn answer(spec: &BehaviorSpec, asking: &Asking<'_>) -> Answer {
    if is_satisfied(spec, asking.view, asking.line) {
        return Answer::Satisfied;
    }
    request(spec, asking, None).map_or_else(Answer::Blocked, Answer::Request)
}

/// What a behavior would ask for if nothing ran and nothing less urgent kept anything for an intention; none where that is
/// not all that it waits for.
pub fn wish(spec: &BehaviorSpec, asking: &Asking<'_>, priority: i32) -> Option<Request> {
    request(spec, asking, Some(priority)).ok()
}

/// What a behavior asks for; with the patience of who wishes for it, whatever runs.
fn request(spec: &BehaviorSpec, asking: &Asking<'_>, patience: Option<i32>) -> Result<Request, Reason> {
    let Asking { view, line, .. } = *asking;
    check(&spec.precondition, view, line)?;
    let (potential, distance) = potential(&spec.potential, view, line)?;
    if let Some(reason) = changed_by_another(spec, view).filter(|_| patience.is_none()) {
        return Err(reason);
    }
    check_grasps(spec, view)?;
    holding::check(spec, view, line)?;
    let claims = candidates::options(spec, &Serving { view, line, ahead: asking.ahead, patience })?;
    let spots = spots::choose(spec, &claims, view)?;
    Ok(Request {
        leaf: line.node,
        priority: 0,
        iterations: 0,
        potential,
        heir: view.is_heir(line),
        claims,
        changes: spec.changes.clone(),
        skips: line.skips.to_vec(),
        place: None,
        stand: None,
        spots,
        distance,
    })
}

/// A running behavior that changes an object that this one changes.
fn changed_by_another(spec: &BehaviorSpec, view: &View) -> Option<Reason> {
    spec.changes.iter().find_map(|&object| {
        let mut others = view.state.running().iter();
        let (&with, _) = others.find(|(_, grant)| grant.request.changes.contains(&object))?;
        Some(Reason::SameObject { object, with })
    })
}

/// What is to be grasped is somewhere.
fn check_grasps(spec: &BehaviorSpec, view: &View) -> Result<(), Reason> {
    for term in &spec.commands {
        if let Task::Grasp(object) = term.task
            && view.mission.world.object(view.state.world(), object).is_none()
        {
            return Err(Reason::OutOfReach { object });
        }
    }
    Ok(())
}

/// Activation potential, greater than 0; a potential of 0 means not to ask. n is 1 when the robot has none of the type.
fn potential(potential: &Potential, view: &View, line: &Lineage<'_>) -> Result<(f64, Option<Measured>), Reason> {
    match *potential {
        Potential::Constant(0.0) | Potential::Scaled { value: 0.0, .. } => Err(Reason::Unwanted),
        Potential::Constant(value) => Ok((value, None)),
        Potential::Scaled { value, by } => Ok((value * scale(by, view, line)?, None)),
        Potential::Nearness { to, floor_m, scale_by } => {
            let available = scale_by.map_or(Ok(1.0), |of| scale(of, view, line))?;
            let measured = measured(to, view);
            Ok((available / measured.meters.max(floor_m), Some(measured)))
        }
    }
}

/// How far it is to a pose, as the world has it; straight where no path is found.
fn measured(to: Pose, view: &View) -> Measured {
    let base = view.state.world().base;
    let straight = Measured { meters: base.distance_m(&to), along: Distance::Straight };
    match view.mission.world.distance {
        Distance::Straight => straight,
        Distance::Path => view.ways.to(to).map_or(straight, |path| {
            let legs = std::iter::once(&base).chain(path).zip(path);
            Measured { meters: legs.map(|(from, to)| from.distance_m(to)).sum(), along: Distance::Path }
        }),
    }
}

/// The factor that a type gives to a potential.
fn scale(of: TypeId, view: &View, line: &Lineage<'_>) -> Result<f64, Reason> {
    if view.mission.robot.of_type(of).next().is_none() {
        return Ok(1.0);
    }
    match available(of, view, line) {
        0 => Err(Reason::NothingAvailable { of }),
        count => Ok(count as f64),
    }
}

/// The n of equation (1): resources of a type that are free or held by the behavior's own line.
fn available(of: TypeId, view: &View, line: &Lineage<'_>) -> usize {
    let is_available = |id| {
        let resource = view.state.table().resource(id);
        let is_there = resource.service().is_available();
        is_there && (!resource.is_locked() || resource.leases().iter().any(|lease| line.contains(lease.holder)))
    };
    view.mission.robot.of_type(of).filter(|&id| is_available(id)).count()
}
