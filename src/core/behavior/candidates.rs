//! Which resources would serve which claim now.

use std::collections::BTreeSet;

use crate::world::View;
use ambidex_model::state::State;
use ambidex_model::{
    Access, BehaviorSpec, Candidate, Claim, ClaimOptions, HeldBy, Hold, Lineage, NodeId, ObjectId, Reason, ResourceId,
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
        Err(short) => Err(too_few_holders(claims, &resources, short)
            .unwrap_or_else(|| too_few(&resources, resources[short][0], &view.mission.robot))),
    }
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

fn options_of(claim: &Claim, view: &View, line: &Lineage<'_>) -> Result<ClaimOptions, Reason> {
    let candidates = match claim.selector {
        Selector::Named(resource) => one(resource, claim.access, view, line)?,
        Selector::Holding { object, of, resource } => {
            let by = resource.map_or(HeldBy::Type(of), HeldBy::Resource);
            any_of_holders(claim, Hold { object, by, hands: 1, alone: false }, view, line)?
        }
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

/// Those that hold an object, of which any will do.
fn any_of_holders(claim: &Claim, hold: Hold, view: &View, line: &Lineage<'_>) -> Result<Vec<Candidate>, Reason> {
    let holding = holding(claim, &view.mission.robot.could_serve(claim.selector), &view.state);
    let fitting = holding.iter().filter(|id| held(**id, claim.access, view, line).is_none());
    let candidates: Vec<_> = fitting.map(|id| candidate(*id, view, line)).collect();
    let is_held = !view.state.world().objects[hold.object.index()].holders().is_empty();
    match (candidates.is_empty(), holding.first().and_then(|first| held(*first, claim.access, view, line))) {
        (false, _) => Ok(candidates),
        (true, Some(reason)) => Err(reason),
        (true, None) if is_held => Err(hold.reason(0)),
        (true, None) => Err(Reason::NotHeld { object: hold.object }),
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
