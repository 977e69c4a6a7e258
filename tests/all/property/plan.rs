//! What will happen outside the tree, fixed by the seed alone: durations, outcomes, changes of the world.

use std::time::Duration;

use ambidex::model::{
    Change, ControllerId, EffectTerm, End, FactId, Fault, Grant, Location, Loss, MissionSpec, ObjectId, Origin,
    Outcome, PlaceId, Rejection, ResourceId, Selector, Time,
};

use super::extras::is_endless;
use crate::driver::Rng;

/// What happens to whom, however the messages travel.
#[derive(Debug, Clone, Default)]
pub struct Plan {
    pub seed: u64,
    /// Of a hundred attempts, how many fail.
    pub failing: usize,
    /// Of a hundred successes, how many end otherwise than the kind promises.
    pub odd: usize,
    /// Of a hundred attempts, how many a controller rejects.
    pub rejecting: usize,
    /// Whether failing behaviors drop what they hold.
    pub drops: bool,
    pub changes: Vec<(Time, Change, Origin)>,
    /// Controllers that go, and come back.
    pub services: Vec<(Time, ControllerId, Option<Loss>)>,
    /// When the mission is canceled, of those that clean up or have no end.
    pub cancel: Option<Time>,
}

impl Plan {
    pub fn new(seed: u64, is_wild: bool, mission: &MissionSpec, is_clear: impl Fn(PlaceId) -> bool) -> Self {
        let mut rng = Rng::of(&[seed, 2]);
        let count = if rng.is(if is_wild { 50 } else { 8 }) { 1 + rng.below(4) } else { 0 };
        let changes = (0..count).filter_map(|_| {
            let at = Time(rng.below(20_000_000) as u64);
            let place = PlaceId::from(rng.below(mission.world.places.len()));
            let change = match rng.below(4) {
                0 if is_clear(place) => Change::Base(mission.world.places[place.index()].stand),
                1 if !mission.start.objects.is_empty() => {
                    let object = ObjectId::from(rng.below(mission.start.objects.len()));
                    Change::Object(object, Location::At(place))
                }
                2 => Change::Fact(FactId::from(rng.below(mission.start.facts.len())), rng.is(70)),
                3 if !mission.robot.resources.is_empty() => {
                    Change::Emptied(rng.below(mission.robot.resources.len()).into())
                }
                _ => return None,
            };
            Some((at, change))
        });
        let mut changes: Vec<_> = changes.collect();
        let mut others = Rng::of(&[seed, 12]);
        for fact in (0..mission.start.facts.len()).map(FactId::from).filter(|fact| mission.world.is_outside(*fact)) {
            let at = Time(others.below(30_000_000) as u64);
            if others.is(60) {
                changes.push((at, Change::Fact(fact, others.is(70))));
            }
        }
        changes.extend(brought(&mut others, mission));
        let changes = said(seed, mission, changes);
        let mut rng = Rng::of(&[seed, 5]);
        let controllers = mission.robot.controllers.len();
        let losses = if controllers > 0 && rng.is(25) { 1 + rng.below(2) } else { 0 };
        let services = (0..losses).flat_map(|_| {
            let (at, id) = (Time(rng.below(15_000_000) as u64), ControllerId::from(rng.below(controllers)));
            // Some come back in time, some late, some never.
            let back = [4_000_000, 9_000_000, 30_000_000].get(rng.below(4)).map(|away| Time(at.0 + away));
            let loss = (at, id, Some(rng.one(&[Loss::Ended, Loss::Silent, Loss::Hung])));
            [Some(loss), back.map(|back| (back, id, None))].into_iter().flatten()
        });
        let services = services.collect();
        let mut cancels = Rng::of(&[seed, 18]);
        let is_canceled = !mission.tree.topology.cleanups().is_empty() && cancels.is(30);
        let cancel = (is_canceled || is_endless(mission)).then(|| Time(cancels.below(25_000_000) as u64));
        Self {
            cancel,
            services,
            seed,
            failing: rng.one(&[0, 0, 0, 0, 5, 5, 10, 20]),
            rejecting: others.one(&[0, 0, 0, 2, 5, 15]),
            odd: if is_wild { rng.one(&[0, 10]) } else { 0 },
            drops: is_wild,
            changes,
        }
    }

    /// How long an attempt takes and how it ends.
    pub fn attempt(&self, mission: &MissionSpec, grant: &Grant, attempt: u64) -> (Duration, Outcome) {
        let mut rng = Rng::of(&[self.seed, 3, u64::from(grant.leaf().0), attempt]);
        let lasts = Duration::from_millis(100 + rng.below(5000) as u64);
        let end = if rng.is(self.failing) { End::Failed(Fault::TimedOut) } else { End::Succeeded };
        if let Some(end) = self.rejected(mission, grant, attempt) {
            return (Duration::from_millis(50), Outcome { end, changes: Vec::new() });
        }
        let is_odd = end != End::Succeeded || rng.is(self.odd);
        let changes = if is_odd { self.odd_changes(mission, grant, &mut rng) } else { Vec::new() };
        (lasts, Outcome { end, changes })
    }

    /// A controller that would not take a goal.
    fn rejected(&self, mission: &MissionSpec, grant: &Grant, attempt: u64) -> Option<End> {
        let mut rng = Rng::of(&[self.seed, 13, u64::from(grant.leaf().0), attempt]);
        let claims = mission.tree.behavior(grant.leaf()).expect("only leaves run").claims.len();
        let claimed = grant.bindings[..claims].iter();
        let controller = |resource: ResourceId| mission.robot.resources[resource.index()].controller;
        let all: Vec<_> = claimed.filter_map(|binding| controller(binding.resource)).collect();
        if all.is_empty() || !rng.is(self.rejecting) {
            return None;
        }
        let reach = Rejection::OutOfReach;
        let why = rng.one(&[reach, reach, reach, Rejection::Unsupported, Rejection::Malformed]);
        Some(End::Failed(Fault::Rejected(rng.one(&all), why)))
    }

    /// What a goal that is told to stop says in the end.
    pub fn stopped(&self, mission: &MissionSpec, grant: &Grant) -> Outcome {
        let mut rng = Rng::of(&[self.seed, 4, u64::from(grant.leaf().0)]);
        Outcome { end: End::Canceled, changes: self.odd_changes(mission, grant, &mut rng) }
    }

    /// Base somewhere else, object in the gripper all the same, or lost.
    fn odd_changes(&self, mission: &MissionSpec, grant: &Grant, rng: &mut Rng) -> Vec<Change> {
        let spec = mission.tree.behavior(grant.leaf()).expect("only leaves run");
        let mut changes = Vec::new();
        for effect in &spec.effects {
            match *effect {
                EffectTerm::Stands(mut pose) if rng.is(60) => {
                    pose.at.x += 0.1 * rng.below(8) as f64;
                    changes.push(Change::Base(pose));
                }
                EffectTerm::Taken(object, claim) if rng.is(50) => {
                    changes.push(Change::Taken(object, grant.bindings[claim].resource));
                }
                EffectTerm::Stands(_) | EffectTerm::Taken(..) => {}
                EffectTerm::LetGo(..) | EffectTerm::Lies(..) | EffectTerm::Fact(..) => {}
            }
        }
        let mut others = (0..mission.start.objects.len()).map(ObjectId::from);
        let is_taken = |effect: &EffectTerm| matches!(effect, EffectTerm::Taken(..));
        if let Some(EffectTerm::Taken(object, claim)) = spec.effects.iter().find(|effect| is_taken(effect)).copied()
            && rng.is(8)
            && let Some(other) = others.rfind(|other| *other != object)
        {
            // A controller says one thing of a gripper.
            changes.retain(|change| !matches!(change, Change::Taken(..)));
            changes.push(Change::Taken(other, grant.bindings[claim].resource));
        }
        for (claim, binding) in std::iter::zip(&spec.claims, &grant.bindings) {
            if self.drops && matches!(claim.selector, Selector::Holding { .. }) && rng.is(50) {
                changes.push(Change::Emptied(binding.resource));
            }
        }
        changes
    }

    /// When a cancel comes: after so many messages.
    pub fn cancel_after(&self) -> usize {
        Rng::of(&[self.seed, 5]).below(200)
    }
}

/// Objects that others bring where the mission would have brought them.
fn brought(rng: &mut Rng, mission: &MissionSpec) -> Vec<(Time, Change)> {
    let behaviors = mission.tree.leaves().filter_map(|leaf| mission.tree.behavior(leaf));
    let puts = behaviors.flat_map(|spec| &spec.effects).filter_map(|effect| match *effect {
        EffectTerm::Lies(object, place) => Some((object, place)),
        EffectTerm::Taken(..) | EffectTerm::LetGo(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => None,
    });
    let is_brought = rng.is(15);
    let moments = puts.map(|(object, place)| (Time(rng.below(25_000_000) as u64), object, place, rng.is(50)));
    let brought = moments.filter(|(.., is_it)| *is_it && is_brought);
    brought.map(|(at, object, place, _)| (at, Change::Object(object, Location::At(place)))).collect()
}

/// Who says all that: mostly a file of what goes wrong on purpose; operators and controllers also what they may not.
fn said(seed: u64, mission: &MissionSpec, changes: Vec<(Time, Change)>) -> Vec<(Time, Change, Origin)> {
    let mut rng = Rng::of(&[seed, 21]);
    let controllers = mission.robot.controllers.len();
    let mut who = |changes: Vec<(Time, Change)>, percent: usize| -> Vec<(Time, Change, Origin)> {
        let mut all = Vec::new();
        for (at, change) in changes {
            let is_bound = rng.is(percent);
            let origin = match rng.below(2) {
                _ if !is_bound => Origin::Script,
                0 if controllers > 0 => Origin::Controller(ControllerId::from(rng.below(controllers))),
                _ => Origin::Operator,
            };
            all.push((at, change, origin));
            // Some say everything twice.
            if is_bound && rng.is(30) {
                all.push((Time(at.0 + rng.below(3_000_000) as u64), change, origin));
            }
        }
        all
    };
    let is_open = |change: &Change| match *change {
        Change::Fact(fact, _) => mission.world.is_outside(fact),
        Change::Object(..) => true,
        Change::Base(_) | Change::Laid(..) | Change::Taken(..) | Change::Emptied(_) => false,
        Change::Blocked(_) | Change::Cleared(_) => true,
    };
    let (open, others) = changes.into_iter().partition(|(_, change)| is_open(change));
    let mut all = who(others, 0);
    all.extend(who(open, 40));
    all.extend(who(unasked(seed, mission), 100));
    all
}

/// What somebody says that the mission does not wait for.
fn unasked(seed: u64, mission: &MissionSpec) -> Vec<(Time, Change)> {
    let mut rng = Rng::of(&[seed, 22]);
    let count = if rng.is(15) { 1 + rng.below(3) } else { 0 };
    let (places, objects) = (mission.world.places.len(), mission.start.objects.len());
    let (facts, resources) = (mission.start.facts.len(), mission.robot.resources.len());
    let mut one = || {
        let at = Time(rng.below(20_000_000) as u64);
        let change = match rng.below(8) {
            0 => Change::Base(mission.world.places[rng.below(places)].stand),
            1 if resources > 0 => Change::Emptied(rng.below(resources).into()),
            2..5 if objects > 0 => {
                let place = Location::At(rng.below(places).into());
                Change::Object(rng.below(objects).into(), if rng.is(80) { place } else { Location::Unknown })
            }
            _ => Change::Fact(rng.below(facts).into(), rng.is(60)),
        };
        (at, change)
    };
    (0..count).map(|_| one()).collect()
}
