//! Files to checked specs: every fault with file, line and key, all at once. No tree is built here and nothing runs.

mod document;
mod fault;
mod files;
mod import;
mod kinds;
mod names;
mod outlook;
mod parameter;
mod quantity;
mod raw;
mod reader;
mod robot;
mod schema;
mod shape;
mod source;
mod task;
mod template;
#[cfg(test)]
mod tests;

mod world;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use fault::{ConfigError, Fault};
pub use import::{Beside, ImportError, Imported, import};
pub use robot::RobotFile;
pub use schema::{Format, schema};

use ambidex_model::{MissionSpec, Names};
use fault::Faults;
use files::{Files, LIBRARY, MISSION, beside};
use kinds::Kinds;
use names::Register;
use parameter::{Known, RobotNames};
use reader::{Fields, Item, Name};
use task::{Subtrees, Surroundings};
use world::WorldNames;

/// A mission with the file of its robot.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The mission.
    pub mission: Arc<MissionSpec>,
    /// Where its robot stands, for the controllers to read it too.
    pub robot_path: PathBuf,
    /// What is legal in the files but surely not meant.
    pub warnings: Vec<Fault>,
}

/// What a file turned out to be.
#[derive(Debug, Clone)]
pub enum Checked {
    /// A mission that can be run.
    Mission(Box<Loaded>),
    /// A robot, and what is surely not meant in its file.
    Robot(Box<RobotFile>, Vec<Fault>),
    /// Behaviors and subtrees for missions, by name, and what is surely not meant in their file.
    Library(Vec<String>, Vec<Fault>),
}

/// Loads a mission and the robot that it names, or `robot_override` instead.
///
/// # Errors
/// Every mistake in all its files.
pub fn load_mission(path: &Path, robot_override: Option<&Path>) -> Result<Loaded, ConfigError> {
    let mut faults = Faults::default();
    let files = Files::with_includes(path, &mut faults);
    let loaded = files.main().and_then(|main| mission(path, &files, main, robot_override, &mut faults));
    let ((mission, robot_path), warnings) = faults.into_result(loaded)?;
    Ok(Loaded { mission: Arc::new(mission), robot_path, warnings })
}

/// Loads a robot alone, as a controller process does.
///
/// # Errors
/// Every mistake in the file.
pub fn load_robot(path: &Path) -> Result<RobotFile, ConfigError> {
    let mut faults = Faults::default();
    let robot = read_robot(path, None, &mut faults);
    faults.into_result(robot).map(|(robot, _)| robot)
}

/// Checks a file of any format with everything that it leads to.
///
/// # Errors
/// Every mistake in all its files.
pub fn check(path: &Path) -> Result<Checked, ConfigError> {
    let mut faults = Faults::default();
    let files = Files::with_includes(path, &mut faults);
    let Some(main) = files.main() else {
        return faults.into_result(None).map(|((), warnings)| Checked::Library(Vec::new(), warnings));
    };
    match Format::of(main) {
        Some(Format::Robot) => {
            let robot = robot::read(main, &mut faults);
            faults.into_result(robot).map(|(robot, warnings)| Checked::Robot(Box::new(robot), warnings))
        }
        Some(Format::Behaviors) => {
            let names = library(&files, main, &mut faults);
            faults.into_result(names).map(|(names, warnings)| Checked::Library(names, warnings))
        }
        Some(Format::Mission) | None => load_mission(path, None).map(|loaded| Checked::Mission(Box::new(loaded))),
    }
}

fn read_robot(path: &Path, named: Option<&Name>, faults: &mut Faults) -> Option<RobotFile> {
    let files = Files::alone(path, named, faults);
    robot::read(files.main()?, faults)
}

/// A mission file with its libraries and its robot.
fn mission(
    path: &Path,
    files: &Files,
    main: Item<'_>,
    robot_override: Option<&Path>,
    faults: &mut Faults,
) -> Option<(MissionSpec, PathBuf)> {
    if !Format::Mission.is_that_of(main, faults) {
        return None;
    }
    let fields = main.fields(&MISSION, faults)?;
    let robot_name = fields.get("robot").and_then(|item| item.path("the path of a robot file", faults));
    let robot_path = match robot_override {
        Some(path) => Some(path.to_owned()),
        None => robot_name.as_ref().map(|name| beside(path, &name.value)),
    };
    let named = robot_name.as_ref().filter(|_| robot_override.is_none());
    let robot = robot_path.as_ref().and_then(|path| read_robot(path, named, faults));
    let mission = with_robot(files, &fields, robot, faults);
    Some((mission?, robot_path?))
}

/// A mission file with its libraries, for a robot.
fn with_robot<'a>(
    files: &'a Files,
    fields: &Fields<'a>,
    robot: Option<RobotFile>,
    faults: &mut Faults,
) -> Option<MissionSpec> {
    let name = fields.get("mission").and_then(|item| item.name("the name of the mission", faults));
    let (kinds, mut subtrees) = declared(files, fields, faults);
    let raw_world = fields.get("world").and_then(|item| raw::World::read(item, faults));
    let robot_names = robot.as_ref().map(RobotNames::of);
    let world_names = raw_world.as_ref().map(WorldNames::of);
    let world = raw_world.zip(world_names.as_ref()).and_then(|(raw, names)| world::build(raw, names, faults));
    let around = Surroundings {
        kinds: &kinds,
        known: Known { world: world_names.as_ref(), robot: robot_names.as_ref() },
        robot: robot.as_ref(),
        world: world.as_ref(),
    };
    task::check_all(&mut subtrees, &around, faults);
    let task = fields.get("task").and_then(|item| task::build(item, &subtrees, &around, faults))?;
    let (world, robot, names) = (world?, robot?, world_names?);
    let mission = MissionSpec {
        name: name?.value,
        robot: robot.robot,
        world: world.spec,
        start: world.start,
        tree: task.tree,
        names: Names {
            nodes: task.names,
            channels: task.channels,
            places: names.places.into_names(),
            objects: names.objects.into_names(),
            facts: names.facts.into_names(),
            ..robot.names
        },
    };
    outlook::look(&mission, &task.spots, faults);
    Some(mission)
}

/// A library by itself: names of a world are not known in it.
fn library(files: &Files, main: Item<'_>, faults: &mut Faults) -> Option<Vec<String>> {
    let fields = main.fields(&LIBRARY, faults)?;
    fields.get("library").and_then(|item| item.name("the name of the library", faults))?;
    let (kinds, mut subtrees) = declared(files, &fields, faults);
    let around = Surroundings { kinds: &kinds, known: Known { world: None, robot: None }, robot: None, world: None };
    task::check_all(&mut subtrees, &around, faults);
    let own = ["behaviors", "subtrees"].into_iter().filter_map(|key| fields.get(key));
    let names = own.flat_map(|item| item.keys().map(str::to_owned).collect::<Vec<_>>());
    Some(names.collect())
}

/// Behaviors and subtrees of a file and of all that it includes.
fn declared<'a>(files: &'a Files, main: &Fields<'a>, faults: &mut Faults) -> (Kinds, Subtrees<'a>) {
    let (mut kinds, mut subtrees) = (Kinds::default(), Subtrees::default());
    let libraries: Vec<_> = files.libraries().filter_map(|item| item.fields(&LIBRARY, faults)).collect();
    for file in libraries.iter().chain([main]) {
        // A list of includes that is none has led to no files.
        for item in file.get("include").and_then(|item| item.list("a list of paths", faults)).into_iter().flatten() {
            item.path("the path of a file", faults);
        }
        kinds.declare(file.get("behaviors"), &task::RESERVED, faults);
        subtrees.declare(file.get("subtrees"), faults);
    }
    (kinds, subtrees)
}

impl RobotNames {
    fn of(robot: &RobotFile) -> Self {
        let register = |what, names: &[String]| Register::of(what, names.iter().map(String::as_str));
        Self {
            resources: register("resource", &robot.names.resources),
            types: register("type of resource", &robot.names.types),
        }
    }
}
