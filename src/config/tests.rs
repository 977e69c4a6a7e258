//! The shipped files, a table of mistakes, and files that nobody would write.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use proptest::prelude::*;
use tempfile::TempDir;

use super::*;
use crate::model::{
    Access, ChannelId, Claim, Condition, ControllerKind, EffectTerm, Keep, Mode, NodeId, NodeKind,
    ObjectId, PlaceId, Pose, Potential, ResourceId, Task, TypeId, Wanted, Whereabouts,
};

const GOOD: &str = "\
mission: good
robot: robot.yaml
world:
  robot: {at: [0, 0], heading: 90 deg}
  places:
    shelf: {stand: [1 m, 200 cm]}
    table: {stand: [3, 2]}
  objects:
    cup: {at: shelf, offset: [0, 0.1]}
    pot: {at: shelf}
  facts: {door_open: true}
task:
  then:
    - move: shelf
    - pick: cup
    - move: {to: table, scale_by: gripper}
      timeout: 2 min
    - place: {object: cup}
      retries: 0
";
const ROBOT: &str = "\
robot: small
radius: 0.3 m
resources:
  hand: {type: gripper, controller: arm}
  base: {type: base}
controllers:
  arm:
    arm: {shoulder: [0, 0, 0.8], tuck: [0.3, 0, 0.9], reach: 0.9, speed: 0.5, acceleration: 1, grip: 1 s, lift: 10 cm}
";

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("config")
        .join(name)
}

fn load(mission: &str, robot: &str) -> Result<MissionSpec, ConfigError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("mission.yaml");
    fs::write(&path, mission).unwrap();
    fs::write(folder.path().join("robot.yaml"), robot).unwrap();
    load_mission(&path, None)
}

fn stop(place: u32, x: f64, y: f64) -> Condition {
    Condition::At {
        place: PlaceId(place),
        stand: Pose::new(x, y, 0.0),
        tolerance_m: 0.25,
    }
}

fn claim(resource: u32, access: Access, keep: Keep) -> Claim {
    Claim {
        wanted: Wanted::Named(ResourceId(resource)),
        access,
        keep,
    }
}

fn commands(spec: &MissionSpec, node: u32) -> Vec<(usize, Mode, Task)> {
    let behavior = spec.tree.behavior(NodeId(node)).unwrap();
    behavior
        .commands
        .iter()
        .map(|term| (term.claim, term.mode, term.task))
        .collect()
}

#[test]
fn every_shipped_mission_loads() {
    for number in 1..=4 {
        let path = shipped(&format!("missions/experiment-{number}.yaml"));
        let spec = load_mission(&path, None).unwrap();
        assert_eq!(spec.name, format!("experiment-{number}"));
        assert_eq!(spec.tree.leaves().count(), 16);
        let expected: Vec<String> = (1..=4)
            .flat_map(|object| {
                ["move I-1", "pick I", "move I-2", "place I"]
                    .map(|name| name.replace('I', &object.to_string()))
            })
            .collect();
        let names = spec.tree.leaves().map(|leaf| spec.names.node(leaf));
        assert_eq!(names.collect::<Vec<_>>(), expected);
        let offsets = &spec.world.object_offsets;
        assert!(
            offsets
                .windows(2)
                .all(|pair| (pair[0] - pair[1]).norm() > 0.13)
        );
    }
}

#[test]
fn the_shipped_robot_has_four_controllers_and_reaches() {
    let file = load_robot(&shipped("robots/pr2.yaml")).unwrap();
    assert_eq!(
        file.names.resources,
        ["left_gripper", "right_gripper", "head", "base"]
    );
    assert_eq!(
        file.names.controllers,
        ["left_arm", "right_arm", "head", "base"]
    );
    assert_eq!(file.names.types, ["gripper", "head", "base"]);
    for controller in &file.robot.controllers {
        let ControllerKind::Arm(arm) = controller.kind else {
            continue;
        };
        for (x, y) in [
            (0.25, 0.0),
            (-0.25, 0.0),
            (0.0, 0.25),
            (0.0, -0.25),
            (0.2, 0.15),
            (0.2, -0.15),
        ] {
            for aside in [-0.2, 0.2] {
                let at = nalgebra::Point3::new(0.5 + x, aside + y, 0.75);
                let far = (at - arm.shoulder).norm();
                assert!(far <= arm.reach_m, "{} to {at}: {far}", controller.name);
            }
        }
    }
}

#[test]
fn experiment_1_is_as_the_paper_tells() {
    let spec = load_mission(&shipped("missions/experiment-1.yaml"), None).unwrap();
    assert_eq!(spec.start.base, Pose::new(7.0, 3.5, 0.0));
    assert_eq!(spec.names.places[1], "counter");
    assert_eq!(spec.names.channels[1], "at counter");
    let starts = [0, 0, 2, 4].map(|place| Whereabouts::At(PlaceId(place)));
    assert_eq!(spec.start.objects, starts);
    assert_eq!(
        spec.names.nodes[..4],
        ["root", "and", "object 1", "move 1-1"]
    );
    assert_eq!(
        spec.tree.nodes[..3],
        [NodeKind::Root, NodeKind::And, NodeKind::Then]
    );
    assert_eq!(spec.tree.topology.parent(NodeId(3)), NodeId(2));

    let at_shelf = Access::Shared(ChannelId(0));
    let drive = spec.tree.behavior(NodeId(3)).unwrap();
    let kept = Keep::Intention(at_shelf);
    assert_eq!(drive.claims, [claim(3, Access::Exclusive, kept)]);
    let stand = Pose::new(3.5 - 0.043, 1.5 - 0.025, 0.0);
    assert_eq!(
        drive.potential,
        Potential::Nearness {
            to: stand,
            floor_m: 0.25,
            scale_by: Some(TypeId(0))
        }
    );
    assert_eq!(drive.satisfied, stop(0, stand.at.x, stand.at.y));
    assert_eq!(
        drive.precondition,
        Condition::Path {
            place: PlaceId(0),
            stand
        }
    );
    assert_eq!(drive.effects, []);
    assert_eq!(
        commands(&spec, 3),
        [(0, Mode::Achieve, Task::DriveTo(stand))]
    );
    assert_eq!(
        (drive.timeout, drive.retries),
        (Duration::from_secs(600), 2)
    );

    let pick = spec.tree.behavior(NodeId(4)).unwrap();
    let hand = Claim {
        wanted: Wanted::AnyEmpty {
            of: TypeId(0),
            reaches: Some(ObjectId(0)),
        },
        access: Access::Exclusive,
        keep: Keep::Physical(Access::Exclusive),
    };
    let shared = |resource| claim(resource, at_shelf, Keep::Release);
    assert_eq!(pick.claims, [shared(3), shared(2), hand]);
    assert!(pick.claims.iter().all(Claim::is_sound));
    assert_eq!(pick.potential, Potential::Constant(9.0));
    assert_eq!(pick.satisfied, Condition::Held(ObjectId(0)));
    let ready = Condition::All(vec![
        stop(0, stand.at.x, stand.at.y),
        Condition::Free(ObjectId(0)),
    ]);
    assert_eq!(pick.precondition, ready);
    assert_eq!(pick.effects, [EffectTerm::Taken(ObjectId(0), 2)]);
    assert_eq!(pick.changes, [ObjectId(0)]);
    let expected = [
        (2, Mode::Achieve, Task::Grasp(ObjectId(0))),
        (1, Mode::Maintain, Task::LookAt(PlaceId(0))),
        (0, Mode::Maintain, Task::Stand),
    ];
    assert_eq!(commands(&spec, 4), expected);

    let place = spec.tree.behavior(NodeId(6)).unwrap();
    assert_eq!(place.claims[2].wanted, Wanted::Holding(ObjectId(0)));
    assert_eq!(place.claims[0].access, Access::Shared(ChannelId(1)));
    assert_eq!(place.satisfied, Condition::Lies(ObjectId(0), PlaceId(1)));
    assert_eq!(place.effects, [EffectTerm::Lies(ObjectId(0), PlaceId(1))]);
    let ready = Condition::All(vec![stop(1, 6.5, 1.5), Condition::Held(ObjectId(0))]);
    assert_eq!(place.precondition, ready);
    assert_eq!(
        commands(&spec, 6)[0],
        (2, Mode::Achieve, Task::Put(ObjectId(0), PlaceId(1)))
    );
}

#[test]
fn a_robot_without_head_and_base_controller_is_bound_so() {
    let spec = load(GOOD, ROBOT).unwrap();
    let names = [
        "root",
        "then",
        "move to shelf",
        "pick cup",
        "move to table",
        "place cup",
    ];
    assert_eq!(spec.names.nodes, names);
    let drive = spec.tree.behavior(NodeId(2)).unwrap();
    assert_eq!(
        drive.effects,
        [EffectTerm::Stands(Pose::new(1.0, 2.0, 0.0))]
    );
    assert_eq!(commands(&spec, 2), []);
    let pick = spec.tree.behavior(NodeId(3)).unwrap();
    assert_eq!(pick.claims.len(), 2);
    assert_eq!(
        commands(&spec, 3),
        [(1, Mode::Achieve, Task::Grasp(ObjectId(0)))]
    );
    let second = spec.tree.behavior(NodeId(4)).unwrap();
    assert_eq!(second.timeout, Duration::from_secs(120));
    assert_eq!(spec.tree.behavior(NodeId(5)).unwrap().retries, 0);
    assert_eq!(spec.start.facts, [true]);
    assert!((spec.start.base.heading - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn moves_before_and_claims_after_follow_the_then() {
    let task = "\
task:
  and:
    - then:
        - move: shelf
        - and: [{pick: cup}, {pick: pot}]
        - move: table
          name: last
    - pick: cup
    - place: {object: pot, at: table}
    - or: [{move: shelf}, {move: shelf}]
";
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    let spec = load(&format!("{head}{task}"), ROBOT).unwrap();
    let expected = [
        "root",
        "and 1",
        "then",
        "move to shelf",
        "and 2",
        "pick cup",
        "pick pot",
        "last",
        "pick cup #2",
        "place pot",
        "or",
        "move to shelf #2",
        "move to shelf #3",
    ];
    assert_eq!(spec.names.nodes, expected);
    let scale = |node| match spec.tree.behavior(NodeId(node)).unwrap().potential {
        Potential::Nearness { scale_by, .. } => scale_by,
        Potential::Constant(_) => panic!("not a move"),
    };
    assert_eq!([3, 7, 11].map(scale), [Some(TypeId(0)), None, None]);
    let nested = spec.tree.behavior(NodeId(6)).unwrap();
    assert_eq!(nested.claims[0].access, Access::Shared(ChannelId(0)));
}

/// What a mistake is: in the mission (or in the robot file), what is replaced by what, and the line and words expected.
type Mistake<'a> = (&'a str, &'a str, usize, &'a str);

fn assert_found(error: &ConfigError, (found, by, line, words): &Mistake<'_>) {
    let rendered: Vec<String> = error
        .faults()
        .iter()
        .map(|fault| {
            let help =
                miette::Diagnostic::help(fault).map_or_else(String::new, |help| help.to_string());
            format!("{}:{fault} {help}", fault.position().map_or(0, |at| at.0))
        })
        .collect();
    let expected = format!("{line}:");
    assert!(
        rendered
            .iter()
            .any(|fault| fault.starts_with(&expected) && fault.contains(words)),
        "`{found}` -> `{by}`: expected line {line} and `{words}` in {rendered:#?}"
    );
}

#[test]
fn mistakes_in_a_mission_are_found() {
    let table: &[Mistake<'_>] = &[
        (
            "mission: good\n",
            "",
            1,
            "a mission lacks the key `mission`",
        ),
        (
            "mission: good",
            "mision: good",
            1,
            "no key `mision` did you mean `mission`?",
        ),
        (
            "mission: good",
            "mission: [good]",
            1,
            "found a list instead of the name",
        ),
        ("mission: good", "mission: ''", 1, "a name cannot be empty"),
        ("mission: good", "mission:", 1, "found nothing"),
        ("robot: robot.yaml", "robot: rowboat.yaml", 0, "cannot read"),
        (
            "at: [0, 0]",
            "at: [0, 0, 1]",
            4,
            "found 3 numbers instead of two numbers",
        ),
        (
            "at: [0, 0]",
            "at: [0, zero]",
            4,
            "found `zero` instead of a length",
        ),
        ("at: [0, 0]", "at: [.inf, 0]", 4, "out of bounds"),
        (
            "at: [0, 0]",
            "at: [1e99 m, 0]",
            4,
            "allowed: -10000.00000 to 10000.00000 m",
        ),
        ("90 deg", "90 degrees", 4, "units: rad, deg"),
        ("90 deg", "1 m", 4, "found `1 m` instead of an angle"),
        (
            "1 m, 200 cm",
            "1 m, deg(90)",
            6,
            "found `deg(90)` instead of a length",
        ),
        (
            "{stand: [3, 2]}",
            "{stand: 3}",
            7,
            "found `3` instead of two numbers",
        ),
        ("{stand: [3, 2]}", "{}", 7, "a place lacks the key `stand`"),
        ("    table: {", "    shelf: {", 7, "duplicate"),
        (
            "cup: {at: shelf,",
            "cup: {at: shelve,",
            9,
            "there is no place `shelve` did you mean `shelf`?",
        ),
        (
            "cup: {at: shelf,",
            "cup: {at: moon,",
            9,
            "allowed: `shelf`, `table`",
        ),
        (
            "door_open: true",
            "door_open: 7",
            11,
            "instead of `true` or `false`",
        ),
        (
            "    - move: shelf",
            "    - moev: shelf",
            14,
            "no key `moev` did you mean `move`?",
        ),
        (
            "    - move: shelf",
            "    - move: shelf\n      pick: cup",
            14,
            "2 kinds instead of one",
        ),
        (
            "    - move: shelf",
            "    - move:",
            14,
            "found nothing instead of a move",
        ),
        ("    - move: shelf", "    - or: []", 14, "an empty list"),
        (
            "    - move: shelf",
            "    - {or: [{move: shelf}], retries: 1}",
            14,
            "belongs to move, pick and place",
        ),
        (
            "    - move: shelf",
            "    - {move: shelf, name: root}",
            14,
            "another node is called `root`",
        ),
        (
            "    - pick: cup",
            "    - pick: cub",
            15,
            "did you mean `cup`?",
        ),
        (
            "    - pick: cup",
            "    - pick: {objekt: cup}",
            15,
            "did you mean `object`?",
        ),
        (
            "scale_by: gripper",
            "scale_by: griper",
            16,
            "did you mean `gripper`?",
        ),
        ("timeout: 2 min", "timeout: -1 s", 17, "out of bounds"),
        ("retries: 0", "retries: 0.5", 19, "a whole number"),
        (
            "    - move: {to: table, scale_by: gripper}\n      timeout: 2 min",
            "    - place: {object: pot, at: tabel}",
            16,
            "did you mean `table`?",
        ),
        ("  then:", "  and:", 18, "not told where to"),
        (
            "facts: {door_open: true}",
            "obstacles: [{min: [0, 0], max: [1, 0]}]",
            11,
            "`max` is not beyond `min`",
        ),
        (
            "facts: {door_open: true}",
            "tolerance: 1 mm",
            11,
            "allowed: 0.02000 to",
        ),
        (
            "facts: {door_open: true}",
            "facts: {door_open: true",
            12,
            "",
        ),
    ];
    for mistake in table {
        assert!(GOOD.contains(mistake.0), "{}", mistake.0);
        let error = load(&GOOD.replacen(mistake.0, mistake.1, 1), ROBOT).unwrap_err();
        assert_found(&error, mistake);
    }
}

#[test]
fn mistakes_in_a_robot_are_found() {
    let table: &[Mistake<'_>] = &[
        ("radius: 0.3 m", "radius: 0 m", 2, "out of bounds"),
        (
            "controller: arm",
            "controller: amr",
            4,
            "there is no controller `amr` did you mean `arm`?",
        ),
        (
            ", controller: arm",
            "",
            7,
            "no resource has this controller",
        ),
        ("type: gripper", "type: head", 4, "moves an arm, not a head"),
        (
            "{type: base}",
            "{type: base, controller: arm}",
            5,
            "moves `hand` already",
        ),
        (
            "{type: base}",
            "{type: gripper}",
            5,
            "some have a controller and some have none",
        ),
        (
            "{type: base}",
            "{type: wheels}",
            14,
            "the robot has no resource of type `base`",
        ),
        ("  arm:\n", "  a/b:\n", 7, "at most 32 letters"),
        ("    arm: {", "    leg: {", 8, "no key `leg`"),
        ("lift: 10 cm", "lift: 10 s", 8, "instead of a length"),
        (
            "tuck: [0.3, 0, 0.9]",
            "tuck: [3, 0, 0.9]",
            8,
            "farther from the shoulder",
        ),
        (", grip: 1 s", "", 8, "an arm lacks the key `grip`"),
    ];
    for mistake in table {
        assert!(ROBOT.contains(mistake.0), "{}", mistake.0);
        let error = load(GOOD, &ROBOT.replacen(mistake.0, mistake.1, 1)).unwrap_err();
        assert_found(&error, mistake);
    }
}

#[test]
fn all_mistakes_come_at_once_with_their_files() {
    let mission = GOOD
        .replace("90 deg", "90 dog")
        .replace("at: shelf}", "at: shell}")
        .replace("pick: cup", "pick: cub");
    let error = load(&mission, &ROBOT.replace("0.3 m", "big")).unwrap_err();
    let lines: Vec<_> = error
        .faults()
        .iter()
        .map(|fault| fault.position().unwrap().0)
        .collect();
    assert_eq!(lines, [4, 10, 15, 2]);
    assert!(error.faults()[3].file().ends_with("robot.yaml"));
    assert_eq!(error.faults()[2].key(), "pick");
    assert_eq!(error.to_string(), "4 mistakes in the files");
    let report = format!("{:?}", miette::Report::new(error));
    assert!(report.contains("did you mean `shelf`?"), "{report}");
}

#[test]
fn what_is_too_much_is_refused() {
    let head = &GOOD[..GOOD.find("task:").unwrap()];
    let deep = |levels| {
        let open = "{and: [".repeat(levels);
        let close = "]}".repeat(levels);
        format!("{head}task: {open}{{move: shelf}}{close}\n")
    };
    assert!(load(&deep(60), ROBOT).is_ok());
    for (mission, words) in [
        (deep(64), "nested more than 64 levels"),
        (deep(5000), ""),
        (format!("{GOOD}#{}", " ".repeat(1 << 20)), "larger than"),
        (
            format!("{head}task: {{and: [{}]}}", "{},".repeat(90_000)),
            "0 kinds instead of one",
        ),
        (
            format!("{head}task: {{and: [{}]}}", "1,".repeat(300_000)),
            "",
        ),
    ] {
        let error = load(&mission, ROBOT).unwrap_err();
        let found = error.faults()[0].message();
        assert!(found.contains(words), "{found}");
        assert!(error.faults().len() <= 100);
    }
}

#[test]
fn aliases_stay_within_bounds() {
    let mut bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n".to_owned();
    for level in 1..12 {
        let items = format!("*a{}, ", level - 1).repeat(9);
        bomb += &format!("a{level}: &a{level} [{items}]\n");
    }
    assert!(load(&bomb, ROBOT).is_err());
    let anchored = GOOD
        .replace("pick: cup", "&it pick: cup")
        .replace("    - place:", "    - *nothing\n    - place:");
    assert!(load(&anchored, ROBOT).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_text_makes_it_panic(
        cuts in prop::collection::vec((0..1000usize, 0..6usize, "[-a-z0-9 :\\[\\]{},&*!|>'\"#~%@.\n]{0,4}"), 1..6),
        is_robot in any::<bool>(),
    ) {
        let mut text = if is_robot { ROBOT } else { GOOD }.to_owned();
        for (at, length, by) in cuts {
            let from = at.min(text.len());
            let to = (from + length).min(text.len());
            text.replace_range(from..to, &by);
        }
        let loaded = if is_robot { load(GOOD, &text) } else { load(&text, ROBOT) };
        if let Err(error) = loaded {
            prop_assert!(!error.faults().is_empty());
            for fault in error.faults() {
                prop_assert!(fault.position().is_none_or(|at| at.0 <= text.lines().count() + GOOD.len()));
            }
            let report = format!("{:?}", miette::Report::new(error));
            prop_assert!(!report.is_empty());
        }
    }

    #[test]
    fn no_bytes_make_it_panic(text in "\\PC{0,200}") {
        prop_assert!(load(&text, ROBOT).is_err());
    }
}
