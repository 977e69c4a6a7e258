//! The shipped world, its tasks, and all shipped missions as both.

use std::path::{Path, PathBuf};

use super::super::super::{Disk, Setting, load_mission, load_robot, load_task, load_use, load_world};
use super::{all, behavior, told};
use ambidex_model::Retention;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(name)
}

#[test]
fn the_shipped_tasks_are_for_the_shipped_world() {
    let base = load_world(&Disk, &shipped("robots/pr2.yaml"), &shipped("worlds/kitchen.yaml"), &[]).unwrap();
    assert_eq!(told(&base.warnings), [] as [&str; 0]);
    let base = base.mission;
    assert_eq!(load_robot(&Disk, &shipped("robots/pr2.yaml")).unwrap().robot, base.robot);
    for (task, nodes) in [("set-the-table", 22), ("fetch", 5), ("patrol", 3)] {
        let loaded = load_task(&Disk, &shipped(&format!("tasks/{task}.yaml")), &[], &base, &base.start).unwrap();
        assert_eq!((told(&loaded.warnings).join("\n").as_str(), loaded.fragment.nodes.len()), ("", nodes), "{task}");
    }
    let drive = load_use("fetch", &all(&["object=mug"]), &base, &base.start).unwrap();
    assert!(matches!(behavior(&drive, 1).claims[0].keep, Retention::Intention(_)));
}

#[test]
fn every_shipped_mission_can_be_submitted_where_its_world_is() {
    let mut count = 0;
    for entry in std::fs::read_dir(shipped("missions")).unwrap() {
        let path = entry.unwrap().path();
        let settings: Vec<Setting> = Vec::new();
        let mission = load_mission(&Disk, &path, None, &settings).unwrap();
        let base = load_world(&Disk, &mission.robot_path, &path, &settings).unwrap().mission;
        let loaded = load_task(&Disk, &path, &settings, &base, &base.start).unwrap();
        assert_eq!(loaded.fragment.names, mission.mission.names.nodes.to_vec()[1..], "{path:?}");
        let channels = [base.names.channels.clone(), loaded.fragment.channels.clone()].concat();
        assert_eq!(channels, mission.mission.names.channels, "{path:?}");
        let mut tree = loaded.fragment.into_tree();
        tree.bypass = mission.mission.tree.bypass;
        assert_eq!(tree, mission.mission.tree, "{path:?}");
        count += 1;
    }
    assert!(count > 10);
}
