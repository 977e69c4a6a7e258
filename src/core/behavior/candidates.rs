//! Which resources would serve which claim now.

use std::collections::BTreeSet;

use crate::world::View;
use ambidex_model::{
    Access, Candidate, Claim, ClaimOptions, Lineage, Location, ObjectId, Reason, ResourceId, RobotSpec, Selector,
    TypeId, match_claims,
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

/// Why a resource does not serve now: its controller is away, or somebody holds it.
fn held(id: ResourceId, access: Access, view: &View, line: &Lineage<'_>) -> Option<Reason> {
    let resource = view.state.table().resource(id);
    if let Some(why) = resource.service().outage() {
        return Some(Reason::Unavailable { resource: id, why });
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
    if candidates.is_empty() { Err(none_free(of, view)) } else { Ok(candidates) }
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
        None => Err(none_free(of, view)),
    }
}

/// Nothing of a type serves now: where all of it is away, that is why.
fn none_free(of: TypeId, view: &View) -> Reason {
    let outage = |id| view.state.table().resource(id).service().outage().map(|why| (id, why));
    let outages: Option<Vec<_>> = view.mission.robot.of_type(of).map(outage).collect();
    match outages.as_deref() {
        Some([(resource, why), ..]) => Reason::Unavailable { resource: *resource, why: *why },
        Some([]) | None => Reason::NoneFree { of },
    }
}
