//! Files to checked specs: every fault with file, line and key, all at once. No tree is built here and nothing runs.

mod describe;
mod difference;
mod document;
mod failures;
mod fault;
mod files;
mod format;
mod import;
mod kinds;
mod lint;
mod names;
mod parameter;
mod quantity;
mod reader;
mod reference;
mod reports;
mod robot;
mod schema;
mod scope;
mod settings;
mod shape;
mod sources;
mod task;
mod template;
#[cfg(test)]
mod tests;
mod text;
mod types;
mod world;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use difference::difference;
pub use fault::{Fault, FilesError, Severity};
pub use format::Format;
pub use import::{Beside, ImportError, Imported, import};
pub use reference::reference;
pub use robot::RobotFile;
pub use schema::schema;
pub use settings::{NoSetting, Setting};
pub use sources::{Disk, InMemory, Sources};

use ambidex_model::{Failures, MissionSpec, Names, Source};
use describe::Described;
use failures::FailureFile;
pub use failures::failures_text;
use fault::Faults;
use files::{Files, beside};
use format::{Library, Mission};
use kinds::Kinds;
use parameter::{Known, RobotNames, refuse_open_defaults};
use reader::Item;
use settings::Given;
use sources::{Kept, Recorder, below};
use task::{Subtrees, Surroundings};
use world::WorldNames;

/// A mission with the file of its robot.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Everything that a run needs to know, shared by all who run it.
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
    /// That many failures; what they name is looked up in the mission that they are used with.
    Failures(usize, Vec<Fault>),
}

/// Loads a mission and the robot that it names, or `robot_override` instead; `settings` are for its parameters.
///
/// # Errors
/// Every mistake in all its files.
pub fn load_mission(
    sources: &dyn Sources,
    path: &Path,
    robot_override: Option<&Path>,
    settings: &[Setting],
) -> Result<Loaded, FilesError> {
    let mut faults = Faults::default();
    let recorder = Recorder::new(sources);
    let files = Files::with_includes(&recorder, path, &mut faults);
    let mut loaded = loaded(path, &files, &Overrides { robot: robot_override, settings }, faults)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let source = Source {
        mission: below(folder, path),
        robot: robot_override.map(|robot| below(folder, robot)),
        settings: settings.iter().map(|setting| (setting.name.clone(), setting.value.clone())).collect(),
        files: recorder.files(folder),
    };
    if let Some(mission) = Arc::get_mut(&mut loaded.mission) {
        mission.source = Some(source);
    }
    Ok(loaded)
}

/// The text of one of the files that a mission was made of.
pub fn kept_text(source: &Source, path: &Path) -> Option<String> {
    Kept::new(source).read(path).ok().and_then(|text| String::from_utf8(text).ok())
}

/// Loads a mission once more from the files that it was made of.
///
/// # Errors
/// Every mistake in all its files, as another version of this program may see them.
pub fn load_source(source: &Source) -> Result<Loaded, FilesError> {
    let setting = |(name, value): &(String, String)| Setting { name: name.clone(), value: value.clone() };
    let settings: Vec<Setting> = source.settings.iter().map(setting).collect();
    let robot = source.robot.as_deref().map(Path::new);
    let mut loaded = load_mission(&Kept::new(source), Path::new(&source.mission), robot, &settings)?;
    if let Some(mission) = Arc::get_mut(&mut loaded.mission) {
        mission.source = Some(source.clone());
    }
    Ok(loaded)
}

/// Loads a robot alone, as a controller process does.
///
/// # Errors
/// Every mistake in the file.
pub fn load_robot(sources: &dyn Sources, path: &Path) -> Result<RobotFile, FilesError> {
    let mut faults = Faults::default();
    let files = Files::alone(sources, path, None, &mut faults);
    let robot = files.main().and_then(|main| robot_of(main, &mut faults));
    faults.into_result(robot).map(|(robot, _)| robot)
}

/// Loads what goes wrong on purpose in a mission.
///
/// # Errors
/// Every mistake in the file.
pub fn load_failures(sources: &dyn Sources, path: &Path, mission: &MissionSpec) -> Result<Failures, FilesError> {
    let mut faults = Faults::default();
    let files = Files::alone(sources, path, None, &mut faults);
    let main = files.main().filter(|main| Format::Failures.is_that_of(*main, &mut faults));
    let file = main.and_then(|main| FailureFile::take(main, &mut faults));
    let failures = file.and_then(|file| failures::build(file, mission, &mut faults));
    faults.into_result(failures).map(|(failures, _)| failures)
}

/// Checks a file of any format with everything that it leads to; `settings` are for the parameters of a mission.
///
/// # Errors
/// Every mistake in all its files.
pub fn check(sources: &dyn Sources, path: &Path, settings: &[Setting]) -> Result<Checked, FilesError> {
    let mut faults = Faults::default();
    let files = Files::with_includes(sources, path, &mut faults);
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
        Some(Format::Failures) => {
            let file = FailureFile::take(main, &mut faults);
            let count = file.and_then(|file| file.failures).map(|failures| failures.len());
            faults.into_result(count).map(|(count, warnings)| Checked::Failures(count, warnings))
        }
        Some(Format::Mission) | None => loaded(path, &files, &Overrides { robot: None, settings }, faults)
            .map(|loaded| Checked::Mission(Box::new(loaded))),
    }
}

/// What is told from outside of the files.
struct Overrides<'a> {
    robot: Option<&'a Path>,
    settings: &'a [Setting],
}

fn loaded(path: &Path, files: &Files<'_>, overrides: &Overrides<'_>, mut faults: Faults) -> Result<Loaded, FilesError> {
    let loaded = files.main().and_then(|main| mission(path, files, main, overrides, &mut faults));
    let ((mission, robot_path), warnings) = faults.into_result(loaded)?;
    Ok(Loaded { mission: Arc::new(mission), robot_path, warnings })
}

/// A file that must be a robot.
fn robot_of(file: Item<'_>, faults: &mut Faults) -> Option<RobotFile> {
    if Format::Robot.is_that_of(file, faults) { robot::read(file, faults) } else { None }
}

/// A mission file with its libraries and its robot.
fn mission(
    path: &Path,
    files: &Files<'_>,
    main: Item<'_>,
    overrides: &Overrides<'_>,
    faults: &mut Faults,
) -> Option<(MissionSpec, PathBuf)> {
    if !Format::Mission.is_that_of(main, faults) {
        return None;
    }
    let file = Mission::take(main, faults)?;
    let robot_path = match overrides.robot {
        Some(path) => Some(path.to_owned()),
        None => file.robot.as_ref().map(|name| beside(path, &name.value)),
    };
    let named = file.robot.as_ref().filter(|_| overrides.robot.is_none());
    let node = robot_path.as_ref().and_then(|path| files.beside(path, named, faults));
    let robot = node.as_ref().and_then(|node| robot_of(Item::root(node), faults));
    let mission = with_robot(files, file, robot, overrides.settings, faults);
    Some((mission?, robot_path?))
}

/// A mission file with its libraries, for a robot.
fn with_robot(
    files: &Files<'_>,
    file: Mission<'_>,
    robot: Option<RobotFile>,
    settings: &[Setting],
    faults: &mut Faults,
) -> Option<MissionSpec> {
    let (kinds, mut subtrees) = declared(files, file.behaviors, file.subtrees, faults);
    let robot_names = robot.as_ref().map(|robot| RobotNames::of(&robot.names));
    let world_names = file.world.as_ref().map(WorldNames::of);
    let world = file.world.zip(world_names.as_ref()).and_then(|(raw, names)| {
        let robot = robot.as_ref().map(|file| (&file.robot, &file.names));
        world::build(raw, names, robot, faults)
    });
    let around = Surroundings {
        kinds: &kinds,
        known: Known { world: world_names.as_ref(), robot: robot_names.as_ref() },
        robot: robot.as_ref(),
        world: world.as_ref(),
    };
    task::check_all(&mut subtrees, &around, faults);
    kinds.check_tables(&around.known, files.main_file(), faults);
    refuse_open_defaults("a mission", file.parameters.iter(), faults);
    let given = Given::of(file.parameters, settings, &around.known, faults);
    let mut task = file.task.and_then(|item| task::build(item, &subtrees, &around, &given, faults))?;
    task.tree.bypass = file.bypass?;
    let (world, robot, names) = (world?, robot?, world_names?);
    reports::check(&robot.reported, &names, &world.spec, faults);
    let mission = MissionSpec {
        name: file.mission?.value,
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
        source: None,
    };
    lint::check(&mission, &task.spans, faults);
    Some(mission)
}

/// A library by itself: names of a world are not known in it.
fn library(files: &Files<'_>, main: Item<'_>, faults: &mut Faults) -> Option<Vec<String>> {
    let file = Library::take(main, faults)?;
    file.library?;
    let (kinds, mut subtrees) = declared(files, file.behaviors, file.subtrees, faults);
    let around = Surroundings { kinds: &kinds, known: Known { world: None, robot: None }, robot: None, world: None };
    task::check_all(&mut subtrees, &around, faults);
    let own = [file.behaviors, file.subtrees].into_iter().flatten();
    Some(own.flat_map(|item| item.keys().collect::<Vec<_>>()).map(str::to_owned).collect())
}

/// Behaviors and subtrees of a file and of all that it includes.
fn declared<'a>(
    files: &'a Files<'_>,
    behaviors: Option<Item<'a>>,
    subtrees: Option<Item<'a>>,
    faults: &mut Faults,
) -> (Kinds, Subtrees<'a>) {
    let (mut kinds, mut parts) = (Kinds::new(task::node_shape().keys()), Subtrees::default());
    for file in files.libraries() {
        let Some(library) = Library::take(file, faults) else { continue };
        kinds.declare(library.behaviors, faults);
        parts.declare(library.subtrees, faults);
    }
    kinds.declare(behaviors, faults);
    parts.declare(subtrees, faults);
    (kinds, parts)
}
