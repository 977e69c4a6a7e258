//! Objects in several hands: what is put down is let go by all that hold it, and what is let go is held by others.

use crate::world::View;
use ambidex_model::{
    BehaviorSpec, EffectTerm, HOLDERS_MAX, Lineage, Misheld, ObjectId, Reason, ResourceId, Selector, Task,
};

/// Whether what a behavior takes, lets go and puts down can be so, as things are held now.
///
/// # Errors
/// Who would not let go of what it puts down, or what nothing would hold.
pub(super) fn check(spec: &BehaviorSpec, view: &View, line: &Lineage<'_>) -> Result<(), Reason> {
    spec.changes.iter().try_for_each(|&object| check_one(spec, object, view, line))
}

fn check_one(spec: &BehaviorSpec, object: ObjectId, view: &View, line: &Lineage<'_>) -> Result<(), Reason> {
    let holders = view.state.world().objects[object.index()].holders();
    if holders.is_empty() {
        return Ok(());
    }
    if spec.effects.iter().any(|effect| matches!(effect, EffectTerm::Lies(put, _) if *put == object)) {
        return match keeper(spec, object, holders, view, line) {
            Some(by) => Err(Reason::Misheld(Misheld::Too { object, by })),
            None => Ok(()),
        };
    }
    // Whether the resource of a claim is surely one of the holders.
    let holds = |claim: usize| match spec.claims[claim].selector {
        Selector::Holding { object: held, .. } => held == object,
        Selector::Named(resource) => holders.contains(&resource),
        Selector::Any(_) | Selector::AnyEmpty { .. } | Selector::Empty { .. } => false,
    };
    let (mut more, mut fewer) = (0, 0);
    for effect in &spec.effects {
        match *effect {
            EffectTerm::Taken(taken, claim) => more += usize::from(taken == object && !holds(claim)),
            EffectTerm::LetGo(let_go, claim) => fewer += usize::from(let_go == object && holds(claim)),
            EffectTerm::Lies(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => {}
        }
    }
    match (holders.len() + more).saturating_sub(fewer) {
        0 => Err(Reason::Misheld(Misheld::Last { object })),
        HOLDERS_MAX.. if more > 0 && holders.len() + more > HOLDERS_MAX + fewer => {
            Err(Reason::Misheld(Misheld::Full { object }))
        }
        _ => Ok(()),
    }
}

/// A holder that would not let go as the object is put down: no claim of the behavior is for it. One of another branch of
/// the task comes first.
fn keeper(
    spec: &BehaviorSpec,
    object: ObjectId,
    holders: &[ResourceId],
    view: &View,
    line: &Lineage<'_>,
) -> Option<ResourceId> {
    let is_named = |holder: &&ResourceId| {
        let mut claims = spec.claims.iter().enumerate();
        claims.any(|(index, claim)| claim.selector == Selector::Named(**holder) && lets_go(spec, index, **holder, view))
    };
    let left: Vec<ResourceId> = holders.iter().filter(|holder| !is_named(holder)).copied().collect();
    let is_for_it = |selector| matches!(selector, Selector::Holding { object: held, .. } if held == object);
    let claimed = spec.claims.iter().filter(|claim| is_for_it(claim.selector)).count();
    let is_others = |holder: &ResourceId| {
        let leases = view.state.table().resource(*holder).leases();
        !leases.is_empty() && !leases.iter().any(|lease| line.contains(lease.holder))
    };
    let keeper = left.iter().copied().find(is_others).or(left.last().copied());
    keeper.filter(|_| left.len() > claimed)
}

/// Whether the resource of a claim is told to let go of something, or nobody need tell it.
fn lets_go(spec: &BehaviorSpec, claim: usize, resource: ResourceId, view: &View) -> bool {
    let is_told = |task: &Task| task.put().is_some() || matches!(task, Task::Call(_));
    view.mission.robot.arm(resource).is_none()
        || spec.commands.iter().any(|term| term.claim == claim && is_told(&term.task))
}
