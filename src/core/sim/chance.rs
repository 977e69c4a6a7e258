//! What goes wrong by chance, drawn from a seed for each attempt of a behavior: the same for the same attempt, whatever
//! else happens, so that two allocators or two versions of a task meet with the same.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use ambidex_model::{
    Change, ControllerId, FactId, Failures, Flaw, FlawKind, Goal, Location, Mishap, MissionSpec, NodeId, ObjectId,
    PlaceId, Time, WorldState,
};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// How late a behavior may be, and when within an attempt something may happen, robot seconds.
const WITHIN_S: f64 = 8.0;
/// How long a controller may be away that comes back, robot seconds.
const AWAY_S: std::ops::Range<f64> = 1.0..20.0;
/// How many of four lost or hung controllers come back.
const RETURN_OF_FOUR: u32 = 3;

/// How probable it is that something goes wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chance {
    /// Of each attempt of a behavior, from 0 to 1.
    pub probability: f64,
    /// What is drawn follows from it.
    pub seed: u64,
}

/// What can go wrong in an attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Hazard {
    Fails,
    Hangs,
    Late,
    Drops,
    Lose,
    Hang,
    Inhibit,
    Fact,
    Object,
}

const HAZARDS: [Hazard; 9] = [
    Hazard::Fails,
    Hazard::Hangs,
    Hazard::Late,
    Hazard::Drops,
    Hazard::Lose,
    Hazard::Hang,
    Hazard::Inhibit,
    Hazard::Fact,
    Hazard::Object,
];

/// What was drawn for one attempt; at most one thing goes wrong, and a controller may come back from it.
#[derive(Debug, Default)]
pub(super) struct Drawn {
    pub(super) flaw: Option<Flaw>,
    pub(super) mishaps: Vec<(Time, Mishap)>,
}

/// All that was drawn so far.
pub(super) struct Draws {
    mission: Arc<MissionSpec>,
    chance: Chance,
    attempts: BTreeMap<NodeId, u32>,
    /// Until when each controller is not to be struck again.
    away: BTreeMap<ControllerId, Time>,
    failures: Failures,
}

impl Draws {
    pub(super) fn new(mission: &Arc<MissionSpec>, chance: Chance, failures: Failures) -> Self {
        let (attempts, away) = (BTreeMap::new(), BTreeMap::new());
        Self { mission: Arc::clone(mission), chance, attempts, away, failures }
    }

    /// Everything that goes wrong in the run, mishaps in their order.
    pub(super) fn into_failures(self) -> Failures {
        let Failures { mut mishaps, flaws } = self.failures;
        mishaps.sort_by_key(|(at, _)| *at);
        Failures { mishaps, flaws }
    }

    /// What goes wrong in the attempt of a behavior that begins now.
    pub(super) fn draw(&mut self, now: Time, goal: &Goal, world_state: &WorldState) -> Drawn {
        let attempt = self.attempts.entry(goal.leaf).or_default();
        *attempt += 1;
        let attempt = *attempt;
        let mut rng = self.rng(goal.leaf, attempt);
        if !rng.random_bool(self.chance.probability) {
            return Drawn::default();
        }
        let struck = self.strikable(now, goal);
        let possible: Vec<Hazard> =
            HAZARDS.into_iter().filter(|hazard| self.can_happen(*hazard, goal, &struck, world_state)).collect();
        let hazard = possible[rng.random_range(0..possible.len())];
        let flaw = |kind| Drawn { flaw: Some(Flaw { leaf: goal.leaf, attempt: Some(attempt), kind }), mishaps: vec![] };
        let at = now + seconds(rng.random_range(0.0..WITHIN_S));
        let drawn = match hazard {
            Hazard::Fails => flaw(FlawKind::Fails),
            Hazard::Hangs => flaw(FlawKind::Hangs),
            Hazard::Late => flaw(FlawKind::Late(at - now)),
            Hazard::Drops => flaw(FlawKind::Drops(None)),
            Hazard::Lose => self.strike(Mishap::Lose, &struck, at, &mut rng),
            Hazard::Hang => self.strike(Mishap::Hang, &struck, at, &mut rng),
            Hazard::Inhibit => self.strike(Mishap::Inhibit, &struck, at, &mut rng),
            Hazard::Fact => {
                let fact = one(&self.outside(), &mut rng);
                happens(at, Mishap::World(Change::Fact(fact, !world_state.facts[fact.index()])))
            }
            Hazard::Object => {
                let object = one(&lying(world_state), &mut rng);
                let place = PlaceId::from(rng.random_range(0..self.mission.world.places.len()));
                happens(at, Mishap::World(Change::Object(object, Location::At(place))))
            }
        };
        self.failures.flaws.extend(drawn.flaw);
        self.failures.mishaps.extend(&drawn.mishaps);
        drawn
    }

    /// A stream of its own for each attempt.
    fn rng(&self, leaf: NodeId, attempt: u32) -> ChaCha8Rng {
        let mut seed = [0; 32];
        seed[..8].copy_from_slice(&self.chance.seed.to_le_bytes());
        seed[8..12].copy_from_slice(&leaf.0.to_le_bytes());
        seed[12..16].copy_from_slice(&attempt.to_le_bytes());
        ChaCha8Rng::from_seed(seed)
    }

    /// The controllers of a goal that are there, as far as chance goes.
    fn strikable(&self, now: Time, goal: &Goal) -> Vec<ControllerId> {
        let resources = &self.mission.robot.resources;
        let of_goal = goal.parts.iter().filter_map(|part| resources[part.resource.index()].controller);
        let mut struck: Vec<_> = of_goal.filter(|id| self.away.get(id).is_none_or(|until| *until < now)).collect();
        struck.sort_unstable();
        struck.dedup();
        struck
    }

    fn can_happen(&self, hazard: Hazard, goal: &Goal, struck: &[ControllerId], world_state: &WorldState) -> bool {
        match hazard {
            Hazard::Fails => !goal.parts.is_empty(),
            Hazard::Hangs | Hazard::Late => true,
            Hazard::Drops => world_state.objects.iter().any(|at| !at.holders().is_empty()),
            Hazard::Lose | Hazard::Hang | Hazard::Inhibit => !struck.is_empty(),
            Hazard::Fact => !self.outside().is_empty(),
            Hazard::Object => !lying(world_state).is_empty() && !self.mission.world.places.is_empty(),
        }
    }

    /// Facts that others may set and clear.
    fn outside(&self) -> Vec<FactId> {
        let facts = (0..self.mission.names.facts.len()).map(FactId::from);
        facts.filter(|fact| self.mission.world.is_outside(*fact)).collect()
    }

    /// One of these controllers goes, and mostly comes back; one that is inhibited always does, since it is awaited
    /// without limit.
    fn strike(
        &mut self,
        how: fn(ControllerId) -> Mishap,
        struck: &[ControllerId],
        at: Time,
        rng: &mut ChaCha8Rng,
    ) -> Drawn {
        let id = one(struck, rng);
        let back = at + seconds(rng.random_range(AWAY_S));
        let returns = how(id) == Mishap::Inhibit(id) || rng.random_ratio(RETURN_OF_FOUR, 4);
        self.away.insert(id, if returns { back } else { Time(u64::MAX) });
        let mut drawn = happens(at, how(id));
        drawn.mishaps.extend(returns.then_some((back, Mishap::Return(id))));
        drawn
    }
}

fn happens(at: Time, mishap: Mishap) -> Drawn {
    Drawn { flaw: None, mishaps: vec![(at, mishap)] }
}

fn seconds(seconds: f64) -> Duration {
    // As exactly as a failure file says it.
    Duration::from_millis((seconds * 1e3).ceil() as u64)
}

/// Objects that nothing holds.
fn lying(world_state: &WorldState) -> Vec<ObjectId> {
    let objects = world_state.objects.iter().enumerate();
    objects.filter(|(_, at)| at.holders().is_empty()).map(|(object, _)| object.into()).collect()
}

fn one<T: Copy>(of: &[T], rng: &mut ChaCha8Rng) -> T {
    of[rng.random_range(0..of.len())]
}
