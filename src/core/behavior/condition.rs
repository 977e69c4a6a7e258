//! Conditions over world and line.

use crate::world::{NoPath, View};
use ambidex_model::{
    BehaviorSpec, Condition, EffectTerm, Hold, Lineage, Location, NodeId, ObjectId, PlaceId, Pose, Reason, ResourceId,
    Task,
};

/// Whether a condition is met.
///
/// # Errors
/// What is not so; [`Condition::Never`] has no better word than that the goal is not met by itself.
pub fn check(condition: &Condition, view: &View, line: &Lineage<'_>) -> Result<(), Reason> {
    let world_state = view.state.world();
    match condition {
        Condition::All(parts) => parts.iter().try_for_each(|part| check(part, view, line)),
        Condition::Never => Err(Reason::NotItsTurn { after: line.node }),
        Condition::At { place, stands, tolerance_m } => match view.driver() {
            Some(by) => Err(Reason::Driving { by }),
            None => met(is_at(world_state.base, stands, *tolerance_m), || Reason::NotAt { place: *place }),
        },
        Condition::Path { place, stands } => {
            let no_paths = stands.iter().map(|stand| view.ways.to(*stand).err()).collect::<Option<Vec<_>>>();
            // That none was found says less than that there is none.
            let no_path = no_paths.and_then(|all| all.into_iter().max_by_key(|one| *one != NoPath::Closed));
            no_path.map_or(Ok(()), |no_path| Err(unreached(no_path, *place)))
        }
        Condition::Held(hold) => {
            let found = held(*hold, view, line);
            let is_alone = !hold.alone || view.mission.robot.is_held_alone(*hold, world_state);
            met(found >= hold.hands && is_alone, || hold.reason(found))
        }
        Condition::Free(object) => not_taken(*object, view),
        Condition::Somewhere(object) => {
            not_taken(*object, view)?;
            let is_lost = world_state.objects[object.index()] == Location::Unknown;
            met(!is_lost, || Reason::Nowhere { object: *object })
        }
        Condition::Lies(object, place) => {
            let is_there = world_state.objects[object.index()] == Location::At(*place);
            met(is_there, || Reason::Elsewhere { object: *object, place: *place })
        }
        Condition::Fact(fact, holds) => {
            met(world_state.facts[fact.index()] == *holds, || Reason::Fact { fact: *fact, holds: *holds })
        }
    }
}

/// Where the base may stand for a behavior, and how near to it counts, meters; none where nothing tells.
pub fn stands(condition: &Condition) -> Option<(&[Pose], f64)> {
    match condition {
        Condition::All(parts) => parts.iter().find_map(stands),
        Condition::At { stands, tolerance_m, .. } => Some((stands, *tolerance_m)),
        Condition::Never
        | Condition::Path { .. }
        | Condition::Held(_)
        | Condition::Free(_)
        | Condition::Somewhere(_) => None,
        Condition::Lies(..) | Condition::Fact(..) => None,
    }
}

/// How many that count hold an object for this line. What nobody has a lease of counts as its own.
fn held(hold: Hold, view: &View, line: &Lineage<'_>) -> u32 {
    let is_own = |holder: &&ResourceId| {
        let leases = view.state.table().resource(**holder).leases();
        leases.is_empty() || leases.iter().any(|lease| line.contains(lease.holder))
    };
    let holders = view.state.world().objects[hold.object.index()].holders().iter();
    holders.filter(|holder| view.mission.robot.counts(hold.by, **holder)).filter(is_own).count() as u32
}

fn not_taken(object: ObjectId, view: &View) -> Result<(), Reason> {
    match view.state.world().objects[object.index()].holders().first() {
        Some(&by) => Err(Reason::Taken { object, by }),
        None => Ok(()),
    }
}

/// A condition in its single parts, in their order.
pub(crate) fn singles(condition: &Condition) -> impl Iterator<Item = &Condition> {
    let mut rest = vec![condition];
    std::iter::from_fn(move || {
        while let Some(next) = rest.pop() {
            let Condition::All(parts) = next else { return Some(next) };
            rest.extend(parts.iter().rev());
        }
        None
    })
}

/// Why a single condition is not met.
fn unmet(single: &Condition, view: &View, line: &Lineage<'_>) -> Option<Reason> {
    check(single, view, line).err()
}

/// What success makes so, by what the kind promises; a base stands where it was to drive.
pub(crate) fn promised(spec: &BehaviorSpec) -> impl Iterator<Item = EffectTerm> {
    let drives = spec.commands.iter().filter_map(|term| match term.task {
        Task::DriveTo(_, stand) => Some(EffectTerm::Stands(stand)),
        Task::Stand
        | Task::Grasp(_)
        | Task::GraspFrom(..)
        | Task::Put(..)
        | Task::PutInto(..)
        | Task::LookAt(_)
        | Task::Call(_) => None,
    });
    spec.effects.iter().copied().chain(drives)
}

/// Where a behavior brings the base.
pub(crate) fn driven_to(spec: &BehaviorSpec) -> Option<Pose> {
    promised(spec).find_map(|effect| match effect {
        EffectTerm::Stands(stand) => Some(stand),
        EffectTerm::Fact(..) | EffectTerm::Lies(..) | EffectTerm::Taken(..) | EffectTerm::LetGo(..) => None,
    })
}

/// Where the base stands for a behavior, or is brought by it.
pub(crate) fn stand(spec: &BehaviorSpec) -> Option<Pose> {
    driven_to(spec).or_else(|| stands(&spec.precondition)?.0.first().copied())
}

/// Whether success makes a single condition true.
pub(crate) fn makes_so(spec: &BehaviorSpec, condition: &Condition) -> bool {
    promised(spec).any(|effect| becomes_so(effect, condition))
}

/// Whether an effect makes a single condition true.
pub(crate) fn becomes_so(effect: EffectTerm, condition: &Condition) -> bool {
    match (effect, condition) {
        (EffectTerm::Stands(pose), Condition::At { stands, tolerance_m, .. }) => is_at(pose, stands, *tolerance_m),
        (EffectTerm::Taken(object, _), Condition::Held(wanted)) => object == wanted.object,
        (EffectTerm::LetGo(object, _), Condition::Held(wanted)) => wanted.alone && object == wanted.object,
        (EffectTerm::Lies(object, _), Condition::Free(wanted) | Condition::Somewhere(wanted)) => object == *wanted,
        (EffectTerm::Lies(object, place), Condition::Lies(wanted, at)) => (object, place) == (*wanted, *at),
        (EffectTerm::Fact(fact, holds), Condition::Fact(wanted, so)) => (fact, holds) == (*wanted, *so),
        (
            EffectTerm::Stands(_)
            | EffectTerm::Taken(..)
            | EffectTerm::LetGo(..)
            | EffectTerm::Lies(..)
            | EffectTerm::Fact(..),
            _,
        ) => false,
    }
}

/// What a blocked leaf lacks of its precondition, if that is the reason that it gave.
pub(crate) fn lacking<'a>(spec: &'a BehaviorSpec, view: &View, leaf: NodeId, reason: &Reason) -> Option<&'a Condition> {
    let line = Lineage { topology: &view.mission.tree.topology, node: leaf, skips: &[] };
    let first = singles(&spec.precondition).find_map(|single| Some((single, unmet(single, view, &line)?)));
    first.filter(|(_, said)| said == reason).map(|(single, _)| single)
}

/// Whether a leaf that sent a behavior back still lacks what that makes so.
pub(crate) fn is_needed(maker: &BehaviorSpec, view: &View, leaf: NodeId) -> bool {
    let line = Lineage { topology: &view.mission.tree.topology, node: leaf, skips: &[] };
    let spec = view.behavior(leaf).filter(|_| !view.state.is_done(leaf));
    let lacks = |single: &Condition| makes_so(maker, single) && unmet(single, view, &line).is_some();
    spec.is_some_and(|spec| singles(&spec.precondition).any(lacks))
}

fn unreached(no_path: NoPath, place: PlaceId) -> Reason {
    match no_path {
        NoPath::Closed => Reason::NoPath { place },
        NoPath::Beyond(steps) => Reason::PathNotFound { place, steps },
    }
}

fn met(is_met: bool, otherwise: impl FnOnce() -> Reason) -> Result<(), Reason> {
    if is_met { Ok(()) } else { Err(otherwise()) }
}

/// Whether it is at one of these stands.
pub(crate) fn is_at(base: Pose, stands: &[Pose], tolerance_m: f64) -> bool {
    stands.iter().any(|stand| base.distance_m(stand) <= tolerance_m)
}
