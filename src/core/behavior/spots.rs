//! Where on a surface something is put down: in a free spot that its hand reaches, of these in the one nearest to its shoulder,
//! so that arms keep to their sides.

use nalgebra::Point3;

use crate::world::View;
use ambidex_model::{
    BehaviorSpec, Change, ClaimOptions, Grant, Location, ObjectId, PlaceId, Reason, ResourceId, SpotId,
};

/// The spots in which a behavior puts down what it puts down; none of what it puts where nothing is told of the surface and no
/// spot is left.
///
/// # Errors
/// That no spot is free that is within reach, or that none is within reach.
pub(super) fn choose(
    spec: &BehaviorSpec,
    claims: &[ClaimOptions],
    view: &View,
) -> Result<Vec<(ObjectId, SpotId)>, Reason> {
    let puts = || spec.commands.iter().filter_map(|term| Some((term.task.put()?, term.task.put_at()?, term.claim)));
    let mut chosen: Vec<(ObjectId, SpotId)> = Vec::new();
    let mut put: Vec<Lying> = Vec::new();
    for (object, place, _) in puts() {
        if chosen.iter().any(|(other, _)| *other == object) {
            continue;
        }
        let claims = puts().filter(|(other, ..)| *other == object).map(|(.., claim)| &claims[claim]);
        let hands: Vec<_> = claims.flat_map(ClaimOptions::resources).collect();
        let beside = put.iter().filter(|(_, there, _)| *there == place).map(|(other, _, at)| (*other, *at));
        let taken = [lying(view, place, object), beside.collect()].concat();
        if let Some((spot, at)) = choose_one(view, (object, place), &hands, &taken)? {
            chosen.push((object, spot));
            put.push((object, place, at));
        }
    }
    Ok(chosen)
}

/// An object, its place and its middle there.
type Lying = (ObjectId, PlaceId, Point3<f64>);

fn choose_one(
    view: &View,
    (object, place): (ObjectId, PlaceId),
    hands: &[ResourceId],
    taken: &[(ObjectId, Point3<f64>)],
) -> Result<Option<(SpotId, Point3<f64>)>, Reason> {
    let world = &view.mission.world;
    let is_told = world.places[place.index()].is_surface_told;
    if world.has_own_spot(object, place) {
        let own = (object, world.own_spot(object, place));
        // Where nothing is told of the surface it lies there whatever else does.
        if !is_told
            || !taken.iter().any(|other| world.meet(own, *other))
                && reach_m(view, hands, (object, place), own.1).is_some()
        {
            return Ok(None);
        }
    }
    let (mut best, mut is_reached) = (None::<(f64, SpotId, Point3<f64>)>, false);
    for (spot, at) in world.fitting(object, place) {
        let Some(reach_m) = reach_m(view, hands, (object, place), at) else { continue };
        is_reached = true;
        let is_better = best.is_none_or(|(best_m, ..)| reach_m < best_m);
        if is_better && !taken.iter().any(|other| world.meet((object, at), *other)) {
            best = Some((reach_m, spot, at));
        }
    }
    match best {
        Some((_, spot, at)) => Ok(Some((spot, at))),
        // It lies beside the others, wherever that is.
        None if !is_told => Ok(None),
        None => Err(Reason::NoSpot { place, is_taken: is_reached }),
    }
}

/// That an object lies at a place, in the spot that was asked for.
pub(super) fn laid(object: ObjectId, place: PlaceId, grant: &Grant) -> Change {
    match grant.request.spot(object) {
        Some(spot) => Change::Laid(object, place, spot),
        None => Change::Object(object, Location::At(place)),
    }
}

/// How far hands reach out for a point, all together, meters; none where one of them cannot.
fn reach_m(view: &View, hands: &[ResourceId], (object, place): (ObjectId, PlaceId), at: Point3<f64>) -> Option<f64> {
    let (base, approach) = (&view.state.world().base, view.mission.world.approach(object, place).to_put());
    hands.iter().map(|hand| view.geometry().reach_from(base, *hand, at, approach, 0.0)).sum()
}

/// What else lies at a place, or is being put there.
fn lying(view: &View, place: PlaceId, object: ObjectId) -> Vec<(ObjectId, Point3<f64>)> {
    let (world, world_state) = (&view.mission.world, view.state.world());
    let others = (0..world_state.objects.len()).map(ObjectId::from).filter(|other| *other != object);
    let lying = others.filter(|other| world_state.objects[other.index()] == Location::At(place));
    let lying = lying.filter_map(|other| Some((other, world.object(world_state, other)?)));
    let put = view.state.running().values().flat_map(|grant| view.puts(&grant.request));
    let put = put.filter(|(_, there, _)| *there == place).map(|(other, _, at)| (other, at));
    lying.chain(put).collect()
}
