//! The shipped files, and what becomes of the kinds of behavior in them.

use std::sync::Arc;

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::super::{Disk, load_mission, load_robot};
use super::{GOOD, ROBOT, load, robot};
use ambidex_model::{
    Access, ChannelId, Claim, Condition, ControllerKind, EffectTerm, Location, MissionSpec, Mode, NodeId, NodeKind,
    ObjectId, PlaceId, Pose, Potential, ResourceId, Retention, Selector, Task, TypeId,
};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(name)
}

fn experiment_1() -> Arc<MissionSpec> {
    load_mission(&Disk, &shipped("missions/experiment-1.yaml"), None, &[]).unwrap().mission
}

fn stop(place: u32, x: f64, y: f64) -> Condition {
    Condition::At { place: PlaceId(place), stands: vec![Pose::new(x, y, 0.0)], tolerance_m: 0.25 }
}

fn claim(resource: u32, access: Access, keep: Retention) -> Claim {
    Claim { selector: Selector::Named(ResourceId(resource)), access, keep }
}

fn commands(spec: &MissionSpec, node: u32) -> Vec<(usize, Mode, Task)> {
    let behavior = spec.tree.behavior(NodeId(node)).unwrap();
    behavior.commands.iter().map(|term| (term.claim, term.mode, term.task.clone())).collect()
}

#[test]
fn every_shipped_mission_loads() {
    for number in 1..=4 {
        let path = shipped(&format!("missions/experiment-{number}.yaml"));
        let spec = load_mission(&Disk, &path, None, &[]).unwrap().mission;
        assert_eq!(spec.name, format!("experiment-{number}"));
        assert_eq!(spec.tree.leaves().count(), 16);
        let expected: Vec<String> = (1..=4)
            .flat_map(|object| {
                ["move I-1", "pick I", "move I-2", "place I"].map(|name| name.replace('I', &object.to_string()))
            })
            .collect();
        let names = spec.tree.leaves().map(|leaf| spec.names.node(leaf));
        assert_eq!(names.collect::<Vec<_>>(), expected);
        let objects = &spec.world.objects;
        assert!(objects.windows(2).all(|pair| (pair[0].offset - pair[1].offset).norm() > 0.13));
    }
}

#[test]
fn the_shipped_robot_has_four_controllers_and_reaches() {
    let file = load_robot(&Disk, &shipped("robots/pr2.yaml")).unwrap();
    assert_eq!(file.names.resources, ["left_gripper", "right_gripper", "head", "base"]);
    assert_eq!(file.names.controllers, ["left_arm", "right_arm", "head", "base"]);
    assert_eq!(file.names.types, ["gripper", "head", "base"]);
    for controller in &file.robot.controllers {
        let ControllerKind::Arm(arm) = controller.kind else {
            continue;
        };
        for (x, y) in [(0.25, 0.0), (-0.25, 0.0), (0.0, 0.25), (0.0, -0.25), (0.2, 0.15), (0.2, -0.15)] {
            for aside in [-0.2, 0.2] {
                let at = nalgebra::Point3::new(0.5 + x, aside + y, 0.75);
                let far = (at - arm.shoulder).norm();
                assert!(far <= arm.reach_m, "{} to {at}: {far}", controller.name);
            }
        }
    }
}

#[test]
fn experiment_1_has_its_world_and_tree() {
    let spec = experiment_1();
    assert_eq!(spec.start.base, Pose::new(7.0, 3.5, 0.0));
    assert_eq!(spec.names.places[1], "counter");
    assert_eq!(spec.names.channels[1], "at counter");
    let starts = [0, 0, 2, 4].map(|place| Location::At(PlaceId(place)));
    assert_eq!(spec.start.objects, starts);
    assert_eq!(spec.names.nodes.to_vec()[..4], ["root", "and", "object 1", "move 1-1"]);
    assert_eq!(spec.tree.nodes.to_vec()[..3], [NodeKind::Root, NodeKind::And, NodeKind::Then]);
    assert_eq!(spec.tree.topology.parent(NodeId(3)), NodeId(2));
}

#[test]
fn a_move_is_as_the_paper_tells() {
    let spec = experiment_1();
    let at_shelf = Access::Shared(ChannelId(0));
    let drive = spec.tree.behavior(NodeId(3)).unwrap();
    let kept = Retention::Intention(at_shelf);
    assert_eq!(drive.claims, [claim(3, Access::Exclusive, kept)]);
    let stand = Pose::new(3.5 - 0.043, 1.5 - 0.025, 0.0);
    assert_eq!(drive.potential, Potential::Nearness { to: stand, floor_m: 0.25, scale_by: Some(TypeId(0)) });
    assert_eq!(drive.satisfied, stop(0, stand.at.x, stand.at.y));
    assert_eq!(drive.precondition, Condition::Path { place: PlaceId(0), stands: vec![stand] });
    assert_eq!(drive.effects, []);
    assert_eq!(commands(&spec, 3), [(0, Mode::Achieve, Task::DriveTo(PlaceId(0), stand))]);
    assert_eq!((drive.timeout, drive.retries), (Duration::from_secs(600), 2));
}

#[test]
fn a_pick_is_as_the_paper_tells() {
    let spec = experiment_1();
    let at_shelf = Access::Shared(ChannelId(0));
    let stand = Pose::new(3.5 - 0.043, 1.5 - 0.025, 0.0);
    let pick = spec.tree.behavior(NodeId(4)).unwrap();
    let hand = Claim {
        selector: Selector::AnyEmpty { of: TypeId(0), reaches: Some(ObjectId(0)) },
        access: Access::Exclusive,
        keep: Retention::Physical(Access::Exclusive),
    };
    let shared = |resource| claim(resource, at_shelf, Retention::Release);
    assert_eq!(pick.claims, [shared(3), shared(2), hand]);
    assert!(pick.claims.iter().all(Claim::is_sound));
    assert_eq!(pick.potential, Potential::Constant(9.0));
    assert_eq!(pick.satisfied, Condition::Held(ObjectId(0).into()));
    let ready = Condition::All(vec![
        stop(0, stand.at.x, stand.at.y),
        Condition::Free(ObjectId(0)),
        Condition::Lies(ObjectId(0), PlaceId(0)),
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
}

#[test]
fn a_place_is_as_the_paper_tells() {
    let spec = experiment_1();
    let place = spec.tree.behavior(NodeId(6)).unwrap();
    assert_eq!(place.claims[2].selector, Selector::Holding { object: ObjectId(0), of: TypeId(0), resource: None });
    assert_eq!(place.claims[0].access, Access::Shared(ChannelId(1)));
    assert_eq!(place.satisfied, Condition::Lies(ObjectId(0), PlaceId(1)));
    assert_eq!(place.effects, [EffectTerm::Lies(ObjectId(0), PlaceId(1))]);
    let ready = Condition::All(vec![stop(1, 6.5, 1.5), Condition::Held(ObjectId(0).into())]);
    assert_eq!(place.precondition, ready);
    assert_eq!(commands(&spec, 6)[0], (2, Mode::Achieve, Task::Put(ObjectId(0), PlaceId(1))));
}

#[test]
fn a_robot_without_head_and_base_controller_is_bound_so() {
    let spec = load(GOOD, ROBOT).unwrap();
    let names = ["root", "then", "move to shelf", "pick cup", "move to table", "place cup"];
    assert_eq!(spec.names.nodes.to_vec(), names);
    let drive = spec.tree.behavior(NodeId(2)).unwrap();
    assert_eq!(drive.effects, [EffectTerm::Stands(Pose::new(1.0, 2.0, 0.0))]);
    assert_eq!(commands(&spec, 2), []);
    let pick = spec.tree.behavior(NodeId(3)).unwrap();
    assert_eq!(pick.claims.len(), 2);
    assert_eq!(commands(&spec, 3), [(1, Mode::Achieve, Task::Grasp(ObjectId(0)))]);
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
    let spec = load(&format!("{head}{task}"), &robot(2)).unwrap();
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
    assert_eq!(spec.names.nodes.to_vec(), expected);
    let scale = |node| match spec.tree.behavior(NodeId(node)).unwrap().potential {
        Potential::Nearness { scale_by, .. } => scale_by,
        Potential::Constant(_) | Potential::Scaled { .. } => panic!("not a move"),
    };
    assert_eq!([3, 7, 11].map(scale), [Some(TypeId(0)), None, None]);
    let nested = spec.tree.behavior(NodeId(6)).unwrap();
    assert_eq!(nested.claims[0].access, Access::Shared(ChannelId(0)));
}
