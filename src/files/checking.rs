//! Files by themselves, of whatever format: what each turned out to be, and everything that is wrong with it.

use std::path::Path;

use crate::describe::Described;
use crate::failures::FailureFile;
use crate::fault::{Fault, Faults, FilesError};
use crate::files::Files;
use crate::format::{Format, Library, TaskFile, WorldFile};
use crate::parameter::refuse_open_defaults;
use crate::reader::Item;
use crate::robot::{self, RobotFile};
use crate::scene::{Scene, declared};
use crate::settings::{Given, Setting, warn_of_settings};
use crate::sources::Sources;
use crate::task::{self, MAX_SUBMITTED, Surroundings};
use crate::whole::{self, Loaded, Overrides, name_or_that_of};

/// What a file turned out to be.
#[derive(Debug, Clone)]
pub enum Checked {
    /// A mission that can be run.
    Mission(Box<Loaded>),
    /// A world, for whatever robot, and what is surely not meant in its file.
    World(WorldSummary, Vec<Fault>),
    /// A task of that name, for whatever world, and what is surely not meant in its file.
    Task(String, Vec<Fault>),
    /// A robot, and what is surely not meant in its file.
    Robot(Box<RobotFile>, Vec<Fault>),
    /// Behaviors and subtrees for missions, by name, and what is surely not meant in their file.
    Library(Vec<String>, Vec<Fault>),
    /// That many failures; what they name is looked up in the mission that they are used with.
    Failures(usize, Vec<Fault>),
}

/// What there is in a world file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorldSummary {
    /// What it is called.
    pub name: String,
    /// How many places.
    pub places: usize,
    /// How many objects.
    pub objects: usize,
    /// The behaviors and subtrees that it declares for all tasks.
    pub declared: Vec<String>,
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
        Some(Format::World) => {
            let summary = world(path, &files, main, settings, &mut faults);
            faults.into_result(summary).map(|(summary, warnings)| Checked::World(summary, warnings))
        }
        Some(Format::Task) => {
            let task = task(path, &files, main, settings, &mut faults);
            faults.into_result(task).map(|(name, warnings)| Checked::Task(name, warnings))
        }
        Some(Format::Mission) | None => {
            let read = whole::mission(path, &files, &Overrides { robot: None, settings }, &mut faults);
            Loaded::of(read, faults).map(|loaded| Checked::Mission(Box::new(loaded)))
        }
    }
}

/// A world by itself: what stands in its robot is not known.
fn world(
    path: &Path,
    files: &Files<'_>,
    main: Item<'_>,
    settings: &[Setting],
    faults: &mut Faults,
) -> Option<WorldSummary> {
    let file = WorldFile::take(main, faults)?;
    warn_of_settings(&file.declared.parameters, settings, faults);
    let declared = names([file.declared.behaviors, file.declared.subtrees]);
    let scene = Scene::read(files, &file.declared, file.world, None, faults);
    let names = scene.names?;
    let (places, objects) = (names.places.names().len(), names.objects.names().len());
    Some(WorldSummary { name: name_or_that_of(file.mission, path), places, objects, declared })
}

/// A task by itself: neither what is in the world nor what its files declare is known.
fn task(path: &Path, files: &Files<'_>, main: Item<'_>, settings: &[Setting], faults: &mut Faults) -> Option<String> {
    let file = TaskFile::take(main, faults)?;
    let (kinds, mut subtrees) = declared(files, file.declared.behaviors, file.declared.subtrees, faults);
    let around = Surroundings { is_open: true, most_nodes: MAX_SUBMITTED, ..Surroundings::of_nowhere(&kinds) };
    task::check_all(&mut subtrees, &around, faults);
    let parameters = file.declared.parameters;
    refuse_open_defaults("a task", parameters.iter(), faults);
    let given = Given::of("the task", parameters, settings, &around.known, faults);
    task::check_alone(file.task?, &subtrees, &around, &given, faults);
    Some(name_or_that_of(file.mission, path))
}

/// A library by itself: names of a world are not known in it.
fn library(files: &Files<'_>, main: Item<'_>, faults: &mut Faults) -> Option<Vec<String>> {
    let file = Library::take(main, faults)?;
    file.library?;
    let (kinds, mut subtrees) = declared(files, file.behaviors, file.subtrees, faults);
    let around = Surroundings::of_nowhere(&kinds);
    task::check_all(&mut subtrees, &around, faults);
    Some(names([file.behaviors, file.subtrees]))
}

/// What is declared in some maps.
fn names(maps: [Option<Item<'_>>; 2]) -> Vec<String> {
    maps.into_iter().flatten().flat_map(|item| item.keys().collect::<Vec<_>>()).map(str::to_owned).collect()
}
