//! What comes to stand in the room while the base drives (`semantics` 3): it stops in time, the drive has failed, and the tree
//! goes on by its rules.

use std::sync::Arc;

use ambidex::model::{
    Change, ControllerId, ControllerKind, ControllerMessage, End, Fault, Labels, MissionEnd, MissionSpec, Obstacle,
    PlaceId, Record, Time,
};
use ambidex::motion::{ControllerState, STEP, ToController, simulated};
use ambidex::tree::Settings;
use nalgebra::{Point2, Rotation2, Vector3};

use crate::driver::Rng;
use crate::fixtures::{file, load, simulate_wrongs, steps};
use crate::home::Home;

/// A corridor with a place at its end, and one beside its beginning.
fn corridor(home: &Home, more: &str, task: &str) -> Arc<MissionSpec> {
    let text = format!(
        "mission: corridor\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n    end: {{stand: [8, 0]}}\n    \
         beside: {{stand: [-12, 0]}}\n{more}task: {task}\n",
        file("config/robots/pr2.yaml").display()
    );
    load(&home.write("mission.yaml", &text))
}

/// Walls on both sides that leave no way around.
const WALLS: &str =
    "  walls: [{from: [2, -1.2], to: [9, -1.2]}, {from: [2, 1.2], to: [9, 1.2]}, {from: [9, -1.2], to: [9, 1.2]}]\n";

fn run(mission: &Arc<MissionSpec>, failures: &str) -> (MissionEnd, Vec<Record>) {
    simulate_wrongs(mission, &Settings::default(), failures)
}

fn said(mission: &MissionSpec, records: &[Record]) -> Vec<String> {
    let refusals = records.iter().flat_map(|record| record.refusals());
    refusals.map(|blocked| blocked.reason.sentence(&mission.names)).collect()
}

/// How a behavior ended, each time that it ran.
fn ends(mission: &MissionSpec, records: &[Record], behavior: &str) -> Vec<End> {
    let ended = records.iter().filter_map(|record| match record {
        Record::Released { leaf, end, .. } if mission.names.node(*leaf) == behavior => Some(*end),
        _ => None,
    });
    ended.collect()
}

/// How far a point of the map is from a box, meters: by its corners and sides, not by the code that drives.
fn off_m(solid: &Obstacle, at: Point2<f64>) -> f64 {
    let own = Rotation2::new(-solid.heading) * (at - solid.middle.xy());
    (own.abs() - solid.size.xy() / 2.0).map(|side| side.max(0.0)).norm()
}

/// How near the middle of the base ever was to what stood there then, meters: with the drives that were told done once more.
fn nearest_m(mission: &MissionSpec, records: &[Record]) -> f64 {
    let index = mission.robot.controllers.iter().position(|spec| matches!(spec.kind, ControllerKind::Base(_)));
    let id = ControllerId::from(index.expect("a base"));
    let limits = mission.robot.controllers[id.index()].kind;
    let mut base = simulated(&limits);
    base.configure(&limits, ControllerState::Base { pose: mission.start.base, velocity: Vector3::zeros() });
    let labels = Labels::new(&mission.names);
    let (mut there, mut now, mut nearest_m) = (Vec::<Obstacle>::new(), Time::ZERO, f64::MAX);
    for record in records {
        while now + STEP <= record.at() {
            let ControllerState::Base { pose, .. } = base.state() else { panic!("a base") };
            let off = there.iter().map(|solid| off_m(solid, pose.at));
            nearest_m = off.fold(nearest_m, f64::min);
            base.step();
            now = now + STEP;
        }
        match record {
            Record::World { change: Change::Blocked(obstacle), .. } => there.push(*obstacle),
            Record::World { change: Change::Cleared(around), .. } => there.retain(|solid| !solid.is_around(around.at)),
            Record::Controller { controller, message: ControllerMessage::Told { message, .. }, .. }
                if *controller == id =>
            {
                match labels.told(message) {
                    ToController::Goal { command, mode, .. } => base.start(&command, mode).expect("it is free"),
                    ToController::Cancel { .. } => base.cancel(),
                    ToController::Configure { .. } => {}
                }
            }
            _ => {}
        }
    }
    let at = records.iter().rev().find_map(|record| match record {
        Record::Observed { change: Change::Base(pose), .. } => Some(*pose),
        _ => None,
    });
    let ControllerState::Base { pose, .. } = base.state() else { panic!("a base") };
    assert!(at.is_none_or(|at| at.distance_m(&pose) < 0.05), "{pose:?} is where it was, {at:?}");
    nearest_m
}

#[test]
fn a_drive_stops_and_is_tried_again_around_what_stands_there() {
    let home = Home::new();
    let mission = corridor(&home, "", "{move: end}");
    let block = "  - {at: 3 s, block: {at: [5, 0.2], size: [0.6, 0.6]}}\n";
    let (end, records) = run(&mission, block);
    assert_eq!(end, MissionEnd::Done);
    assert_eq!(steps(&mission, &records), "move to end, move to end");
    assert_eq!(ends(&mission, &records, "move to end"), [End::Failed(Fault::Blocked), End::Succeeded]);
    assert!(nearest_m(&mission, &records) > mission.robot.radius_m, "{}", nearest_m(&mission, &records));
    // It is told why it was stopped, and why it waits.
    let told = said(&mission, &records);
    assert!(told.iter().any(|said| said.contains("something came to stand in its way")), "{told:?}");
    let stopped = records.iter().find(|record| matches!(record, Record::Stopped { .. })).expect("stopped");
    assert_eq!(stopped.at(), Time(3_000_000), "at once");
}

#[test]
fn what_does_not_stand_on_what_is_left_of_the_way_stops_nothing() {
    let home = Home::new();
    let mission = corridor(&home, "", "{move: end}");
    for block in [
        "  - {at: 3 s, block: {at: [5, 2], size: [0.6, 0.6]}}\n",
        // Behind it.
        "  - {at: 8 s, block: {at: [2, 0], size: [0.6, 0.6]}}\n",
        // It is gone before the base has come to a stop.
        "  - {at: 3 s, block: {at: [5, 3], size: [0.6, 0.6]}}\n  - {at: 3.1 s, unblock: [5, 3]}\n",
    ] {
        let (end, records) = run(&mission, block);
        assert_eq!((end, steps(&mission, &records).as_str()), (MissionEnd::Done, "move to end"), "{block}");
    }
}

#[test]
fn a_way_that_is_shut_waits_until_it_is_open() {
    let home = Home::new();
    let mission = corridor(&home, WALLS, "{move: end, retries: 5}");
    let shut = "  - {at: 3 s, block: {at: [5, 0], size: [0.4, 1.4]}}\n";
    let (end, records) = run(&mission, shut);
    assert_eq!(end, MissionEnd::Stalled, "{}", steps(&mission, &records));
    let told = said(&mission, &records);
    assert!(told.iter().any(|said| said == "no free path leads to end"), "{told:?}");
    let waits = records.iter().find_map(|record| match record {
        Record::Awaited { facts, places, .. } if facts.is_empty() => Some(places.clone()),
        _ => None,
    });
    assert_eq!(waits, Some(vec![PlaceId(0)]));
    // Whoever stands in the way goes again some time.
    let (end, records) = run(&mission, &format!("{shut}  - {{at: 30 s, unblock: [5, 0.5]}}\n"));
    assert_eq!(end, MissionEnd::Done);
    assert_eq!(steps(&mission, &records), "move to end, move to end");
    assert!(nearest_m(&mission, &records) > mission.robot.radius_m);
}

#[test]
fn another_way_is_taken_where_there_is_one() {
    let home = Home::new();
    let task = "{or: [{move: end, retries: 0, name: first}, {move: beside, name: second}]}";
    let mission = corridor(&home, WALLS, task);
    let shut = "  - {at: 3 s, block: {at: [5, 0], size: [0.4, 1.4]}}\n";
    let (end, records) = run(&mission, shut);
    assert_eq!(end, MissionEnd::Done);
    assert_eq!(ends(&mission, &records, "first"), [End::Failed(Fault::Blocked)]);
    assert_eq!(ends(&mission, &records, "second"), [End::Succeeded]);
    // What stood there before it set out is planned around.
    let open = corridor(&home, "", "{move: end}");
    let (end, records) = run(&open, "  - {at: 0 s, block: {at: [4, 0], size: [1, 1], heading: 45 deg}}\n");
    assert_eq!(end, MissionEnd::Done);
    assert!(steps(&open, &records).ends_with("move to end") && nearest_m(&open, &records) > open.robot.radius_m);
}

/// The case that was seen: a box that reaches 3 cm into the way.
#[test]
fn a_way_that_is_shut_by_little_is_shut() {
    let home = Home::new();
    let mission = corridor(&home, "", "{move: end}");
    for y in [0.55, 0.6, 0.62] {
        let (end, records) = run(&mission, &format!("  - {{at: 3 s, block: {{at: [5, {y}], size: [0.3, 0.3]}}}}\n"));
        assert_eq!(end, MissionEnd::Done);
        let near_m = nearest_m(&mission, &records);
        assert!(near_m > mission.robot.radius_m, "{y}: {near_m}");
        assert_eq!(ends(&mission, &records, "move to end"), [End::Failed(Fault::Blocked), End::Succeeded], "{y}");
    }
    // Past this one it drives on.
    let (_, records) = run(&mission, "  - {at: 3 s, block: {at: [5, 0.64], size: [0.3, 0.3]}}\n");
    assert_eq!(ends(&mission, &records, "move to end"), [End::Succeeded]);
    assert!(nearest_m(&mission, &records) > mission.robot.radius_m);
}

/// What stands so near that it is touched is left behind.
#[test]
fn the_base_gets_away_from_what_touches_it() {
    let home = Home::new();
    let mission = corridor(&home, "", "{move: end}");
    let (end, records) = run(&mission, "  - {at: 0 s, block: {at: [-0.57, 0], size: [0.2, 0.2]}}\n");
    assert_eq!((end, steps(&mission, &records).as_str()), (MissionEnd::Done, "move to end"));
    assert!(nearest_m(&mission, &records) > mission.robot.radius_m - 0.011);
}

/// Wherever and whenever it comes, unless it comes nearer than the base can brake.
#[test]
fn the_base_never_drives_into_what_came() {
    let home = Home::new();
    let mut rng = Rng::of(&[16]);
    let mut stopped = 0;
    for _ in 0..60 {
        let mut number = |from: f64, to: f64| from + (to - from) * rng.below(1_000) as f64 / 1_000.0;
        let goal = [number(4.0, 8.0), number(-4.0, 4.0)];
        let places =
            format!("  objects: {{}}\n  obstacles: [{{at: [{}, {}], size: [0.5, 0.5]}}]\n", 2.0, number(-2.0, 2.0));
        let text = format!(
            "mission: random\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places: {{goal: {{stand: [{}, {}]}}}}\n{}\
             task: {{move: goal, retries: 9}}\n",
            file("config/robots/pr2.yaml").display(),
            goal[0],
            goal[1],
            places.replace("  objects: {}\n", "")
        );
        let mission = load(&home.write("mission.yaml", &text));
        let (at_s, share) = (number(0.5, 6.0), number(0.2, 0.9));
        let (x, y) = (goal[0] * share + number(-0.5, 0.5), goal[1] * share + number(-0.5, 0.5));
        let block = format!(
            "  - {{at: {at_s:.2} s, block: {{at: [{x:.2}, {y:.2}], size: [{:.2}, {:.2}], heading: {:.2} rad}}}}\n",
            number(0.1, 0.8),
            number(0.1, 0.8),
            number(-1.5, 1.5)
        );
        let (_, records) = run(&mission, &block);
        let came = records.iter().position(|record| matches!(record, Record::World { .. })).expect("it came");
        let before = records[..came].iter().rev().find_map(|record| match record {
            Record::Observed { change: Change::Base(pose), .. } => Some(pose.at),
            _ => None,
        });
        let Record::World { change: Change::Blocked(solid), .. } = &records[came] else { continue };
        // Where it is as the thing comes; it needs 0.64 m from its top speed, and a tenth of a second passes at most.
        let room_m = off_m(solid, before.unwrap_or_default()) - mission.robot.radius_m;
        if room_m < 0.75 {
            continue;
        }
        stopped += usize::from(ends(&mission, &records, "move to goal").contains(&End::Failed(Fault::Blocked)));
        let near_m = nearest_m(&mission, &records);
        assert!(near_m > mission.robot.radius_m - 1e-6, "{near_m}: {text}{block}");
    }
    assert!(stopped > 5, "{stopped}: it was worth trying");
}
