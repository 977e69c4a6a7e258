//! Which resources would serve which claim now.

use std::collections::BTreeSet;

use crate::world::View;
use ambidex_model::state::State;
use ambidex_model::{
    Access, BehaviorSpec, Candidate, Claim, ClaimOptions, Lineage, Location, NodeId, ObjectId, Reason, ResourceId,
    RobotSpec, Selector, Service, TypeId, match_claims,
};

/// Each claim with every resource that would serve it in the table as it is.
///
/// # Errors
/// Why one of the claims, or all of them together, cannot be served.
pub(super) fn options(claims: &[Claim], view: &View, line: &Lineage<'_>) -> Result<Vec<ClaimOptions>, Reason> {
    let options = claims.iter().map(|claim| options_of(claim, view, line)).collect::<Result<Vec<_>, _>>()?;
    // None of a single one is empty.
    if options.len() == 1 {
        return Ok(options);
    }
    let resources: Vec<_> = options.iter().map(ClaimOptions::resources).collect();
    match match_claims(&resources) {
        Ok(()) => Ok(options),
        Err(short) => Err(too_few(&resources, resources[short][0], &view.mission.robot)),
    }
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
    let holders = match claim.selector {
        Selector::Holding(object) => match state.world().objects[object.index()] {
            Location::In(holder) => vec![holder],
            // Whatever it will be in.
            Location::At(_) | Location::Unknown => state.table().iter().map(|(id, _)| id).collect(),
        },
        Selector::Named(_) | Selector::AnyEmpty { .. } | Selector::Empty { .. } | Selector::Any(_) => Vec::new(),
    };
    robot.could_serve(claim.selector, &holders)
}

/// What a robot lacks of what a behavior claims, whatever comes: it has none of the type, too few, or what it has is gone
/// for good.
pub(crate) fn lacks_for_good(spec: &BehaviorSpec, state: &State, robot: &RobotSpec) -> Option<Reason> {
    let gone = |id: &ResourceId| match state.table().resource(*id).service() {
        Service::Gone { why, .. } => Some(Reason::Unavailable { resource: *id, why }),
        Service::Available | Service::Unavailable { .. } => None,
    };
    // What holds an object may be another thing later, unless that is gone with it.
    let everything: Vec<ResourceId> = state.table().iter().map(|(id, _)| id).collect();
    let all: Vec<_> = spec.claims.iter().map(|claim| robot.could_serve(claim.selector, &everything)).collect();
    for (claim, _) in std::iter::zip(&spec.claims, &all).filter(|(_, serving)| serving.is_empty()) {
        if let Selector::Any(of) | Selector::AnyEmpty { of, .. } = claim.selector {
            return Some(Reason::Missing { of });
        }
    }
    if let Err(short) = match_claims(&all) {
        return Some(too_few(&all, all[short][0], robot));
    }
    let holder = |claim: &Claim| match claim.selector {
        Selector::Holding(object) => match state.world().objects[object.index()] {
            Location::In(holder) => gone(&holder).map(|_| holder),
            Location::At(_) | Location::Unknown => None,
        },
        Selector::Named(_) | Selector::AnyEmpty { .. } | Selector::Empty { .. } | Selector::Any(_) => None,
    };
    if let Some(holder) = spec.claims.iter().find_map(holder) {
        return gone(&holder);
    }
    let is_there = |id: &ResourceId| gone(id).is_none();
    let there: Vec<Vec<_>> = all.iter().map(|all| all.iter().copied().filter(is_there).collect()).collect();
    let short = match_claims(&there).err()?;
    all[short].iter().chain(all.iter().flatten()).find_map(gone)
}

fn options_of(claim: &Claim, view: &View, line: &Lineage<'_>) -> Result<ClaimOptions, Reason> {
    let candidates = match claim.selector {
        Selector::Named(resource) => one(resource, claim.access, view, line)?,
        Selector::Holding(object) => match view.state.world().objects[object.index()] {
            Location::In(resource) => one(resource, claim.access, view, line)?,
            Location::At(_) | Location::Unknown => return Err(Reason::NotHeld { object }),
        },
        Selector::Any(of) => any(of, claim.access, view, line)?,
        Selector::AnyEmpty { of, reaches } => {
            let all: Vec<_> = view.mission.robot.of_type(of).collect();
            empty(any(of, claim.access, view, line)?, claim.access, (of, &all), reaches, view, line)?
        }
        Selector::Empty { resource, reaches } => {
            let of = view.mission.robot.resources[resource.index()].ty;
            empty(one(resource, claim.access, view, line)?, claim.access, (of, &[resource]), reaches, view, line)?
        }
    };
    Ok(ClaimOptions { access: claim.access, keep: claim.keep, candidates })
}

fn one(id: ResourceId, access: Access, view: &View, line: &Lineage<'_>) -> Result<Vec<Candidate>, Reason> {
    match held(id, access, view, line) {
        Some(reason) => Err(reason),
        None => Ok(vec![candidate(id, view, line)]),
    }
}

fn candidate(id: ResourceId, view: &View, line: &Lineage<'_>) -> Candidate {
    let has_failed = view.state.status(line.node).failed_with.contains(&id);
    Candidate { has_failed, ..Candidate::at_hand(id) }
}

/// Why a resource does not serve now: its controller is away, it would not do it, or somebody holds it.
fn held(id: ResourceId, access: Access, view: &View, line: &Lineage<'_>) -> Option<Reason> {
    let resource = view.state.table().resource(id);
    if let Some(why) = resource.service().outage() {
        return Some(Reason::Unavailable { resource: id, why });
    }
    if view.state.unfit(line.node).contains(&id) {
        return Some(Reason::Unfit { resource: id });
    }
    let by = resource.obstacle(line, access)?;
    Some(Reason::Held { resource: id, by, channel: resource.channel() })
}

fn any(of: TypeId, access: Access, view: &View, line: &Lineage<'_>) -> Result<Vec<Candidate>, Reason> {
    let robot = &view.mission.robot;
    if robot.of_type(of).next().is_none() {
        return Err(Reason::Missing { of });
    }
    let fitting = robot.of_type(of).filter(|&id| held(id, access, view, line).is_none());
    let candidates: Vec<_> = fitting.map(|id| candidate(id, view, line)).collect();
    if candidates.is_empty() { Err(none_free(of, view, line.node)) } else { Ok(candidates) }
}

/// Those that hold nothing and reach the object, of some that fit; `all` are those that would do if they were free.
fn empty(
    fitting: Vec<Candidate>,
    access: Access,
    (of, all): (TypeId, &[ResourceId]),
    reaches: Option<ObjectId>,
    view: &View,
    line: &Lineage<'_>,
) -> Result<Vec<Candidate>, Reason> {
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
        return Ok(reached);
    }
    match reaches.filter(|_| !empty.is_empty()) {
        Some(object) => {
            let mut would: Vec<_> = all.iter().copied().filter(|&id| reach(id).is_some()).collect();
            // One that runs is worth waiting for, so it is named before one that is kept.
            would.sort_by_key(|&id| !view.state.table().resource(id).is_running());
            let reason = would.into_iter().find_map(|id| held(id, access, view, line));
            Err(reason.unwrap_or(Reason::OutOfReach { object }))
        }
        None => Err(none_free(of, view, line.node)),
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
