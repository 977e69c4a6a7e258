//! What the rows are made of: missions on one robot, and short names for behaviors.

use ambidex::model::{
    Access, BehaviorSpec, ChannelId, Condition, FactId, Location, ObjectId, PlaceId, Potential, Retention, Selector,
};
use ambidex::tree::Settings;

use super::{Event, Run, leaf, robot};
use crate::support::{Body, TOOL, Tree, blank, claim, mission, move_to, pick, put};

pub(super) const PLACES: usize = 4;
pub(super) const EXCLUSIVE: Access = Access::Exclusive;
pub(super) const GO: Retention = Retention::Intention(Access::Shared(ChannelId(1)));

pub(super) fn check(tree: Tree, events: &[Event], expected: &str) -> Run {
    let (body, places) = (robot(2, 2), [0, 0, 1].map(PlaceId));
    let objects = places.map(Location::At).to_vec();
    let mut mission = mission(body, PLACES, objects, vec![false; 4], &tree);
    // What nobody sets may come all the same.
    mission.world.outside = vec![true; 4];
    let run = Run::new(mission, Settings::default(), events);
    assert_eq!(run.steps(), expected);
    run
}

pub(super) fn body() -> Body {
    robot(2, 2)
}

/// `move` to a place, `pick` and `place` an object.
pub(super) fn go(name: &str, to: u32) -> Tree {
    leaf(name, move_to(body(), PlaceId(to), PLACES))
}

pub(super) fn grab(name: &str, object: u32, at: u32) -> Tree {
    leaf(name, pick(body(), ObjectId(object), PlaceId(at), PLACES))
}

pub(super) fn drop_at(name: &str, object: u32, at: u32, retries: u32) -> Tree {
    let spec = put(body(), ObjectId(object), PlaceId(at), PLACES);
    leaf(name, BehaviorSpec { retries, ..spec })
}

/// A behavior with one claim on the first tool.
pub(super) fn tool(name: &str, access: Access, keep: Retention) -> Tree {
    leaf(name, tool_spec(access, keep))
}

pub(super) fn tool_spec(access: Access, keep: Retention) -> BehaviorSpec {
    let first = Selector::Named(body().first(TOOL).expect("two tools"));
    BehaviorSpec { claims: vec![claim(first, access, keep)], ..blank("tool") }
}

pub(super) fn with_potential(spec: BehaviorSpec, value: f64) -> BehaviorSpec {
    BehaviorSpec { potential: Potential::Constant(value), ..spec }
}

pub(super) fn needing(spec: BehaviorSpec, needs: u32) -> BehaviorSpec {
    BehaviorSpec { precondition: Condition::Fact(FactId(needs), true), ..spec }
}

pub(super) fn free(name: &str) -> Tree {
    leaf(name, blank("free"))
}
