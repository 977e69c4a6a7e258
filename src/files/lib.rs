//! Files to checked specs: every fault with file, line and key, all at once. No tree is built here and nothing runs.

mod checking;
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
mod live;
mod names;
mod parameter;
mod quantity;
mod reader;
mod reference;
mod reports;
mod robot;
mod room;
mod scene;
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
mod whole;
mod world;

use std::path::Path;

pub use checking::{Checked, WorldSummary, check};
pub use difference::difference;
pub use fault::{Fault, FilesError, Severity};
pub use format::Format;
pub use import::{Beside, ImportError, Imported, import};
pub use live::{LoadedTask, TaskLoader, load_branch, load_task, load_task_source, load_use, task_source, use_source};
pub use reference::reference;
pub use robot::RobotFile;
pub use schema::schema;
pub use settings::{NoSetting, Setting};
pub use sources::{Disk, InMemory, Sources};
pub use whole::Loaded;

use ambidex_model::{Failures, MissionSpec, Source, SourceKind};
use describe::Described;
use failures::FailureFile;
pub use failures::failures_text;
use fault::Faults;
use files::Files;
use sources::{Kept, Recorder};
use whole::{Overrides, robot_of};

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
    let read = whole::mission(path, &files, &Overrides { robot: robot_override, settings }, &mut faults);
    let loaded = Loaded::of(read, faults)?;
    Ok(loaded.made_of(recorder.source(SourceKind::Mission, path, robot_override, settings)))
}

/// Loads a world in which tasks come and go, for a robot: any file with `world`, whose task is not done. `settings` are for
/// the parameters of that task, and only checked.
///
/// # Errors
/// Every mistake in all its files.
pub fn load_world(
    sources: &dyn Sources,
    robot: &Path,
    world: &Path,
    settings: &[Setting],
) -> Result<Loaded, FilesError> {
    world_for(sources, Some(robot), world, settings)
}

fn world_for(
    sources: &dyn Sources,
    robot: Option<&Path>,
    world: &Path,
    settings: &[Setting],
) -> Result<Loaded, FilesError> {
    let mut faults = Faults::default();
    let recorder = Recorder::new(sources);
    let files = Files::with_includes(&recorder, world, &mut faults);
    let read = whole::world(world, &files, &Overrides { robot, settings }, &mut faults);
    let loaded = Loaded::of(read, faults)?;
    Ok(loaded.made_of(recorder.source(SourceKind::World, world, robot, settings)))
}

/// The text of one of the files that a mission was made of.
pub fn kept_text(source: &Source, path: &Path) -> Option<String> {
    Kept::new(source).read(path).ok().and_then(|text| String::from_utf8(text).ok())
}

/// Loads a mission or a world once more from the files that it was made of.
///
/// # Errors
/// Every mistake in all its files, as another version of this program may see them.
pub fn load_source(source: &Source) -> Result<Loaded, FilesError> {
    let (kept, settings) = (Kept::new(source), Setting::all_of(source));
    let (path, robot) = (Path::new(&source.mission), source.robot.as_deref().map(Path::new));
    let loaded = match source.kind {
        SourceKind::World => world_for(&kept, robot, path, &settings)?,
        SourceKind::Mission | SourceKind::Task | SourceKind::Branch | SourceKind::Use => {
            load_mission(&kept, path, robot, &settings)?
        }
    };
    Ok(loaded.made_of(source.clone()))
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
