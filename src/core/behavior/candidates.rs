//! Which resources would serve which claim now.

use std::collections::BTreeSet;

use super::Ahead;
use crate::world::View;
use ambidex_model::state::State;
use ambidex_model::{
    Access, BehaviorSpec, Beyond, Candidate, Claim, ClaimOptions, EffectTerm, HeldBy, Hold, Lease, LeaseKind, Lineage,
    NodeId, ObjectId, Reason, ResourceId, RobotSpec, Selector, Service, TypeId, match_claims,
};

/// What it costs a wish more to be given what it failed with before, what others would have to give up, or what will be
/// free, meters: more than any reach.
const AVOIDED_M: f64 = 1e2;
const GIVEN_UP_M: f64 = 1e3;
const WAITED_FOR_M: f64 = 1e6;

/// For whom claims are to be served.
pub(super) struct Serving<'a> {
    pub(super) view: &'a View,
    pub(super) line: &'a Lineage<'a>,
    pub(super) ahead: Ahead<'a>,
    /// How urgent it is, where it is asked what would serve if nothing ran and nothing less urgent kept an intention.
    pub(super) patience: Option<i32>,
}

/// Each claim of a behavior with every resource that would serve it in the table as it is.
///
/// # Errors
/// Why one of the claims, or all of them together, cannot be served.
pub(super) fn options(spec: &BehaviorSpec, serving: &Serving<'_>) -> Result<Vec<ClaimOptions>, Reason> {
    let claims = &spec.claims;
    let options = claims.iter().enumerate().map(|(index, claim)| {
        let options = serving.options_of(claim)?;
        serving.able_later(claim, taken(spec, index), options)
    });
    let options = options.collect::<Result<Vec<_>, _>>()?;
    // None of a single one is empty.
    if options.len() == 1 {
        return Ok(options);
    }
    let resources: Vec<_> = options.iter().map(ClaimOptions::resources).collect();
    match match_claims(&resources) {
        Ok(()) => Ok(options),
        Err(short) => Err(too_few_holders(claims, &resources, short)
            .unwrap_or_else(|| too_few(&resources, resources[short][0], &serving.view.mission.robot))),
    }
}

/// What the resource of a claim will hold.
fn taken(spec: &BehaviorSpec, claim: usize) -> Option<ObjectId> {
    spec.effects.iter().find_map(|effect| match *effect {
        EffectTerm::Taken(object, by) => Some(object).filter(|_| by == claim),
        EffectTerm::Lies(..) | EffectTerm::LetGo(..) | EffectTerm::Stands(_) | EffectTerm::Fact(..) => None,
    })
}

/// Why claims on what holds an object cannot all be served, if fewer hold it.
fn too_few_holders(claims: &[Claim], options: &[Vec<ResourceId>], short: usize) -> Option<Reason> {
    let Selector::Holding { object, of, .. } = claims[short].selector else { return None };
    let is_for_it = |claim: &Claim| matches!(claim.selector, Selector::Holding { object: held, .. } if held == object);
    let holding = std::iter::zip(claims, options).filter(|(claim, _)| is_for_it(claim));
    let (mut hands, mut found) = (0, BTreeSet::<&ResourceId>::new());
    for (_, options) in holding {
        hands += 1;
        found.extend(options);
    }
    let found = found.len() as u32;
    (found < hands).then(|| Hold { object, by: HeldBy::Type(of), hands, alone: false }.reason(found))
}

/// Why claims cannot all be served though each alone could: those that want what a contested resource is of.
pub(crate) fn too_few(options: &[Vec<ResourceId>], contested: ResourceId, robot: &RobotSpec) -> Reason {
    let of = robot.resources[contested.index()].ty;
    let is_of = |resource: &&ResourceId| robot.resources[resource.index()].ty == of;
    let wanting = options.iter().filter(|options| options.iter().any(|resource| is_of(&resource)));
    let free: BTreeSet<_> = options.iter().flatten().filter(is_of).collect();
    Reason::TooFew { of, wanted: wanting.count() as u32, free: free.len() as u32 }
}

/// The resources that could serve a claim, whatever they hold and whoever has them.
pub(crate) fn could_serve(claim: &Claim, state: &State, robot: &RobotSpec) -> Vec<ResourceId> {
    let all = robot.could_serve(claim.selector);
    let holding = holding(claim, &all, state);
    // What holds nothing of it now may later.
    if holding.is_empty() { all } else { holding }
}

/// Those of the resources that a claim is on that hold what it wants held; none for any other claim.
fn holding(claim: &Claim, all: &[ResourceId], state: &State) -> Vec<ResourceId> {
    let Selector::Holding { object, .. } = claim.selector else { return Vec::new() };
    let holders = state.world().objects[object.index()].holders();
    all.iter().copied().filter(|id| holders.contains(id)).collect()
}

/// What a robot lacks of what a behavior claims, whatever comes: it has none of the type, too few, or what it has is gone
/// for good.
pub(crate) fn lacks_for_good(spec: &BehaviorSpec, state: &State, robot: &RobotSpec) -> Option<Reason> {
    let gone = |id: &ResourceId| match state.table().resource(*id).service() {
        Service::Gone { why, .. } => Some(Reason::Unavailable { resource: *id, why }),
        Service::Available | Service::Unavailable { .. } => None,
    };
    let all: Vec<_> = spec.claims.iter().map(|claim| robot.could_serve(claim.selector)).collect();
    for (claim, _) in std::iter::zip(&spec.claims, &all).filter(|(_, serving)| serving.is_empty()) {
        if let Selector::Any(of) | Selector::AnyEmpty { of, .. } | Selector::Holding { of, .. } = claim.selector {
            return Some(Reason::Missing { of });
        }
    }
    if let Err(short) = match_claims(&all) {
        return Some(too_few(&all, all[short][0], robot));
    }
    // What holds an object may be another thing later, unless all that does is gone with it.
    let gone_with_it = std::iter::zip(&spec.claims, &all).find_map(|(claim, all)| {
        let holding = holding(claim, all, state);
        holding.first().filter(|_| holding.iter().all(|id| gone(id).is_some())).and_then(gone)
    });
    if gone_with_it.is_some() {
        return gone_with_it;
    }
    let is_there = |id: &ResourceId| gone(id).is_none();
    let there: Vec<Vec<_>> = all.iter().map(|all| all.iter().copied().filter(is_there).collect()).collect();
    let short = match_claims(&there).err()?;
    all[short].iter().chain(all.iter().flatten()).find_map(gone)
}

impl Serving<'_> {
    fn options_of(&self, claim: &Claim) -> Result<ClaimOptions, Reason> {
        let (view, access) = (self.view, claim.access);
        let (candidates, beyond) = match claim.selector {
            Selector::Named(resource) => (self.one(resource, access)?, Vec::new()),
            Selector::Holding { object, of, resource } => {
                let by = resource.map_or(HeldBy::Type(of), HeldBy::Resource);
                (self.any_of_holders(claim, Hold { object, by, hands: 1, alone: false })?, Vec::new())
            }
            Selector::Any(of) => (self.any(of, access)?, Vec::new()),
            Selector::AnyEmpty { of, reaches } => {
                let all: Vec<_> = view.mission.robot.of_type(of).collect();
                self.empty(self.any(of, access)?, access, (of, &all), reaches)?
            }
            Selector::Empty { resource, reaches } => {
                let of = view.mission.robot.resources[resource.index()].ty;
                self.empty(self.one(resource, access)?, access, (of, &[resource]), reaches)?
            }
        };
        Ok(ClaimOptions { access, keep: claim.keep, candidates: self.in_order(candidates, access), beyond })
    }

    /// Those that can also do what is asked later of what they take.
    fn able_later(
        &self,
        claim: &Claim,
        taken: Option<ObjectId>,
        mut options: ClaimOptions,
    ) -> Result<ClaimOptions, Reason> {
        let Some(object) = taken else { return Ok(options) };
        let mut failing = None;
        let beyond = &mut options.beyond;
        options.candidates.retain(|candidate| {
            let by = (self.ahead)(candidate.resource, object);
            failing = failing.or(by);
            beyond.extend(by.map(|by| Beyond { resource: candidate.resource, by: Some(by) }));
            by.is_none()
        });
        beyond.sort_by_key(|beyond| beyond.resource);
        let Some(by) = failing.filter(|_| options.candidates.is_empty()) else { return Ok(options) };
        let able = self.view.mission.robot.could_serve(claim.selector).into_iter();
        let mut able = able.filter(|id| (self.ahead)(*id, object).is_none());
        let held = able.find_map(|id| self.held(id, claim.access));
        Err(held.unwrap_or(Reason::OutOfReachLater { object, by }))
    }

    /// Where it may wait, what is free comes first, then what would be given up, then what is to be waited for; among these
    /// last what it failed with before.
    fn in_order(&self, mut candidates: Vec<Candidate>, access: Access) -> Vec<Candidate> {
        let Some(patience) = self.patience else { return candidates };
        for candidate in &mut candidates {
            let resource = self.view.state.table().resource(candidate.resource);
            let yields = |lease: &Lease| {
                self.line.contains(lease.holder)
                    || lease.kind != LeaseKind::Running
                    || self.is_preempted(lease, patience)
            };
            if std::mem::take(&mut candidate.has_failed) {
                candidate.cost_m += AVOIDED_M;
            }
            candidate.cost_m += match resource.obstacle(self.line, access) {
                None => 0.0,
                Some(_) if resource.leases().iter().all(yields) => GIVEN_UP_M,
                Some(_) => WAITED_FOR_M,
            };
        }
        candidates.sort_by(|one, other| one.cost_m.total_cmp(&other.cost_m));
        candidates
    }

    fn is_preempted(&self, lease: &Lease, patience: i32) -> bool {
        let tree = &self.view.mission.tree;
        let is_interruptible = tree.behavior(lease.holder).is_some_and(|spec| spec.is_interruptible);
        is_interruptible && self.view.priority(lease.holder) < patience
    }

    fn one(&self, id: ResourceId, access: Access) -> Result<Vec<Candidate>, Reason> {
        match self.held(id, access) {
            Some(reason) => Err(reason),
            None => Ok(vec![self.candidate(id)]),
        }
    }

    /// Those that hold an object, of which any will do.
    fn any_of_holders(&self, claim: &Claim, hold: Hold) -> Result<Vec<Candidate>, Reason> {
        let view = self.view;
        let holding = holding(claim, &view.mission.robot.could_serve(claim.selector), &view.state);
        let fitting = holding.iter().filter(|id| self.held(**id, claim.access).is_none());
        let candidates: Vec<_> = fitting.map(|id| self.candidate(*id)).collect();
        let is_held = !view.state.world().objects[hold.object.index()].holders().is_empty();
        match (candidates.is_empty(), holding.first().and_then(|first| self.held(*first, claim.access))) {
            (false, _) => Ok(candidates),
            (true, Some(reason)) => Err(reason),
            (true, None) if is_held => Err(hold.reason(0)),
            (true, None) => Err(Reason::NotHeld { object: hold.object }),
        }
    }

    fn candidate(&self, id: ResourceId) -> Candidate {
        let has_failed = self.view.state.status(self.line.node).failed_with.contains(&id);
        Candidate { has_failed, ..Candidate::at_hand(id) }
    }

    /// Why a resource does not serve: its controller is away, it would not do it, or somebody holds it.
    fn held(&self, id: ResourceId, access: Access) -> Option<Reason> {
        let (view, line) = (self.view, self.line);
        let resource = view.state.table().resource(id);
        if let Some(why) = resource.service().outage() {
            return Some(Reason::Unavailable { resource: id, why });
        }
        if view.state.unfit(line.node).contains(&id) {
            return Some(Reason::Unfit { resource: id });
        }
        let by = resource.obstacle(line, access)?;
        if self.patience.is_some_and(|patience| self.passes(id, patience)) {
            return None;
        }
        Some(Reason::Held { resource: id, by, channel: resource.channel() })
    }

    /// Whether who holds a resource only runs, or keeps it for a less urgent intention. One with an object in it is not
    /// taken from anybody.
    fn passes(&self, id: ResourceId, patience: i32) -> bool {
        let (view, line) = (self.view, self.line);
        let passes = |lease: &Lease| {
            let would_pass = match lease.kind {
                LeaseKind::Running => true,
                LeaseKind::Intention => view.priority(lease.holder) < patience,
                LeaseKind::Physical => false,
            };
            would_pass || line.contains(lease.holder)
        };
        view.state.world().held_by(id).is_none() && view.state.table().resource(id).leases().iter().all(passes)
    }

    fn any(&self, of: TypeId, access: Access) -> Result<Vec<Candidate>, Reason> {
        let robot = &self.view.mission.robot;
        if robot.of_type(of).next().is_none() {
            return Err(Reason::Missing { of });
        }
        let fitting = robot.of_type(of).filter(|&id| self.held(id, access).is_none());
        let candidates: Vec<_> = fitting.map(|id| self.candidate(id)).collect();
        if candidates.is_empty() { Err(none_free(of, self.view, self.line.node)) } else { Ok(candidates) }
    }

    /// Those that hold nothing and reach the object, and those that do not reach it, of some that fit; `all` are those that would do if they were free.
    fn empty(
        &self,
        fitting: Vec<Candidate>,
        access: Access,
        (of, all): (TypeId, &[ResourceId]),
        reaches: Option<ObjectId>,
    ) -> Result<(Vec<Candidate>, Vec<Beyond>), Reason> {
        let view = self.view;
        let reach = |resource| match reaches {
            Some(object) => view.geometry().reach_m(view.state.world(), resource, object),
            None => Some(0.0),
        };
        let is_empty = |resource| view.state.world().held_by(resource).is_none();
        let empty: Vec<_> = fitting.into_iter().filter(|candidate| is_empty(candidate.resource)).collect();
        let reached: Vec<_> = empty
            .iter()
            .filter_map(|candidate| reach(candidate.resource).map(|cost_m| Candidate { cost_m, ..*candidate }))
            .collect();
        if !reached.is_empty() {
            let is_reached = |id| reached.iter().any(|candidate| candidate.resource == id);
            let beyond = empty.iter().map(|candidate| candidate.resource).filter(|id| !is_reached(*id));
            let beyond = beyond.map(|resource| Beyond { resource, by: None }).collect();
            return Ok((reached, beyond));
        }
        match reaches.filter(|_| !empty.is_empty()) {
            Some(object) => {
                let mut would: Vec<_> = all.iter().copied().filter(|&id| reach(id).is_some()).collect();
                // One that runs is worth waiting for, so it is named before one that is kept.
                would.sort_by_key(|&id| !view.state.table().resource(id).is_running());
                let reason = would.into_iter().find_map(|id| self.held(id, access));
                Err(reason.unwrap_or(Reason::OutOfReach { object }))
            }
            None => Err(none_free(of, view, self.line.node)),
        }
    }
}

/// Nothing of a type serves now: where all of it is away, or would not do it, that is why.
fn none_free(of: TypeId, view: &View, leaf: NodeId) -> Reason {
    let all = || view.mission.robot.of_type(of);
    let outage = |id: ResourceId| view.state.table().resource(id).service().outage();
    let unfit = view.state.unfit(leaf);
    let first_unfit = all().find(|id| unfit.contains(id));
    match (all().next().and_then(|first| Some((first, outage(first)?))), first_unfit) {
        (Some((resource, why)), _) if all().all(|id| outage(id).is_some()) => Reason::Unavailable { resource, why },
        (_, Some(resource)) if all().all(|id| outage(id).is_some() || unfit.contains(&id)) => {
            Reason::Unfit { resource }
        }
        (_, _) => Reason::NoneFree { of },
    }
}
