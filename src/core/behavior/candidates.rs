//! Which resources would serve which claim now.

use crate::world::View;
use ambidex_model::{Access, Candidate, Claim, Line, Need, ObjectId, Reason, ResourceId, TypeId, Wanted, Whereabouts};

/// Each claim with every resource that would serve it in the table as it is.
///
/// # Errors
/// Why one of the claims, or all of them together, cannot be served.
pub(super) fn needs(claims: &[Claim], view: &View, line: &Line<'_>) -> Result<Vec<Need>, Reason> {
    let needs = claims.iter().map(|claim| need(claim, view, line)).collect::<Result<Vec<_>, _>>()?;
    let is_short = |upto: &usize| !serves_all(&needs[..*upto], &mut Vec::new());
    let Some(short) = (1..=needs.len()).find(is_short) else {
        return Ok(needs);
    };
    let contested = needs[short - 1].candidates[0].resource;
    Err(Reason::NoneFree { of: view.geometry.robot.resources[contested.index()].ty })
}

fn need(claim: &Claim, view: &View, line: &Line<'_>) -> Result<Need, Reason> {
    let candidates = match claim.wanted {
        Wanted::Named(resource) => one(resource, claim.access, view, line)?,
        Wanted::Holding(object) => match view.situation.objects[object.index()] {
            Whereabouts::In(resource) => one(resource, claim.access, view, line)?,
            Whereabouts::At(_) | Whereabouts::Unknown => return Err(Reason::NotHeld { object }),
        },
        Wanted::Any(of) => any(of, claim.access, view, line)?,
        Wanted::AnyEmpty { of, reaches } => {
            let all: Vec<_> = view.geometry.robot.of_type(of).collect();
            empty(any(of, claim.access, view, line)?, claim.access, (of, &all), reaches, view, line)?
        }
        Wanted::Empty { resource, reaches } => {
            let of = view.geometry.robot.resources[resource.index()].ty;
            empty(one(resource, claim.access, view, line)?, claim.access, (of, &[resource]), reaches, view, line)?
        }
    };
    Ok(Need { access: claim.access, keep: claim.keep, candidates })
}

fn one(id: ResourceId, access: Access, view: &View, line: &Line<'_>) -> Result<Vec<Candidate>, Reason> {
    match held(id, access, view, line) {
        Some(reason) => Err(reason),
        None => Ok(vec![Candidate { resource: id, cost_m: 0.0 }]),
    }
}

fn held(id: ResourceId, access: Access, view: &View, line: &Line<'_>) -> Option<Reason> {
    let resource = view.table.resource(id);
    let by = resource.obstacle(line, access)?;
    Some(Reason::Held { resource: id, by, channel: resource.channel() })
}

fn any(of: TypeId, access: Access, view: &View, line: &Line<'_>) -> Result<Vec<Candidate>, Reason> {
    let robot = &view.geometry.robot;
    if robot.of_type(of).next().is_none() {
        return Err(Reason::Missing { of });
    }
    let fitting = robot.of_type(of).filter(|&id| held(id, access, view, line).is_none());
    let candidates: Vec<_> = fitting.map(|resource| Candidate { resource, cost_m: 0.0 }).collect();
    if candidates.is_empty() { Err(Reason::NoneFree { of }) } else { Ok(candidates) }
}

/// Those that hold nothing and reach the object, of some that fit; `all` are those that would do if they were free.
fn empty(
    fitting: Vec<Candidate>,
    access: Access,
    (of, all): (TypeId, &[ResourceId]),
    reaches: Option<ObjectId>,
    view: &View,
    line: &Line<'_>,
) -> Result<Vec<Candidate>, Reason> {
    let reach = |resource| match reaches {
        Some(object) => view.geometry.reach_m(&view.situation, resource, object),
        None => Some(0.0),
    };
    let is_empty = |resource| view.situation.held_by(resource).is_none();
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
            would.sort_by_key(|&id| !view.table.resource(id).is_running());
            let reason = would.into_iter().find_map(|id| held(id, access, view, line));
            Err(reason.unwrap_or(Reason::OutOfReach { object }))
        }
        None => Err(Reason::NoneFree { of }),
    }
}

/// Whether each need can have a resource of its own.
fn serves_all(needs: &[Need], taken: &mut Vec<ResourceId>) -> bool {
    let Some((need, others)) = needs.split_first() else {
        return true;
    };
    need.candidates.iter().map(|candidate| candidate.resource).any(|resource| {
        if taken.contains(&resource) {
            return false;
        }
        taken.push(resource);
        let serves = serves_all(others, taken);
        taken.pop();
        serves
    })
}
