//! What no hand reaches from wherever the base comes to stand (`semantics` 6, "Infeasible").

use std::collections::BTreeSet;

use ambidex::model::{
    CommandTerm, Condition, EffectTerm, Location, NodeId, ObjectId, PlaceId, Pose, Reason, ResourceId, Selector, Task,
};

use super::Model;
use super::world::{distance_m, on_map, singles};

impl Model<'_> {
    /// Why no hand could ever do what a behavior tells it.
    pub(super) fn hands_lack(&self, leaf: NodeId) -> Option<Reason> {
        let mut left: BTreeSet<NodeId> = self.left().into_iter().collect();
        left.extend(self.running.keys().filter(|leaf| self.cleans(**leaf).is_none()));
        self.behavior(leaf).commands.iter().find_map(|term| self.hand_lacks(leaf, term, &left))
    }

    fn hand_lacks(&self, leaf: NodeId, term: &CommandTerm, left: &BTreeSet<NodeId>) -> Option<Reason> {
        let spec = self.behavior(leaf);
        let could = self.all_that_could(spec.claims[term.claim].selector);
        let effects = || left.iter().flat_map(|leaf| self.behavior(*leaf).effects.iter().map(move |term| (leaf, term)));
        let (object, goal) = match term.task {
            Task::Grasp(object) => (object, None),
            Task::Put(object, place) => (object, Some(place)),
            _ => return None,
        };
        let now = &self.world_state.objects[object.index()];
        let (hands, places): (Vec<ResourceId>, BTreeSet<PlaceId>) = match goal {
            None => {
                let put = effects().filter_map(|(_, effect)| match effect {
                    EffectTerm::Lies(other, place) if *other == object => Some(*place),
                    _ => None,
                });
                let lies = if let Location::At(place) = now { Some(*place) } else { None };
                let mut places: BTreeSet<_> = put.chain(lies).collect();
                let wanted = singles(&spec.precondition).into_iter().find_map(|part| match part {
                    Condition::Lies(other, place) if *other == object => Some(*place),
                    _ => None,
                });
                places.retain(|place| wanted.is_none_or(|wanted| wanted == *place));
                (could, places)
            }
            Some(place) => {
                let takes = |hand: &ResourceId| {
                    effects().any(|(taker, effect)| match effect {
                        EffectTerm::Taken(other, claim) if *other == object => {
                            self.all_that_could(self.behavior(*taker).claims[*claim].selector).contains(hand)
                        }
                        _ => false,
                    })
                };
                let hands = could.into_iter().filter(|hand| now.holders().contains(hand) || takes(hand)).collect();
                (hands, BTreeSet::from([place]))
            }
        };
        if places.is_empty() || goal.is_some() && hands.is_empty() {
            return None;
        }
        let stops = self.comes_to(leaf, left);
        let reaches =
            |stop: &Pose, place: &PlaceId| hands.iter().any(|hand| self.reaches_from(*stop, *hand, object, *place));
        let from: Vec<&Pose> = stops.iter().filter(|stop| places.iter().any(|place| reaches(stop, place))).collect();
        let is_open = |stop: &&Pose| **stop == self.world_state.base || self.is_clear(**stop);
        let is_shut = !from.is_empty();
        let is_reached = from.iter().any(is_open);
        (!stops.is_empty() && !is_reached).then_some(Reason::Unreachable { object, place: goal, is_shut })
    }

    /// Where the base is, or is brought by what is left, as far as that is where a behavior wants it.
    fn comes_to(&self, leaf: NodeId, left: &BTreeSet<NodeId>) -> Vec<Pose> {
        let wanted = singles(&self.behavior(leaf).precondition).into_iter().find_map(|part| match part {
            Condition::At { stands, tolerance_m, .. } => Some((stands, *tolerance_m)),
            _ => None,
        });
        let Some((stands, tolerance_m)) = wanted else { return Vec::new() };
        let brought = left.iter().filter_map(|leaf| {
            self.behavior(*leaf).effects.iter().find_map(|effect| match effect {
                EffectTerm::Stands(pose) => Some(*pose),
                _ => None,
            })
        });
        let all = brought.chain([self.world_state.base]);
        all.filter(|stop| stands.iter().any(|stand| distance_m(*stop, *stand) <= tolerance_m)).collect()
    }

    fn reaches_from(&self, stop: Pose, hand: ResourceId, object: ObjectId, place: PlaceId) -> bool {
        let Some(arm) = self.arm_of(hand) else { return true };
        let (spot, shoulder) = (self.spot(object, place), on_map(stop, arm.shoulder));
        let parts = [spot[0] - shoulder[0], spot[1] - shoulder[1], spot[2] - shoulder[2]];
        parts.iter().map(|part| part * part).sum::<f64>().sqrt() <= arm.reach_m
    }

    /// The resources that a claim is on, whatever they hold.
    fn all_that_could(&self, selector: Selector) -> Vec<ResourceId> {
        match selector {
            Selector::Holding { of, resource: None, .. } => self.of_type(of),
            Selector::Holding { resource: Some(resource), .. } => vec![resource],
            other => self.could_serve(other),
        }
    }
}
