//! Where objects are: nothing is taken into a full hand, nothing vanishes, and what others say moves nothing that is held.

use ambidex_model::{Change, ControllerId, EffectTerm, End, Location, ObjectId, Origin, Record, ResourceId};

use super::run::Run;
use super::{Found, LookedAt, Rule};

/// Looks at every change of where an object is.
pub(super) fn take(run: &Run, record: &Record, found: &mut Found, looked_at: &mut LookedAt) {
    if !Run::is_about_world(record) {
        return;
    }
    if let Record::Began { world_state, .. } = record {
        shared_hands(run, &world_state.objects, found);
    }
    let mut world = run.world.clone();
    for change in Run::changes(record) {
        let object = change.moved().map(|(object, _)| object);
        if object.is_some_and(|object| object.index() >= world.objects.len()) {
            found.push(Rule::Objects, "it is about an object that the mission does not have".to_owned());
            continue;
        }
        let before = world.objects.clone();
        if !matches!(change, Change::Fact(fact, _) if fact.index() >= world.facts.len()) {
            world.apply(*change);
        }
        looked_at.moves += before.iter().zip(&world.objects).filter(|(was, is)| was != is).count() as u64;
        pushed_out(run, change, &before, &world.objects, found);
        moved_by_others(run, record, change, &before, found);
    }
    succeeded(run, record, &world.objects, found);
}

/// An object that a change is not about has lost its holder by it.
fn pushed_out(run: &Run, change: &Change, before: &[Location], now: &[Location], found: &mut Found) {
    let about = |object: ObjectId| match change {
        Change::Object(moved, _) | Change::Laid(moved, ..) | Change::Taken(moved, _) => *moved == object,
        Change::Emptied(_) => true,
        Change::Base(_) | Change::Fact(..) | Change::Blocked(_) | Change::Cleared(_) => false,
    };
    for (index, (was, is)) in before.iter().zip(now).enumerate() {
        let object = ObjectId::from(index);
        if was != is && !about(object) {
            let hands: Vec<_> = was.holders().iter().map(|holder| run.names.resource(*holder)).collect();
            let object = run.names.object(object);
            found
                .push(Rule::Objects, format!("{object} is in {} and something else is put there", hands.join(" and ")));
        }
    }
}

/// What is held is moved by its controller's word only, or on purpose.
fn moved_by_others(run: &Run, record: &Record, change: &Change, before: &[Location], found: &mut Found) {
    let Record::World { origin, .. } = record else { return };
    let Some((object, _)) = change.moved() else { return };
    // A hand says what it has taken itself.
    if matches!((change, origin), (Change::Taken(_, by), Origin::Controller(id)) if moves(run, *id, *by)) {
        return;
    }
    let is_held = before.get(object.index()).is_some_and(|at| !at.holders().is_empty());
    let is_bound = match origin {
        Origin::Operator => true,
        // An arm tells of its own hand, a sensor of what lies.
        Origin::Controller(id) => !holds(run, *id, before[object.index()].holders()),
        Origin::Script | Origin::Dropped | Origin::Resumed => false,
    };
    if is_held && is_bound {
        let object = run.names.object(object);
        found.push(Rule::Objects, format!("{object} is moved from outside while it is held"));
    }
}

fn holds(run: &Run, id: ControllerId, holders: &[ResourceId]) -> bool {
    holders.iter().any(|holder| moves(run, id, *holder))
}

/// Whether a controller moves a resource, as far as that is known.
fn moves(run: &Run, id: ControllerId, resource: ResourceId) -> bool {
    let resources = run.mission.as_ref().map(|mission| &mission.robot.resources);
    resources.and_then(|all| all.get(resource.index())).is_none_or(|spec| spec.controller == Some(id))
}

/// A success leaves what its kind promises.
fn succeeded(run: &Run, record: &Record, now: &[Location], found: &mut Found) {
    let Record::Released { leaf, end: End::Succeeded, .. } = record else { return };
    let Some(grant) = run.running.get(leaf) else { return };
    let Some(spec) = run.behavior(grant) else { return };
    for effect in &spec.effects {
        let (object, is_so) = match *effect {
            EffectTerm::Lies(object, place) => (object, now[object.index()] == Location::At(place)),
            EffectTerm::Taken(object, claim) => {
                let by = grant.bindings.get(claim).map(|binding| binding.resource);
                (object, by.is_some_and(|by| now[object.index()].holders().contains(&by)))
            }
            EffectTerm::LetGo(object, claim) => {
                let by = grant.bindings.get(claim).map(|binding| binding.resource);
                (object, by.is_none_or(|by| !now[object.index()].holders().contains(&by)))
            }
            EffectTerm::Stands(_) | EffectTerm::Fact(..) => continue,
        };
        if !is_so {
            let (name, object) = (run.name(*leaf), run.names.object(object));
            found.push(Rule::Objects, format!("{name} succeeded, and {object} is not where it was to bring it"));
        }
    }
}

/// No hand holds two objects.
fn shared_hands(run: &Run, objects: &[Location], found: &mut Found) {
    let mut hands: Vec<(ResourceId, usize)> = Vec::new();
    for (index, at) in objects.iter().enumerate() {
        for holder in at.holders() {
            if let Some((_, other)) = hands.iter().find(|(hand, _)| hand == holder) {
                let (one, two) = (run.names.object(ObjectId::from(*other)), run.names.object(ObjectId::from(index)));
                let hand = run.names.resource(*holder);
                found.push(Rule::Objects, format!("{hand} holds {one} and {two}"));
            }
            hands.push((*holder, index));
        }
    }
}
