//! Tasks for a robot that works: files to fragments of trees, read against the world as it is now.

mod loader;

use std::path::Path;

pub use loader::{LoadedTask, TaskLoader};

use crate::fault::{Faults, FilesError};
use crate::files::Files;
use crate::settings::Setting;
use crate::sources::{Recorder, Sources};
use ambidex_model::{MissionSpec, Source, SourceKind, WorldState};

/// Loads a task file for the world of `base` as it is `now`. Who loads many keeps a [`TaskLoader`].
///
/// # Errors
/// Every mistake in its files, and every name that the world does not have.
pub fn load_task(
    sources: &dyn Sources,
    path: &Path,
    settings: &[Setting],
    base: &MissionSpec,
    now: &WorldState,
) -> Result<LoadedTask, FilesError> {
    TaskLoader::new(base)?.load_task(sources, path, settings, base, now)
}

/// Loads a task file as a part of a task that is there: of what may come before it or stand beside it nothing is said.
///
/// # Errors
/// Like those of [`load_task`].
pub fn load_branch(
    sources: &dyn Sources,
    path: &Path,
    settings: &[Setting],
    base: &MissionSpec,
    now: &WorldState,
) -> Result<LoadedTask, FilesError> {
    TaskLoader::new(base)?.load_branch(sources, path, settings, base, now)
}

/// Loads a task, or a part of one, from the files that it was made of.
///
/// # Errors
/// Like those of [`load_task`].
pub fn load_task_source(source: &Source, base: &MissionSpec, now: &WorldState) -> Result<LoadedTask, FilesError> {
    TaskLoader::new(base)?.load_source(source, base, now)
}

/// Loads a subtree that the world's files declare, by its name: a task without a file.
///
/// # Errors
/// Like those of [`load_task`].
pub fn load_use(
    name: &str,
    settings: &[Setting],
    base: &MissionSpec,
    now: &WorldState,
) -> Result<LoadedTask, FilesError> {
    TaskLoader::new(base)?.load_use(name, settings, base, now)
}

/// A subtree by its name as a task, for who knows the world.
pub fn use_source(name: &str, settings: &[Setting]) -> Source {
    let settings = Setting::pairs(settings);
    Source { kind: SourceKind::Use, mission: name.to_owned(), robot: None, settings, files: Vec::new() }
}

/// A task file and all that it includes as they are, for who knows the world.
///
/// # Errors
/// What cannot be read, and what is no YAML; all else is found where the world is known.
pub fn task_source(sources: &dyn Sources, path: &Path, settings: &[Setting]) -> Result<Source, FilesError> {
    let mut faults = Faults::default();
    let recorder = Recorder::new(sources);
    let files = Files::with_includes(&recorder, path, &mut faults);
    let source = files.main().map(|_| recorder.source(SourceKind::Task, path, None, settings));
    faults.into_result(source).map(|(source, _)| source)
}
