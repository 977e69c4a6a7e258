//! Paths against tables, against parry, against a fine grid, and against the shortest there is.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use ambidex_model::{Obstacle, Pose};
use nalgebra::{Point2, Point3};
use parry3d::math::{Pose as ParryPose, Vector as ParryVector};
use parry3d::query::intersection_test;
use parry3d::shape::{Capsule, Cuboid};
use proptest::prelude::*;

use super::free_space::{Legs, Steps};
use super::{Found, FreeSpace, NoPath, Ways, find_path};

const RADIUS_M: f64 = 0.3;
/// What 2,000 boxes may take, far below the bound.
const MOST_STEPS: u32 = 1_500_000;
const MOST_EXPANSIONS: u32 = 8_000;

/// A box by its lower and upper corner.
type Corners = [f64; 4];

fn free_space(boxes: &[Corners]) -> FreeSpace {
    let solid = |&[x, y, to_x, to_y]: &Corners| (Point3::new(x, y, 0.0), Point3::new(to_x, to_y, 1.0));
    let obstacles: Vec<_> = boxes.iter().map(solid).map(|(min, max)| Obstacle::between(min, max)).collect();
    FreeSpace::new(&obstacles, RADIUS_M)
}

/// Searches, and holds every leg against parry and against points along it.
fn search(boxes: &[Corners], from: [f64; 2], to: [f64; 2]) -> Found {
    let space = free_space(boxes);
    let [from, to] = [from, to].map(|[x, y]| Pose::new(x, y, 0.0));
    let to = Pose { heading: 1.0, ..to };
    let found = find_path(&space, from, to);
    let mut last = from.at;
    for pose in found.path.iter().flatten() {
        assert!(pose.at.iter().all(|at| at.is_finite()), "{found:?}");
        assert_eq!(pose.heading, to.heading);
        assert!(is_free_by_points(boxes, last, pose.at, RADIUS_M - 1e-9), "{last} to {}", pose.at);
        last = pose.at;
    }
    if let Ok(path) = &found.path {
        assert_eq!(path.last(), Some(&to));
    }
    found
}

/// Whether a base that stands there touches nothing: what it touches it may leave, which is a matter of its own.
fn stands_free(boxes: &[Corners], at: [f64; 2]) -> bool {
    free_space(boxes).taken_by(at.into()).is_none()
}

fn is_free_by_points(boxes: &[Corners], a: Point2<f64>, b: Point2<f64>, radius_m: f64) -> bool {
    let parts = 400;
    (0..=parts)
        .all(|part| boxes.iter().all(|&solid| off_m(solid, a + (b - a) * (part as f64 / parts as f64)) > radius_m))
}

fn off_m([x, y, to_x, to_y]: Corners, at: Point2<f64>) -> f64 {
    let (dx, dy) = ((x - at.x).max(at.x - to_x).max(0.0), (y - at.y).max(at.y - to_y).max(0.0));
    dx.hypot(dy)
}

fn length_m(from: [f64; 2], path: &[Pose]) -> f64 {
    let mut last = Point2::from(from);
    path.iter().map(|pose| nalgebra::distance(&std::mem::replace(&mut last, pose.at), &pose.at)).sum()
}

/// A wall along x = 2 from far left to far right with a gap of some width around y = 0, in a closed room.
fn wall_with_gap(gap_m: f64) -> Vec<Corners> {
    let half_m = gap_m / 2.0;
    let mut boxes = room([-5.0, -5.0, 8.0, 5.0]);
    boxes.extend([[1.9, -5.0, 2.1, -half_m], [1.9, half_m, 2.1, 5.0]]);
    boxes
}

/// Four walls of 20 cm.
fn room([x, y, to_x, to_y]: Corners) -> Vec<Corners> {
    let (wide_x, wide_y) = ([x - 0.2, to_x + 0.2], [y - 0.2, to_y + 0.2]);
    vec![
        [wide_x[0], wide_y[0], x, wide_y[1]],
        [to_x, wide_y[0], wide_x[1], wide_y[1]],
        [wide_x[0], wide_y[0], wide_x[1], y],
        [wide_x[0], to_y, wide_x[1], wide_y[1]],
    ]
}

#[test]
fn paths_lead_around_boxes() {
    /// The way points from (0, 0) to (4, 0), or none.
    fn check(boxes: &[Corners], expected: Option<usize>) {
        let found = search(boxes, [0.0, 0.0], [4.0, 0.0]);
        assert_eq!(found.path.as_ref().map(Vec::len).map_err(|no_path| *no_path), expected.ok_or(NoPath::Closed));
    }
    check(&[], Some(1));
    check(&[[1.0, 1.0, 2.0, 2.0]], Some(1));
    check(&[[1.0, RADIUS_M + 1e-6, 2.0, 2.0]], Some(1));
    // A touch is too near.
    check(&[[1.0, RADIUS_M, 2.0, 2.0]], Some(2));
    check(&[[1.0, -0.5, 2.0, 0.5]], Some(4));
    check(&[[3.5, -0.5, 4.5, 0.5]], None);
    check(&[[-0.2, -0.5, 0.4, 0.5]], None);
    check(&[[4.0 + RADIUS_M, -0.5, 4.5, 0.5]], None);
    check(&[[1.0, 0.0, 1.0, 0.0]], Some(3));
    check(&room([-1.0, -1.0, 1.0, 1.0]), None);
    check(&room([3.0, -1.0, 5.0, 1.0]), None);
    // The same box many times over.
    check(&[[1.0, -0.5, 2.0, 0.5]; 50], Some(4));
}

#[test]
fn gaps_let_through_what_is_narrower() {
    fn check(gap_m: f64, expected: bool) {
        let found = search(&wall_with_gap(gap_m), [0.0, 3.0], [4.0, -3.0]);
        assert_eq!(found.path.is_ok(), expected, "{gap_m}: {found:?}");
        assert!(expected || found.path == Err(NoPath::Closed));
    }
    for (more_m, expected) in [(-0.1, false), (-1e-6, false), (0.0, false), (1e-3, true), (0.05, true), (1.0, true)] {
        check(2.0 * RADIUS_M + more_m, expected);
    }
}

#[test]
fn boxes_that_meet_at_a_corner_leave_no_gap() {
    let mut boxes = room([-1.0, -2.0, 5.0, 2.0]);
    boxes.extend([[1.0, -2.0, 2.0, 0.0], [2.0, 0.0, 3.0, 2.0]]);
    assert_eq!(search(&boxes, [0.0, 0.0], [4.0, 0.0]).path, Err(NoPath::Closed));
    // Apart by the base's width and what the fan of a corner adds to the arc.
    for (apart_m, expected) in [(2.0 * RADIUS_M - 0.001, false), (2.0 * RADIUS_M + 0.015, true)] {
        let diagonal_m = apart_m / 2.0_f64.sqrt();
        boxes[5] = [2.0 + diagonal_m, diagonal_m, 3.0, 2.0];
        let found = search(&boxes, [0.0, 0.0], [4.0, -1.0]);
        assert_eq!(found.path.is_ok(), expected, "{apart_m}");
    }
}

#[test]
fn distances_do_not_matter() {
    let far = 10_000.0;
    let mut boxes = vec![[-far, -far, 1.0 - far, 1.0 - far], [far - 1.0, far - 1.0, far, far]];
    boxes.push([-1.0, -far, 1.0, far - 3.0]);
    boxes.push([-1.0, far - 2.0, 1.0, far]);
    let (from, to) = ([-far, 0.0], [far, 0.5]);
    let found = search(&boxes, from, to);
    assert!(length_m(from, &found.path.clone().expect("there is a gap at the end")) < 3.0 * far);
    assert!(found.steps < 1_000, "{found:?}");
    // A speck and a continent.
    let found = search(&[[0.0, 0.0, 1e-9, 1e-9], [-far, 1.0, far, far]], [-far, 0.0], [far, 0.0]);
    assert!(found.path.is_ok() && found.steps < 1_000, "{found:?}");
}

/// Splitmix: the same worlds on every run.
fn scattered(count: usize, side_m: f64, seed: u64) -> Vec<Corners> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) as f64 / u64::MAX as f64
    };
    let all = std::iter::repeat_with(move || {
        let (x, y) = (next() * side_m, next() * side_m);
        [x, y, x + 0.2 + 0.8 * next(), y + 0.2 + 0.8 * next()]
    });
    let is_clear = move |solid: &Corners| {
        off_m(*solid, Point2::origin()) > 1.0 && off_m(*solid, Point2::new(side_m, side_m)) > 1.0
    };
    all.filter(is_clear).take(count).collect()
}

#[test]
fn a_path_is_searched_once_and_shared() {
    let (walled, open) = (free_space(&[[1.0, -0.5, 2.0, 0.5]]), free_space(&[]));
    let (walled, open) = (Arc::new(walled), Arc::new(open));
    let [from, elsewhere, to] = [0.0, 0.1, 4.0].map(|x| Pose::new(x, 0.0, 0.0));
    let ways = Ways::new(&walled, from);
    // Many ask at once, and all are told the same, which lies in one place.
    let found: Vec<_> = std::thread::scope(|scope| {
        let asking: Vec<_> = (0..4).map(|_| scope.spawn(|| ways.to(to).expect("around").as_ptr().addr())).collect();
        asking.into_iter().map(|asked| asked.join().expect("no panic")).collect()
    });
    assert!(found.iter().all(|at| *at == found[0]));
    assert!(ways.to(to).expect("around").len() > 1);
    assert!(ways.are_from(&walled, from) && !ways.are_from(&walled, elsewhere) && !ways.are_from(&open, from));
    assert_eq!(Ways::new(&open, from).to(to), Ok(&[to][..]));
}

/// What comes to stand on what is left of a way stops it, and what comes to stand behind does not.
#[test]
fn what_is_left_of_a_way_is_what_must_be_free() {
    let way = [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [5.0, 3.0]].map(|[x, y]| Pose::new(x, y, 0.0));
    let at = |x: f64, y: f64| free_space(&[[x - 0.1, y - 0.1, x + 0.1, y + 0.1]]);
    for (from, obstacle, is_free) in [
        ([0.0, 0.0], [1.0, 0.0], false),
        ([1.9, 0.0], [1.0, 0.0], true),
        ([0.0, 0.0], [2.0, 1.5], false),
        ([2.0, 2.5], [2.0, 1.5], true),
        ([2.0, 2.5], [4.0, 3.0], false),
        ([4.9, 3.0], [4.0, 3.0], true),
        ([0.0, 0.0], [4.0, 1.0], true),
    ] {
        let ([x, y], from) = (obstacle, Point2::from(from));
        assert_eq!(at(x, y).is_free(from, &way), is_free, "{from:?} {obstacle:?}");
    }
    assert!(at(0.0, 0.0).is_free(Point2::new(0.0, 0.0), &[]), "who drives nowhere is in nobody's way");
}

/// What the base touches where it stands it may leave, but neither slide along nor come nearer to.
#[test]
fn what_is_touched_at_the_start_is_left() {
    let space = free_space(&[[1.0, -0.5, 2.0, 0.5]]);
    let touching = Pose::new(1.0 - RADIUS_M + 0.01, 0.0, 0.0);
    for (to, expected) in [
        // Straight away from it.
        ([-3.0, 0.0], Some(1)),
        ([-3.0, 3.0], Some(1)),
        // Around it.
        ([4.0, 0.0], None),
        // Where it would still be touched.
        ([touching.at.x - 0.005, 0.0], Some(0)),
    ] {
        let found = find_path(&space, touching, Pose::new(to[0], to[1], 0.0)).path;
        match expected {
            Some(0) => assert_eq!(found, Err(NoPath::Closed), "{to:?}"),
            Some(legs) => assert_eq!(found.expect("it leaves").len(), legs, "{to:?}"),
            None => {
                let way: Vec<_> = [touching].into_iter().chain(found.expect("around")).collect();
                assert!(way.len() > 2, "{way:?}");
                assert!(way[1..].windows(2).all(|leg| is_leg_free(&space, leg[0].at, leg[1].at)), "{way:?}");
                assert!(space.is_free(touching.at, &way), "{way:?}");
            }
        }
    }
    let within = Pose::new(1.2, 0.0, 0.0);
    assert_eq!(find_path(&space, within, Pose::new(-3.0, 0.0, 0.0)).path, Err(NoPath::Closed));
    let along = [touching, Pose::new(touching.at.x, 0.3, 0.0)];
    assert!(!space.is_free(touching.at, &along));
}

#[test]
fn work_is_bounded_among_2_000_boxes() {
    let is_bounded = |found: &Found| found.steps < MOST_STEPS && found.expansions < MOST_EXPANSIONS;
    let side_m = 90.0;
    let found = search(&scattered(2_000, side_m, 1), [0.0, 0.0], [side_m, side_m]);
    assert!(found.path.is_ok() && is_bounded(&found), "{} {}", found.steps, found.expansions);
    // So dense that most of them touch.
    let side_m = 20.0;
    let mut boxes = scattered(2_000, side_m, 1);
    boxes.extend(room([-1.0, -1.0, side_m + 1.0, side_m + 1.0]));
    let found = search(&boxes, [0.0, 0.0], [side_m, side_m]);
    assert!(found.path == Err(NoPath::Closed) && is_bounded(&found), "{} {}", found.steps, found.expansions);
}

/// Each end is shut in with so many boxes that all ways between them cannot be tried.
#[test]
fn a_search_beyond_the_bound_says_so() {
    let side_m = 60.0;
    let one = scattered(800, side_m, 1);
    let moved = |&[x, y, to_x, to_y]: &Corners| [x + 100.0, y, to_x + 100.0, to_y];
    let mut boxes: Vec<_> = one.iter().copied().chain(one.iter().map(moved)).collect();
    boxes.extend(room([-2.0, -2.0, side_m + 2.0, side_m + 2.0]));
    boxes.extend(room([98.0, -2.0, side_m + 102.0, side_m + 2.0]));
    let found = search(&boxes, [0.0, 0.0], [100.0, 0.0]);
    assert_eq!(found.path, Err(NoPath::Beyond(2_000_000)), "{} {}", found.steps, found.expansions);
    assert!(found.steps < 2_010_000, "{}", found.steps);
}

/// A room with boxes and two points, in decimeters so that touches are frequent.
fn rooms() -> impl Strategy<Value = (Vec<Corners>, [f64; 2], [f64; 2])> {
    let at = || (2..58_u32, 2..58_u32).prop_map(|(x, y)| [f64::from(x) / 10.0, f64::from(y) / 10.0]);
    let solid = (at(), 0..20_u32, 0..20_u32)
        .prop_map(|([x, y], w, h)| [x, y, x + f64::from(w) / 10.0, y + f64::from(h) / 10.0]);
    let solids = proptest::collection::vec(solid, 0..10);
    (solids, at(), at()).prop_map(|(mut boxes, from, to)| {
        boxes.extend(room([0.0, 0.0, 6.0, 6.0]));
        (boxes, from, to)
    })
}

/// Whether a fill of points 5 cm apart comes from one to the other with a base that is so much wider.
fn fill_reaches(boxes: &[Corners], from: [f64; 2], to: [f64; 2], wider_m: f64) -> bool {
    const POINT_M: f64 = 0.05;
    let point = |[x, y]: [f64; 2]| ((x / POINT_M).round() as i32, (y / POINT_M).round() as i32);
    let is_free = |(x, y): (i32, i32)| {
        let at = Point2::new(f64::from(x) * POINT_M, f64::from(y) * POINT_M);
        boxes.iter().all(|&solid| off_m(solid, at) > RADIUS_M + wider_m)
    };
    let (start, goal) = (point(from), point(to));
    if !is_free(start) || !is_free(goal) {
        return false;
    }
    let (mut seen, mut open) = (BTreeSet::from([start]), VecDeque::from([start]));
    while let Some((x, y)) = open.pop_front() {
        for next in [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)] {
            if is_free(next) && seen.insert(next) {
                open.push_back(next);
            }
        }
    }
    seen.contains(&goal)
}

/// Whether nobody who stands elsewhere is stopped on a leg.
fn is_leg_free(space: &FreeSpace, a: Point2<f64>, b: Point2<f64>) -> bool {
    let (start, steps) = (Point2::new(f64::NAN, f64::NAN), Steps::default());
    Legs { space, start, steps: &steps }.stopped_by(a, b).is_none()
}

/// The shortest of all ways over all corners.
fn shortest_m(boxes: &[Corners], from: [f64; 2], to: [f64; 2]) -> Option<f64> {
    let space = free_space(boxes);
    let mut points = vec![Point2::from(from), Point2::from(to)];
    if !points.iter().all(|&at| is_leg_free(&space, at, at)) {
        return None;
    }
    points.extend((0..boxes.len()).flat_map(|solid| space.turns(solid)));
    points.retain(|&at| is_leg_free(&space, at, at));
    let mut cost_m = vec![f64::INFINITY; points.len()];
    let mut open: BTreeSet<_> = (0..points.len()).collect();
    cost_m[0] = 0.0;
    while let Some(&at) = open.iter().min_by(|&&a, &&b| cost_m[a].total_cmp(&cost_m[b])) {
        open.remove(&at);
        if at == 1 || cost_m[at].is_infinite() {
            break;
        }
        for &next in &open {
            let far_m = cost_m[at] + nalgebra::distance(&points[at], &points[next]);
            if far_m < cost_m[next] && is_leg_free(&space, points[at], points[next]) {
                cost_m[next] = far_m;
            }
        }
    }
    cost_m[1].is_finite().then_some(cost_m[1])
}

/// Parry's word, which the base's paths went by before.
fn is_free_by_parry([x, y, to_x, to_y]: Corners, a: [f64; 2], b: [f64; 2], radius_m: f64) -> bool {
    let flat = |[x, y]: [f64; 2]| ParryVector::new(x as f32, y as f32, 0.0);
    let swept = Capsule::new(flat(a), flat(b), radius_m as f32);
    let cuboid = Cuboid::new(ParryVector::new((to_x - x) as f32 / 2.0, (to_y - y) as f32 / 2.0, 1.0));
    let at = ParryPose::from_translation(flat([(x + to_x) / 2.0, (y + to_y) / 2.0]));
    let test = intersection_test(&ParryPose::IDENTITY, &swept, &at, &cuboid);
    !test.expect("parry tests capsules against boxes").intersecting
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn legs_are_judged_as_parry_does(
        at in prop::array::uniform2(-4.0..4.0), size in prop::array::uniform2(0.01..3.0),
        a in prop::array::uniform2(-6.0..6.0), b in prop::array::uniform2(-6.0..6.0),
    ) {
        let solid = [at[0], at[1], at[0] + size[0], at[1] + size[1]];
        let space = free_space(&[solid]);
        let is_free = is_leg_free(&space, a.into(), b.into());
        let by_parry = [-1e-3, 1e-3].map(|more_m| is_free_by_parry(solid, a, b, RADIUS_M + more_m));
        prop_assert!(by_parry[0] != by_parry[1] || is_free == by_parry[0]);
    }

    /// A room that is turned about the origin is the same room.
    #[test]
    fn turned_rooms_have_the_same_paths((boxes, from, to) in rooms(), heading in -3.2..3.2) {
        prop_assume!(stands_free(&boxes, from));
        let upright = search(&boxes, from, to).path;
        let turn = nalgebra::Rotation2::new(heading);
        let turned = |at: [f64; 2]| { let at = turn * Point2::from(at); Pose::new(at.x, at.y, 0.0) };
        let solid = |&[x, y, to_x, to_y]: &Corners| {
            let solid = Obstacle::between(Point3::new(x, y, 0.0), Point3::new(to_x, to_y, 1.0));
            let middle = turn * solid.middle.xy();
            Obstacle { middle: Point3::new(middle.x, middle.y, solid.middle.z), heading, ..solid }
        };
        let space = FreeSpace::new(&boxes.iter().map(solid).collect::<Vec<_>>(), RADIUS_M);
        let path = find_path(&space, turned(from), turned(to)).path;
        // What is touched exactly may be touched or not by the last digit.
        let is_open = |radius_m| {
            let solids: Vec<_> = boxes.iter().map(solid).collect();
            find_path(&FreeSpace::new(&solids, radius_m), turned(from), turned(to)).path.is_ok()
        };
        let is_touch = is_open(RADIUS_M - 1e-6) != is_open(RADIUS_M + 1e-6);
        prop_assert!(is_touch || path.is_ok() == upright.is_ok());
        if let (Ok(path), Ok(upright)) = (path, upright) {
            let first = turned(from);
            let far_m = |first: Pose, path: &[Pose]| {
                std::iter::once(&first).chain(path).zip(path).map(|(a, b)| a.distance_m(b)).sum::<f64>()
            };
            let (one_m, other_m) = (far_m(first, &path), far_m(Pose::new(from[0], from[1], 0.0), &upright));
            prop_assert!((one_m - other_m).abs() < 0.02, "{one_m} {other_m}");
        }
    }

    #[test]
    fn small_rooms_agree_with_a_fine_grid((boxes, from, to) in rooms()) {
        prop_assume!(stands_free(&boxes, from));
        let found = search(&boxes, from, to);
        if fill_reaches(&boxes, from, to, 0.01) {
            prop_assert!(found.path.is_ok());
        }
        prop_assert!(!matches!(found.path, Err(NoPath::Beyond(_))));
    }

    #[test]
    fn paths_are_the_shortest_over_corners((boxes, from, to) in rooms()) {
        prop_assume!(stands_free(&boxes, from));
        let found = search(&boxes, from, to);
        match (shortest_m(&boxes, from, to), found.path) {
            (Some(shortest_m), Ok(path)) => prop_assert!(length_m(from, &path) < shortest_m * 1.01 + 1e-9, "{shortest_m} {}", length_m(from, &path)),
            (None, Err(_)) => {}
            (shortest_m, path) => prop_assert!(false, "{shortest_m:?} {path:?}"),
        }
    }
}
