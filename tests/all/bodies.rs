//! What the robot's body lets go on at once, and which hand takes what (`semantics` 3): each sentence with its missions, and
//! others of its kind.

use std::path::Path;
use std::sync::Arc;

use ambidex::model::{
    BaseSpec, Blocked, Clash, ControllerKind, ControllerMessage, ControllerState, FromController, MissionEnd,
    MissionSpec, Mode, Obstacle, Pose, Reason, Record, ResourceId,
};
use ambidex::motion::{Base, Command, Controller, Progress, STEP};
use ambidex::show::map::Scene;
use ambidex::tree::Settings;
use ambidex::world::{FreeSpace, find_path};
use nalgebra::{Point2, Point3, Rotation2, Vector3};

use crate::driver::Rng;
use crate::fixtures::{file, load, simulate_wrongs, steps};
use crate::home::Home;

const LEFT: ResourceId = ResourceId(0);
const RIGHT: ResourceId = ResourceId(1);

/// A mission of the robot of the paper before three surfaces that it need not drive to.
fn desk(robot: &str, task: &str) -> String {
    format!(
        "mission: desk\nrobot: {robot}\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n    \
         centre: {{stand: [0, 0], surface: [0.55, 0, 0.75]}}\n    \
         far right: {{stand: [0, 0], surface: [0.3, -0.85, 0.75]}}\n    \
         far left: {{stand: [0, 0], surface: [0.3, 0.85, 0.75]}}\n    \
         far away: {{stand: [0, 0], surface: [2, 0, 0.75]}}\n  \
         objects: {{nut: {{at: centre, offset: [0, 0]}}}}\ntask:\n  {task}\n"
    )
}

fn pr2() -> String {
    file("config/robots/pr2.yaml").display().to_string()
}

/// The first of both hands that a behavior was granted.
fn hand(mission: &MissionSpec, records: &[Record], behavior: &str) -> Option<ResourceId> {
    let mut granted = records.iter().flat_map(|record| match record {
        Record::Decided { granted, .. } => granted.as_slice(),
        _ => &[],
    });
    let grant = granted.find(|grant| mission.names.node(grant.leaf()) == behavior)?;
    grant.bindings.iter().map(|binding| binding.resource).find(|resource| [LEFT, RIGHT].contains(resource))
}

fn done(path: &Path) -> (Arc<MissionSpec>, Vec<Record>) {
    let mission = load(path);
    let (end, records) = simulate_wrongs(&mission, &Settings::default(), "");
    assert_eq!(end, MissionEnd::Done, "{}: {}", path.display(), steps(&mission, &records));
    (mission, records)
}

/// As it was reported: nobody told an offset.
#[test]
fn a_place_that_only_one_hand_reaches_takes_that_hand() {
    let task = "then: [{move: centre}, {pick: nut}, {move: far right}, {place: nut}]";
    let home = Home::new();
    let text = desk(&pr2(), task).replace("nut: {at: centre, offset: [0, 0]}", "nut: {at: centre}");
    let (mission, records) = done(&home.write("mission.yaml", &text));
    assert_eq!(hand(&mission, &records, "pick nut"), Some(RIGHT));
    let text =
        desk(&pr2(), &task.replace("far right", "far left")).replace("{at: centre, offset: [0, 0]}", "{at: centre}");
    let (mission, records) = done(&home.write("mission.yaml", &text));
    assert_eq!(hand(&mission, &records, "pick nut"), Some(LEFT));
}

/// The hand that picks the nut.
fn check_hand(task: &str, expected: ResourceId) {
    let home = Home::new();
    let (mission, records) = done(&home.write("mission.yaml", &desk(&pr2(), task)));
    assert_eq!(hand(&mission, &records, "pick nut"), Some(expected), "{task}");
}

#[test]
fn the_hand_that_takes_reaches_where_it_is_to_go() {
    for (side, hand) in [("far right", RIGHT), ("far left", LEFT)] {
        check_hand(&format!("then: [{{move: centre}}, {{pick: nut}}, {{move: {side}}}, {{place: nut}}]"), hand);
        // The place is told by what comes later, wherever in the tree that stands.
        let later = format!("{{then: [{{move: {side}}}, {{place: nut}}]}}");
        check_hand(&format!("then: [{{then: [{{move: centre}}, {{pick: nut}}]}}, {later}]"), hand);
        let one_way = "{then: [{move: far away}, {place: {object: nut, at: far away}}]}";
        check_hand(&format!("then: [{{move: centre}}, {{pick: nut}}, {{or: [{one_way}, {later}]}}]"), hand);
    }
    // Once it has been put down, another hand may take it.
    let again = "{then: [{pick: nut, name: again}, {move: far right}, {place: nut}]}";
    check_hand(
        &format!("then: [{{move: centre}}, {{pick: nut}}, {{place: {{object: nut, at: centre}}}}, {again}]"),
        LEFT,
    );
}

/// Why it is this hand is told with what was granted.
#[test]
fn it_is_told_why_a_hand_and_not_the_other() {
    let home = Home::new();
    let log = home.path("run.jsonl");
    let log = log.to_str().expect("a path");
    for (objects, task, words) in [
        (
            "nut: {at: centre, offset: [0, 0]}",
            "then: [{move: centre}, {pick: nut}, {move: far right}, {place: nut}]",
            "left_gripper would not reach what place nut asks later.",
        ),
        (
            "nut: {at: centre, offset: [-0.25, 0.85]}",
            "then: [{move: centre}, {pick: nut}]",
            "right_gripper does not reach it.",
        ),
        (
            "bolt: {at: centre, offset: [-0.25, 0.85]}, nut: {at: centre, offset: [0, 0.1]}",
            "then: [{move: centre}, {and: [{pick: nut}, {pick: bolt}]}]",
            "left_gripper, which is nearer, is for pick bolt.",
        ),
    ] {
        let text = desk(&pr2(), task).replace("nut: {at: centre, offset: [0, 0]}", objects);
        let path = home.write("mission.yaml", &text);
        home.start(["simulate", path.to_str().expect("a path"), "--log", log]).ends(0);
        let story = crate::home::flat(&home.start(["explain", log, "pick nut"]).ends(0).stdout);
        assert!(story.contains(words), "{words}: {story}");
    }
}

#[test]
fn what_no_hand_can_do_is_said_beforehand() {
    let home = Home::new();
    let task = "then: [{move: centre}, {pick: nut}, {move: far away}, {place: nut}]";
    let text = desk(&pr2(), task).replace(
        "far away: {stand: [0, 0], surface: [2, 0, 0.75]}",
        "far away: {stand: [0, 3], surface: [2, 0, 0.75]}",
    );
    let path = home.write("mission.yaml", &text);
    let said = home.start(["check", path.to_str().expect("a path")]).ends(0);
    let words = "it can never run: nothing that could take nut reaches what place nut asks of it later";
    assert!(crate::home::flat(&said.words()).contains(words), "{said:#?}");
}

/// One arm at a time is in the bin, and not every arm reaches every box.
#[test]
fn each_arm_pulls_what_it_can_drop() {
    let (mission, records) = done(&file("config/missions/bin-picking.yaml"));
    let is_rejected = |record: &Record| {
        let Record::Controller { message, .. } = record else { return false };
        matches!(message, ControllerMessage::Heard { message: FromController::Rejected { .. }, .. })
    };
    assert!(!records.iter().any(is_rejected), "no arm was asked for what it does not reach");
    // While the one drops, the other pulls, where their arms do not cross.
    assert!(steps(&mission, &records).contains(" + pull "), "{}", steps(&mission, &records));
    let crosses = |blocked: &Blocked| matches!(blocked.reason, Reason::Clash { over: Clash::Arms, .. });
    assert!(records.iter().any(|record| record.refusals().iter().any(crosses)), "it is said why others wait");
}

/// A mission of the robot of the paper, with arms that have a body, before one surface.
fn two_arms(objects: &str, task: &str) -> (Arc<MissionSpec>, Vec<Record>) {
    let home = Home::new();
    let text = desk(&file("config/robots/pr2.yaml").display().to_string(), task);
    done(&home.write("mission.yaml", &text.replace("nut: {at: centre, offset: [0, 0]}", objects)))
}

#[test]
fn picks_side_by_side_take_the_arms_that_do_not_cross() {
    let objects = "bolt: {at: centre, offset: [0, -0.15]}, nut: {at: centre, offset: [0, 0.15]}";
    for order in [
        "[{pick: {object: bolt, at: centre}}, {pick: {object: nut, at: centre}}]",
        "[{pick: {object: nut, at: centre}}, {pick: {object: bolt, at: centre}}]",
    ] {
        let (mission, records) = two_arms(objects, &format!("and: {order}"));
        assert!(steps(&mission, &records).contains(" + "), "both at once");
        assert_eq!(hand(&mission, &records, "pick nut"), Some(LEFT));
        assert_eq!(hand(&mission, &records, "pick bolt"), Some(RIGHT));
    }
    // What the left arm alone reaches it gets, though it is nearer to the other one as well.
    let objects = "bolt: {at: centre, offset: [0, 0.1]}, nut: {at: centre, offset: [-0.25, 0.85]}";
    let task = "and: [{pick: {object: bolt, at: centre}}, {pick: {object: nut, at: centre}}]";
    let (mission, records) = two_arms(objects, task);
    assert_eq!(steps(&mission, &records), "pick bolt + pick nut");
    assert_eq!(hand(&mission, &records, "pick bolt"), Some(RIGHT));
}

#[test]
fn arms_that_would_cross_wait_for_each_other() {
    // The nut on the left is to go to the right, and the bolt on the right to the left.
    let objects = "bolt: {at: centre, offset: [0, -0.15]}, nut: {at: centre, offset: [0, 0.15]}";
    let then = |object: &str, side: &str| {
        format!("{{then: [{{pick: {{object: {object}, at: centre}}}}, {{place: {{object: {object}, at: {side}}}}}]}}")
    };
    let task = format!("and: [{}, {}]", then("nut", "far right"), then("bolt", "far left"));
    let (mission, records) = two_arms(objects, &task);
    assert_eq!(hand(&mission, &records, "pick nut"), Some(RIGHT));
    assert_eq!(hand(&mission, &records, "pick bolt"), Some(LEFT));
    assert!(!steps(&mission, &records).contains("pick nut + pick bolt"), "{}", steps(&mission, &records));
    let said =
        records.iter().flat_map(|record| record.refusals()).map(|blocked| blocked.reason.sentence(&mission.names));
    let said: Vec<_> = said.collect();
    assert!(said.iter().any(|said| said == "its arm would cross the one of pick nut"), "{said:?}");
}

/// A robot with two bases, as a file can describe it, has one body.
#[test]
fn a_body_is_at_one_place_at_a_time() {
    let home = Home::new();
    let robot = std::fs::read_to_string(file("config/robots/pr2.yaml")).expect("a robot");
    let (head, base) = robot.split_once("  base:\n    base:\n").expect("a base");
    let robot = format!("{head}  base:\n    base:\n{base}\n  second:\n    base:\n{base}");
    let robot = robot.replace(
        "  base: {type: base, controller: base}",
        "  base: {type: base, controller: base}\n  second: {type: base, controller: second}",
    );
    let robot = home.write("robot.yaml", &robot);
    let text = format!(
        "mission: two\nrobot: {}\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n    here: {{stand: [0, 0]}}\n    \
         table: {{stand: [2, 3]}}\n    window: {{stand: [4, 0]}}\n  objects: {{cup: {{at: here}}}}\n\
         task: {{and: [{{move: table}}, {{move: window}}, {{then: [{{move: here}}, {{pick: cup}}]}}]}}\n",
        robot.display()
    );
    let (mission, records) = done(&home.write("mission.yaml", &text));
    assert_eq!(steps(&mission, &records), "pick cup, move to table, move to window");
    let clashes = |blocked: &Blocked| matches!(blocked.reason, Reason::Clash { over: Clash::Base, .. });
    assert!(records.iter().any(|record| record.refusals().iter().any(clashes)), "it is said why");
}

/// Each mistake with what is said of it, where it stands.
#[test]
fn what_cannot_be_in_a_room_is_said() {
    let home = Home::new();
    let robot = file("config/robots/pr2.yaml").display().to_string();
    let check = |from: &str, to: &str, words: &[&str]| {
        let text = format!(
            "mission: room\nrobot: {robot}\nworld:\n  robot: {{at: [0, 0]}}\n  places:\n    \
             shelf: {{table: {{at: [2, 0], size: [0.6, 1.2, 0.75]}}}}\n    \
             desk: {{table: {{at: [0, 3], heading: 45 deg, size: [1, 0.8, 0.7], side: back}}}}\n  \
             walls: [{{from: [-3, -3], to: [-3, 6]}}]\n  \
             objects: {{cup: {{at: shelf, offset: [0, 0.2]}}, pot: {{at: shelf, offset: [0, -0.2]}}}}\n\
             task: {{move: shelf}}\n"
        );
        assert!(text.contains(from), "{from}");
        let path = home.write("room.yaml", &text.replace(from, to));
        let code = if words.is_empty() { 0 } else { 2 };
        let said = home.start(["check", path.to_str().expect("a path")]).ends(code);
        let flat = crate::home::flat(&said.words());
        words.iter().for_each(|word| assert!(flat.contains(word), "{word}: {flat}"));
    };
    check("task:", "task:", &[]);
    check("robot: {at: [0, 0]}", "robot: {at: [2, 0.5]}", &["the robot starts in the table of shelf", "room.yaml:4:"]);
    check("robot: {at: [0, 0]}", "robot: {at: [-2.7, 0]}", &["the robot starts in a wall or an obstacle"]);
    check(
        "from: [-3, -3], to: [-3, 6]",
        "from: [1, -3], to: [1, 6]",
        &[
            "shelf: the base cannot stand there: a wall or an obstacle is in the way",
            "it needs 0.48 m around its stand",
        ],
    );
    check("at: [2, 0], size", "at: [0.5, 3], size", &["desk: its table stands in the table of shelf"]);
    check("from: [-3, -3], to: [-3, 6]", "from: [2, -3], to: [2, 6]", &["shelf: its table stands in a wall"]);
    check("offset: [0, 0.2]", "offset: [0, 0.7]", &["cup: it floats beside the table of shelf"]);
    check("offset: [0, 0.2]", "offset: [0, -0.2]", &["pot: it lies in the same spot as cup"]);
    // A touch is none: walls, tables and what lies on their edges are written with two digits.
    check("offset: [0, 0.2]", "offset: [0, 0.6]", &[]);
    check("from: [-3, -3], to: [-3, 6]", "from: [2.35, -3], to: [2.35, 6]", &[]);
}

/// How far a point of the map is from a box, meters: by its corners and sides, not by the code that drives.
fn off_m(solid: &Obstacle, at: Point2<f64>) -> f64 {
    let turn = Rotation2::new(-solid.heading);
    let own = turn * (at - solid.middle.xy());
    let beyond = own.abs() - solid.size.xy() / 2.0;
    beyond.map(|side| side.max(0.0)).norm()
}

#[test]
fn no_drive_of_the_paper_leads_through_a_table() {
    let (plain, records) = done(&file("config/missions/experiment-1.yaml"));
    let expected = steps(&plain, &records);
    let (mission, records) = done(&file("config/missions/experiment-1-room.yaml"));
    assert_eq!(steps(&mission, &records), expected);
    let mut scene = Scene::new(&mission);
    for record in &records {
        scene.take(record, None);
    }
    assert_eq!(scene.drives.len(), 5);
    for drive in &scene.drives {
        for leg in drive.way.windows(2) {
            for share in 0..=200 {
                let at = leg[0].at + (leg[1].at - leg[0].at) * (f64::from(share) / 200.0);
                let near_m = mission.world.solids().iter().map(|solid| off_m(solid, at)).fold(f64::MAX, f64::min);
                assert!(near_m >= mission.robot.radius_m - 1e-6, "step {}: {near_m}", drive.step);
            }
        }
    }
}

#[test]
fn the_room_is_drawn_from_above() {
    let home = Home::new();
    let mission = file("config/missions/experiment-1-room.yaml");
    let mission = mission.to_str().expect("a path");
    let log = home.path("run.jsonl");
    let log = log.to_str().expect("a path");
    home.start(["simulate", mission, "--log", log]).ends(0);
    let draw = |more: &[&str]| {
        let args = ["map", mission, "-o", "-"].iter().chain(more).copied().map(str::to_owned).collect::<Vec<_>>();
        home.start(args).ends(0).stdout
    };
    let plain = draw(&[]);
    for word in ["shelf", "6 places, 4 objects, 4 obstacles", "left_gripper reaches so far"] {
        assert!(plain.contains(word), "{word}");
    }
    assert!(!plain.contains("class=\"drive\""), "nothing was driven");
    let whole = draw(&["--log", log]);
    assert_eq!(whole.matches("class=\"drive\"").count(), 5);
    assert!(whole.contains("step 9: move 3-2"));
    let early = draw(&["--log", log, "--at", "6"]);
    assert_eq!(early.matches("class=\"drive\"").count(), 3);
    assert!(early.contains("holds 2"), "two of the things are carried");
    let at_once = draw(&["--log", log, "--at", "0s"]);
    assert!(at_once.matches("class=\"drive\"").count() <= 1);
    let refused = home.start(["map", mission, "--log", log, "--at", "11", "-o", "-"]).ends(2);
    assert!(refused.words().contains("there is no step 11: the run had 10"), "{refused:#?}");
}

#[test]
fn a_detour_counts_where_distances_are_those_of_paths() {
    let home = Home::new();
    let text = std::fs::read_to_string(file("config/missions/detour.yaml")).expect("a mission");
    let text = text.replace("../robots/pr2.yaml", &pr2());
    let told = |text: &str| {
        let (mission, records) = done(&home.write("detour.yaml", text));
        let log = home.path("run.jsonl");
        let log = log.to_str().expect("a path");
        home.start(["simulate", home.path("detour.yaml").to_str().expect("a path"), "--log", log]).ends(0);
        let story = home.start(["explain", log, "move to shelf"]).ends(0).stdout;
        (steps(&mission, &records), crate::home::flat(&story))
    };
    let (steps, story) = told(&text);
    assert_eq!(steps, "move to desk, pick pen, move to shelf, pick cup");
    assert!(story.contains("m along the path)"), "{story}");
    let (steps, story) = told(&text.replace("distance: path", "distance: straight"));
    assert_eq!(steps, "move to shelf, pick cup, move to desk, pick pen");
    assert!(story.contains("(1.92 m straight)"), "{story}");
}

#[test]
fn a_place_that_no_way_leads_to_is_told_beforehand() {
    let home = Home::new();
    let text = std::fs::read_to_string(file("config/missions/detour.yaml")).expect("a mission");
    let text = text.replace("../robots/pr2.yaml", &pr2()).replace("to: [5 m, 2.5 m]", "to: [7 m, 2.5 m]");
    let path = home.write("detour.yaml", &text);
    let said = home.start(["check", path.to_str().expect("a path")]).ends(0);
    let said = crate::home::flat(&said.words());
    assert!(said.contains("it can never run: no free path leads to shelf"), "{said}");
    let ended = home.start(["simulate", path.to_str().expect("a path")]).ends(1);
    let told = crate::home::flat(&ended.words());
    assert!(told.contains("no free path leads to shelf"), "{told}");
}

/// A room with walls and boxes that are turned any way.
fn room(rng: &mut Rng) -> Vec<Obstacle> {
    let mut number = |from: f64, to: f64| from + (to - from) * f64::from(rng.below(10_000) as u32) / 10_000.0;
    let wall = |x: f64, y: f64, along: f64, across: f64| {
        Obstacle::between(Point3::new(x, y, 0.0), Point3::new(x + along, y + across, 2.0))
    };
    let mut solids = vec![wall(0.0, 0.0, 8.0, 0.1), wall(0.0, 7.9, 8.0, 0.1)];
    solids.extend([wall(0.0, 0.0, 0.1, 8.0), wall(7.9, 0.0, 0.1, 8.0)]);
    solids.extend((0..9).map(|_| Obstacle {
        middle: Point3::new(number(1.0, 7.0), number(1.0, 7.0), 0.4),
        size: Vector3::new(number(0.1, 1.5), number(0.1, 1.0), 0.8),
        heading: number(-3.2, 3.2),
    }));
    solids
}

#[test]
fn the_base_keeps_off_whatever_stands_and_within_its_limits() {
    const RADIUS_M: f64 = 0.3;
    let limits = BaseSpec { speed: 0.8, acceleration: 0.5, turn_speed: 1.0, turn_acceleration: 1.5 };
    let mut driven = 0;
    for seed in 0..120 {
        let mut rng = Rng::of(&[seed, 11]);
        let solids = room(&mut rng);
        let mut pose = || {
            let [x, y, turn] = [680, 680, 628].map(|count| rng.below(count) as f64 / 100.0);
            Pose::new(0.6 + x, 0.6 + y, turn)
        };
        let (from, to) = (pose(), pose());
        // What it touches as it begins is another matter.
        if solids.iter().any(|solid| off_m(solid, from.at) < RADIUS_M) {
            continue;
        }
        let Ok(path) = find_path(&FreeSpace::new(&solids, RADIUS_M), from, to).path else { continue };
        driven += 1;
        let mut base = Base::new(limits);
        let start = ControllerState::Base { pose: from, velocity: Vector3::zeros() };
        base.configure(&ControllerKind::Base(limits), start);
        base.start(&Command::Drive { path, place: None }, Mode::Achieve).expect("it is free");
        let mut before = Vector3::zeros();
        loop {
            let progress = base.step();
            let ControllerState::Base { pose, velocity } = base.state() else { panic!("a base") };
            let near_m = solids.iter().map(|solid| off_m(solid, pose.at)).fold(f64::MAX, f64::min);
            assert!(near_m >= RADIUS_M - 1e-6, "seed {seed}: {near_m} m at {pose:?}");
            let speed = velocity.xy().norm();
            assert!(speed <= limits.speed + 1e-9 && velocity.z.abs() <= limits.turn_speed + 1e-9, "seed {seed}");
            let change = (velocity - before) / STEP.as_secs_f64();
            assert!(change.xy().norm() <= limits.acceleration + 1e-6, "seed {seed}: {change}");
            before = velocity;
            match progress {
                Progress::Running(_) => {}
                Progress::Ended(_) => break,
                Progress::Idle => panic!("seed {seed}: it lost its goal"),
            }
        }
        let ControllerState::Base { pose, .. } = base.state() else { panic!("a base") };
        assert!(pose.distance_m(&to) < 1e-6, "seed {seed}: {pose:?}");
    }
    assert!(driven > 60, "only {driven} rooms have a way");
}
