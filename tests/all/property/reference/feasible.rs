//! What can never run (`semantics` 6, "Infeasible").

use std::collections::BTreeSet;

use ambidex::model::{Condition, Consequences, Misheld, NodeId, NodeKind, Reason, ResourceId, Selector};

use super::world::{distance_m, singles};
use super::{Model, Step};

impl Model<'_> {
    /// Everything that can never run fails, in tree order, then what depends on it, until nothing more does.
    pub(super) fn give_up(&mut self) {
        loop {
            let makers = self.makers();
            let waiting = self.mission.tree.leaves().filter(|leaf| self.is_idle(*leaf));
            let never = waiting.filter_map(|leaf| Some((leaf, self.why_never(leaf, &makers)?)));
            let never: Vec<_> = never.collect();
            if never.is_empty() || self.end.is_some() {
                return;
            }
            for (leaf, reason) in never {
                if self.is_idle(leaf) && self.end.is_none() {
                    self.give_up_one(leaf, reason);
                }
            }
        }
    }

    fn is_idle(&self, leaf: NodeId) -> bool {
        !self.is_over(leaf) && !self.running.contains_key(&leaf) && self.cleans(leaf).is_none()
    }

    fn give_up_one(&mut self, leaf: NodeId, reason: Reason) {
        self.hidden.clear();
        self.infeasible.insert(leaf, reason.clone());
        let mut fall = self.no_fall();
        self.fail(leaf, leaf, None, &mut fall);
        self.take_back(leaf, fall.failed);
        self.settle_fall(&mut fall);
        let cleaned = fall.cleaned;
        let consequences = Consequences { completed: None, failed: fall.failed, failing: fall.failing, cleaned };
        self.log.push(Step::Infeasible { leaf, reason, consequences });
        self.try_again(&fall);
    }

    fn why_never(&self, leaf: NodeId, makers: &BTreeSet<NodeId>) -> Option<Reason> {
        let spec = self.behavior(leaf);
        let lack = self.robot_lacks(leaf).or_else(|| self.hands_lack(leaf));
        if let Some(reason) = lack.filter(|_| !self.is_satisfied(leaf, &[])) {
            return Some(reason);
        }
        let out_of_reach = |condition| singles(condition).into_iter().find(|part| !self.can_be(part, makers));
        let part = out_of_reach(&spec.precondition).filter(|_| out_of_reach(&spec.satisfied).is_some())?;
        if self.may_be_overtaken(leaf, makers) {
            return None;
        }
        Some(match part {
            Condition::At { place, .. } => Reason::NotAt { place: *place },
            // Whoever has them now.
            part => match self.unmet(part, leaf, &[]).expect("what is so is not out of reach").reason {
                Reason::Misheld(Misheld::NotSo { hold, .. }) => {
                    Reason::Misheld(Misheld::NotSo { hold, found: self.holding(&hold).len() as u32 })
                }
                reason => reason,
            },
        })
    }

    /// What is left that makes something so.
    fn makers(&self) -> BTreeSet<NodeId> {
        let mut makers: BTreeSet<NodeId> = self.running.keys().copied().collect();
        makers.retain(|leaf| self.cleans(*leaf).is_none());
        let left = self.left();
        loop {
            let can_run = |leaf: &NodeId| {
                singles(&self.behavior(*leaf).precondition).iter().all(|part| self.can_be(part, &makers))
            };
            let more: Vec<NodeId> =
                left.iter().copied().filter(|leaf| !makers.contains(leaf) && can_run(leaf)).collect();
            if more.is_empty() {
                return makers;
            }
            makers.extend(more);
        }
    }

    /// Behaviors of which something may yet come, whether they can run or not.
    pub(super) fn left(&self) -> Vec<NodeId> {
        let is_left = |leaf: &NodeId| {
            let mut above = self.upward(*leaf).into_iter();
            let may_go_back = above.any(|node| self.kind(node) == &NodeKind::Then && self.is_still_left(node));
            let comes_again =
                self.upward(*leaf).into_iter().any(|node| self.is_not_the_last(node) && self.is_still_left(node));
            self.is_still_left(*leaf) || (self.done.contains(leaf) && may_go_back) || comes_again
        };
        self.mission.tree.leaves().filter(|leaf| self.cleans(*leaf).is_none()).filter(is_left).collect()
    }

    /// Whether something may come of a node: it is not over, or what is canceled there is tried again.
    fn is_still_left(&self, node: NodeId) -> bool {
        self.within(node).into_iter().all(|node| {
            let begins_again = |fails: &ambidex::model::Failing| {
                fails.fault.is_some()
                    && self.upward(node).into_iter().any(|node| node.0 > 0 && self.can_be_tried_again(node))
            };
            let is_going_on = self.failing.get(&node).is_none_or(|fails| fails.finishes || begins_again(fails));
            let is_left = !self.is_given_up(node) && !self.cleaning.contains(&node);
            !self.done.contains(&node) && !self.failed.contains(&node) && is_going_on && is_left
        })
    }

    /// Whether a single condition is so or can be made so.
    pub(super) fn can_be(&self, part: &Condition, makers: &BTreeSet<NodeId>) -> bool {
        let is_so = match part {
            Condition::Held(hold) => self.holding(hold).len() >= hold.hands as usize,
            Condition::Fact(fact, _) if self.mission.world.is_outside(*fact) => true,
            Condition::Never => false,
            // Where a base stands that is driven is as good as where it will be at rest.
            Condition::At { stands, tolerance_m, .. } => {
                stands.iter().any(|stand| distance_m(self.world_state.base, *stand) <= *tolerance_m)
            }
            part => self.unmet(part, NodeId(0), &[]).is_none(),
        };
        is_so || makers.iter().any(|maker| self.promises(*maker, part))
    }

    /// What the robot has too few of for a behavior: none of the type, not enough, or awaited no more.
    fn robot_lacks(&self, leaf: NodeId) -> Option<Reason> {
        let claims = &self.behavior(leaf).claims;
        // What holds an object may be another thing later, unless all that does is gone with it.
        let all = claims.iter().map(|claim| match claim.selector {
            Selector::Holding { of, resource: None, .. } => self.of_type(of),
            Selector::Holding { resource: Some(resource), .. } => vec![resource],
            other => self.could_serve(other),
        });
        let all: Vec<Vec<ResourceId>> = all.collect();
        let empty = std::iter::zip(claims, &all).find(|(_, serving)| serving.is_empty());
        if let Some((claim, _)) = empty
            && let Selector::Any(of) | Selector::AnyEmpty { of, .. } | Selector::Holding { of, .. } = claim.selector
        {
            return Some(Reason::Missing { of });
        }
        if let Err(refusal) = self.all_at_once(claims, &at_hand(&all)) {
            return Some(refusal.reason);
        }
        let gone_with_it = claims.iter().find_map(|claim| match claim.selector {
            Selector::Holding { .. } => {
                let holders = self.holders_for(claim.selector);
                holders.first().copied().filter(|_| holders.iter().all(|holder| self.is_gone(*holder)))
            }
            _ => None,
        });
        if let Some(resource) = gone_with_it {
            return Some(Reason::Unavailable { resource, why: self.outage(resource)? });
        }
        let is_there = |id: &ResourceId| !self.is_gone(*id);
        let there: Vec<Vec<ResourceId>> =
            all.iter().map(|serving| serving.iter().copied().filter(is_there).collect()).collect();
        let none = |upto: &usize| {
            there[upto - 1].is_empty() || self.all_at_once(&claims[..*upto], &at_hand(&there[..*upto])).is_err()
        };
        let short = (1..=there.len()).find(none)?;
        let gone = all[short - 1].iter().copied().find(|id| self.is_gone(*id));
        let anywhere = || all.iter().flatten().copied().find(|id| self.is_gone(*id));
        let resource = gone.or_else(anywhere).expect("only what is gone is missing");
        let why = self.outage(resource).expect("it is away");
        Some(Reason::Unavailable { resource, why })
    }

    /// The resources that could serve a claim, whatever they hold and whoever has them.
    pub(super) fn could_serve(&self, selector: Selector) -> Vec<ResourceId> {
        match selector {
            Selector::Named(resource) | Selector::Empty { resource, .. } => vec![resource],
            Selector::Any(of) | Selector::AnyEmpty { of, .. } => self.of_type(of),
            Selector::Holding { of, resource, .. } => match self.holders_for(selector) {
                nobody if nobody.is_empty() => resource.map_or_else(|| self.of_type(of), |only| vec![only]),
                holders => holders,
            },
        }
    }

    /// Whether a resource is away and awaited no more.
    pub(super) fn is_gone(&self, resource: ResourceId) -> bool {
        let controller = self.mission.robot.resources[resource.index()].controller;
        controller.and_then(|id| self.away.get(&id)).is_some_and(|(_, is_awaited)| !is_awaited)
    }
}

fn at_hand(serving: &[Vec<ResourceId>]) -> Vec<Vec<(ResourceId, f64)>> {
    serving.iter().map(|serving| serving.iter().map(|id| (*id, 0.0)).collect()).collect()
}
