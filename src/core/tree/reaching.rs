//! What no hand reaches, wherever the base comes to stand: known before anything moves.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point3;

use crate::behavior;
use crate::world::Geometry;
use ambidex_model::state::State;
use ambidex_model::{
    BehaviorSpec, CommandTerm, Condition, EffectTerm, Location, MissionSpec, NodeId, ObjectId, PlaceId, Pose, Reason,
    ResourceId, Task,
};

/// Where things can come to lie and which hands can come to hold them, by what some behaviors do.
pub(super) struct Reaching<'a> {
    mission: &'a MissionSpec,
    state: &'a State,
    holders: BTreeMap<ObjectId, BTreeSet<ResourceId>>,
    /// Where they can be put.
    places: BTreeMap<ObjectId, BTreeSet<PlaceId>>,
    /// Where the base stands, and can come to stand, by where that is.
    stops: BTreeMap<[u64; 3], Pose>,
}

/// From where something is reached.
enum From {
    /// From a stop to which a path leads.
    Open,
    /// Only from stops to which none leads.
    Closed,
    Nowhere,
    /// Nothing is known of where the base can come to stand there.
    Unknown,
}

impl<'a> Reaching<'a> {
    /// As things are, with what those behaviors may yet do.
    pub(super) fn new(mission: &'a MissionSpec, state: &'a State, leaves: impl Iterator<Item = NodeId>) -> Self {
        let (mut holders, mut places) = (BTreeMap::<_, BTreeSet<_>>::new(), BTreeMap::<_, BTreeSet<_>>::new());
        for (index, at) in state.world().objects.iter().enumerate() {
            holders.entry(ObjectId::from(index)).or_default().extend(at.holders());
        }
        let key = |pose: &Pose| [pose.at.x, pose.at.y, pose.heading].map(f64::to_bits);
        let mut stops = BTreeMap::from([(key(&state.world().base), state.world().base)]);
        for spec in leaves.filter_map(|leaf| mission.tree.behavior(leaf)).flat_map(BehaviorSpec::anywhere) {
            let at_stands = spec.stands.iter().flat_map(|stands| stands.iter());
            stops.extend(at_stands.chain([spec]).filter_map(behavior::driven_to).map(|stop| (key(&stop), stop)));
            for effect in &spec.effects {
                match *effect {
                    EffectTerm::Taken(object, claim) => {
                        let hands = mission.robot.could_serve(spec.claims[claim].selector);
                        holders.entry(object).or_default().extend(hands);
                    }
                    EffectTerm::Lies(object, place) => drop(places.entry(object).or_default().insert(place)),
                    EffectTerm::LetGo(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => {}
                }
            }
        }
        Self { mission, state, holders, places, stops }
    }

    /// Why a behavior can never take or put down what it is to.
    pub(super) fn lacks(&self, leaf: NodeId, is_open: &mut dyn FnMut(&Pose) -> bool) -> Option<Reason> {
        let spec = self.mission.tree.behavior(leaf)?;
        spec.commands.iter().find_map(|term| match term.task {
            Task::Grasp(object) => self.lacks_to_grasp(spec, term, object, is_open),
            Task::Put(object, place) => self.lacks_to_put(spec, term, (object, place), is_open),
            Task::DriveTo(..) | Task::Stand | Task::GraspFrom(..) | Task::PutInto(..) => None,
            Task::LookAt(_) | Task::Call(_) => None,
        })
    }

    fn lacks_to_grasp(
        &self,
        spec: &BehaviorSpec,
        term: &CommandTerm,
        object: ObjectId,
        is_open: &mut dyn FnMut(&Pose) -> bool,
    ) -> Option<Reason> {
        let hands = self.mission.robot.could_serve(spec.claims[term.claim].selector);
        let geometry = Geometry::of(self.mission);
        let fixed = lies(&spec.precondition, object).filter(|_| spec.elsewhere.is_none());
        let now = self.state.world().objects[object.index()].place();
        let places: BTreeSet<_> = self.places.get(&object).into_iter().flatten().copied().chain(now).collect();
        let places = places.into_iter().filter(|place| fixed.is_none_or(|fixed| fixed == *place));
        let (mut is_shut, mut is_beyond) = (false, false);
        for place in places {
            let there = spec.elsewhere.as_ref().filter(|followed| followed.object == object);
            let there = there.map_or(spec, |followed| &followed.at[place.index()]);
            let stands = behavior::stands(&there.precondition)?;
            let approach = geometry.world.approach(object, place);
            let spots = self.spots(object, place);
            let reaches = |stand: &Pose| {
                let at = |at: &Point3<f64>, hand: &ResourceId| {
                    geometry.reach_from(stand, *hand, *at, approach, 0.0).is_some()
                };
                spots.iter().any(|spot| hands.iter().any(|hand| at(spot, hand)))
            };
            match self.from(stands, reaches, is_open) {
                From::Open => return None,
                From::Closed => is_shut = true,
                From::Nowhere => is_beyond = true,
                From::Unknown => return None,
            }
        }
        (is_shut || is_beyond).then_some(Reason::Unreachable { object, place: None, is_shut })
    }

    fn lacks_to_put(
        &self,
        spec: &BehaviorSpec,
        term: &CommandTerm,
        (object, place): (ObjectId, PlaceId),
        is_open: &mut dyn FnMut(&Pose) -> bool,
    ) -> Option<Reason> {
        let could = self.mission.robot.could_serve(spec.claims[term.claim].selector);
        let holders = self.holders.get(&object)?;
        let hands: Vec<_> = could.into_iter().filter(|hand| holders.contains(hand)).collect();
        let stands = behavior::stands(&spec.precondition)?;
        let geometry = Geometry::of(self.mission);
        let reaches = |stand: &Pose| hands.iter().any(|hand| geometry.puts_from(stand, *hand, (object, place), 0.0));
        match self.from(stands, reaches, is_open) {
            _ if hands.is_empty() => None,
            From::Open | From::Unknown => None,
            From::Closed => Some(Reason::Unreachable { object, place: Some(place), is_shut: true }),
            From::Nowhere => Some(Reason::Unreachable { object, place: Some(place), is_shut: false }),
        }
    }

    /// From which stops at some stands something is reached; where the base is already it needs no path.
    fn from(
        &self,
        (stands, tolerance_m): (&[Pose], f64),
        reaches: impl Fn(&Pose) -> bool,
        is_open: &mut dyn FnMut(&Pose) -> bool,
    ) -> From {
        let base = self.state.world().base;
        let mut found = From::Unknown;
        for stop in self.stops.values().filter(|stop| behavior::is_at(**stop, stands, tolerance_m)) {
            match reaches(stop) {
                true if *stop == base || is_open(stop) => return From::Open,
                true => found = From::Closed,
                false if matches!(found, From::Unknown) => found = From::Nowhere,
                false => {}
            }
        }
        found
    }

    /// Where an object lies at a place, and may be put there.
    fn spots(&self, object: ObjectId, place: PlaceId) -> Vec<Point3<f64>> {
        let (world, world_state) = (&self.mission.world, self.state.world());
        let is_there = world_state.objects[object.index()] == Location::At(place);
        let now = is_there.then(|| world.object(world_state, object)).flatten();
        let is_put = self.places.get(&object).is_some_and(|places| places.contains(&place));
        let put = is_put.then(|| world.spots(object, place));
        now.into_iter().chain(put.into_iter().flatten()).collect()
    }
}

/// Where an object is to lie.
fn lies(condition: &Condition, object: ObjectId) -> Option<PlaceId> {
    match condition {
        Condition::All(parts) => parts.iter().find_map(|part| lies(part, object)),
        Condition::Lies(other, place) if *other == object => Some(*place),
        Condition::Never | Condition::At { .. } | Condition::Path { .. } | Condition::Held(_) => None,
        Condition::Free(_) | Condition::Somewhere(_) | Condition::Lies(..) | Condition::Fact(..) => None,
    }
}
