//! Worlds in which tasks come and go: how they are loaded, and what becomes different in them.

use super::super::super::{LoadedTask, TaskLoader, load_source, load_use, load_world};
use super::super::{GOOD, PATH, ROBOT, written};
use super::{TASK, WORLD, all, behavior, files, told, with, world};
use ambidex_model::{ChannelId, Location, Misnamed, MissionSpec, NodeKind, ObjectId, ObjectSpec, PlaceId, SourceKind};

#[test]
fn a_world_has_a_node_for_tasks_and_loads_again() {
    let base = world();
    assert_eq!((base.name.as_str(), base.names.nodes.to_vec()), ("world", vec!["root".to_owned(), "tasks".to_owned()]));
    assert_eq!(base.tree.nodes.to_vec(), [NodeKind::Root, NodeKind::Tasks]);
    assert_eq!(base.names.channels, ["at shelf", "at table"]);
    let source = base.source.as_ref().unwrap();
    assert_eq!((source.kind, source.robot.as_deref()), (SourceKind::World, Some("robot.yaml")));
    assert_eq!(*load_source(source).unwrap().mission, *base);
}

#[test]
fn defaults_of_a_world_that_name_nothing_are_told() {
    let said = |default: &str| {
        let mut files = files();
        files.insert("world.yaml", WORLD.replace("default: table", &format!("default: {default}")));
        told(&load_world(&files, "robot.yaml".as_ref(), "world.yaml".as_ref(), &[]).unwrap().warnings)
    };
    let expected =
        "world.yaml:6: default: there is no place `tabel`; did you mean `table`? Allowed: `shelf`, `table`".to_owned();
    assert_eq!(said("tabel"), [expected]);
    assert_eq!((said("table"), said("cup")), (vec![], vec![]));
}

#[test]
fn any_mission_is_a_world_whose_task_is_not_done() {
    let text = GOOD.replace("move: shelf", "move: nowhere");
    let read = |settings: &[&str]| {
        load_world(&written(text.as_str(), ROBOT), "robot.yaml".as_ref(), PATH.as_ref(), &all(settings))
    };
    assert_eq!(read(&[]).unwrap().mission.names.nodes.to_vec(), ["root", "tasks"]);
    let text = text.replace("world:", "parameters: {to: place}\nworld:");
    let read = |setting: &str| {
        load_world(&written(text.as_str(), ROBOT), "robot.yaml".as_ref(), PATH.as_ref(), &all(&[setting]))
    };
    assert_eq!(
        told(&read("to=table").unwrap().warnings),
        ["--set to=table:0: --set to=table: the task of a world is not done; tell it to the tasks that are submitted"]
    );
    let error = read("too=table").unwrap_err();
    assert!(told(error.faults())[0].contains("the world has no parameter `too`; did you mean `to`?"), "{error:?}");
    let other = load_world(&files(), "robot.yaml".as_ref(), "library.yaml".as_ref(), &[]).unwrap_err();
    assert_eq!(other.faults()[0].message(), "this is a library, not a world file");
    let task = load_world(&with("task: tidy"), "robot.yaml".as_ref(), TASK.as_ref(), &[]).unwrap_err();
    assert_eq!(task.faults()[0].message(), "this is a task file, not a world file");
}

#[test]
fn objects_come_and_go_under_their_names() {
    let base = world();
    let offset = nalgebra::Vector3::new(0.0, 0.1, 0.0);
    let mut loader = TaskLoader::new(&base).unwrap();
    let mut load = |base: &MissionSpec| {
        let files = with("task: {use: {fetch: mug}}");
        loader.load_task(&files, TASK.as_ref(), &[], base, &base.start).map(|loaded| loaded.fragment)
    };
    assert!(told(load(&base).unwrap_err().faults())[0].contains("there is no object `mug`; allowed: `cup`, `pot`"));
    let with = |mission: &MissionSpec, name: &str, at| {
        let mut more = mission.clone();
        more.add_object(name, ObjectSpec::at(offset), at).map(|_| more)
    };
    let more = with(&base, "mug", Location::At(PlaceId(1))).unwrap();
    let fetched = load(&more).unwrap();
    let NodeKind::Behavior(pick) = &fetched.nodes[2] else { panic!("a behavior") };
    assert_eq!(pick.changes, [ObjectId(2)]);
    let again = |name: &str| with(&more, name, Location::Unknown).unwrap_err();
    assert_eq!(again("mug"), Misnamed::Taken);
    assert_eq!(again("$mug"), Misnamed::Argument("mug".into()));
    assert_eq!(again(""), Misnamed::Empty);
    let mut gone = more.clone();
    gone.remove_object(ObjectId(2));
    assert_eq!((gone.names.object(ObjectId(2)), gone.world.objects.len()), ("?", 3));
    let said = told(load(&gone).unwrap_err().faults());
    assert!(said[0].contains("there is no object `mug`; allowed: `cup`, `pot`"), "{said:?}");
    let back = with(&gone, "mug", Location::At(PlaceId(0))).unwrap();
    let NodeKind::Behavior(pick) = &load(&back).unwrap().nodes[2] else { panic!("a behavior") };
    assert_eq!(pick.changes, [ObjectId(3)]);
}

#[test]
fn channels_of_other_tasks_keep_their_ids() {
    let mut base = world().as_ref().clone();
    let mut loader = TaskLoader::new(&base).unwrap();
    let channel = |loaded: &LoadedTask| behavior(loaded, 0).claims[0].access.channel();
    let files = with("task: {wipe: shelf}");
    let start = base.start.clone();
    let mut load = |base: &MissionSpec| loader.load_task(&files, TASK.as_ref(), &[], base, &start).unwrap();
    let first = load(&base);
    assert_eq!((channel(&first), first.fragment.channels.as_slice()), (Some(ChannelId(2)), &["wiping".to_owned()][..]));
    // Not taken: the next one is told the same.
    assert_eq!(load(&base).fragment, first.fragment);
    base.names.channels.extend(["scanning".to_owned()]);
    assert_eq!(channel(&load(&base)), Some(ChannelId(3)));
    base.names.channels.extend(["wiping".to_owned()]);
    let known = load(&base);
    assert_eq!((channel(&known), known.fragment.channels.len()), (Some(ChannelId(3)), 0));
}

#[test]
fn a_world_that_was_not_made_of_files_is_told() {
    let base = MissionSpec { source: None, ..world().as_ref().clone() };
    let error = load_use("fetch", &[], &base, &base.start).unwrap_err();
    assert_eq!(error.faults()[0].message(), "the world was not made of files, so that nobody knows what tasks can use");
}
