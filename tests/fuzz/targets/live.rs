//! Worlds, and tasks that are submitted to a robot in one.

use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use ambidex::files::{LoadedTask, TaskLoader, load_source, load_world};
use ambidex::model::MissionSpec;

use super::Taken;
use super::files::{told, with};

const ROBOT: &str = "robots/pr2.yaml";
const WORLD: &str = "worlds/input.yaml";
const TASK: &str = "tasks/input.yaml";

/// Nodes of tasks that are compared with what they are when they are read again.
const COMPARED: usize = 1000;

/// What a task is submitted to, and what was read of it once.
struct Room {
    base: Arc<MissionSpec>,
    loader: Mutex<TaskLoader>,
}

static ROOM: LazyLock<Room> = LazyLock::new(|| {
    let kitchen = include_bytes!("../../../config/worlds/kitchen.yaml");
    let base = world_of(kitchen).expect("the shipped world loads");
    let loader = Mutex::new(TaskLoader::new(&base).expect("it was loaded"));
    Room { base, loader }
});

fn world_of(text: &[u8]) -> Option<Arc<MissionSpec>> {
    load_world(&with(WORLD, text), ROBOT.as_ref(), WORLD.as_ref(), &[]).ok().map(|loaded| loaded.mission)
}

/// A world file, with all that is shipped beside it.
pub fn world(text: &[u8]) -> Taken {
    let loaded = load_world(&with(WORLD, text), ROBOT.as_ref(), WORLD.as_ref(), &[]);
    let mut taken = told(loaded.as_ref().map(|loaded| loaded.warnings.as_slice()));
    if let Ok(loaded) = loaded {
        let source = loaded.mission.source.as_ref().expect("what was loaded has a source");
        assert!(load_source(source).is_ok(), "it does not load again from what a log keeps of it");
        let mut loader = TaskLoader::new(&loaded.mission).expect("a world that was loaded takes tasks");
        let task = include_bytes!("../../../config/tasks/fetch.yaml");
        let now = &loaded.mission.start;
        let task = loader.load_task(&with(TASK, task), TASK.as_ref(), &[], &loaded.mission, now);
        let said = told(task.as_ref().map(|task| task.warnings.as_slice()));
        taken.kinds.extend(said.kinds);
    }
    taken
}

/// A task file for a robot that works.
pub fn task(text: &[u8]) -> Taken {
    let Room { base, loader } = &*ROOM;
    let mut loader = loader.lock().unwrap_or_else(PoisonError::into_inner);
    let (files, path) = (with(TASK, text), Path::new(TASK));
    let loaded = loader.load_task(&files, path, &[], base, &base.start);
    let taken = told(loaded.as_ref().map(|loaded| loaded.warnings.as_slice()));
    let loaded = loaded.ok().map(|LoadedTask { fragment, source, .. }| {
        let count = fragment.nodes.len();
        assert_eq!([fragment.names.len(), fragment.parents.len()], [count; 2]);
        // Of the largest one at a time is enough.
        (source, (count < COMPARED).then_some(fragment))
    });
    let branch = loader.load_branch(&files, path, &[], base, &base.start);
    assert_eq!(loaded.is_some(), branch.is_ok(), "as a part it is read as it is alone");
    drop(branch);
    if let Some((source, fragment)) = loaded {
        let again = loader.load_source(&source, base, &base.start).expect("it loads again from what a log keeps of it");
        let count = again.fragment.nodes.len();
        assert!(fragment.is_none_or(|fragment| fragment == again.fragment), "it comes to the same again");
        assert_eq!(again.fragment.into_tree().topology.nodes().count(), count + 1);
    }
    taken
}
