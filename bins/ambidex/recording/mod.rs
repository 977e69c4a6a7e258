//! Recordings as MCAP files, for Foxglove and other viewers: while a mission runs, and of a log.

mod error;
mod file;
mod recorder;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::Arc;

use ambidex::model::MissionSpec;
use ambidex::show::recording::{Recording, WallClock};
use miette::{IntoDiagnostic, Result, miette};

use crate::args::MissionArgs;
use crate::terminal::Patience;
pub use error::RecordingError;
pub use file::RecordingFile;
pub use recorder::Recorder;

/// Begins the recording of a mission, if one is wanted.
///
/// # Errors
/// When its file cannot be made, or is to be the log.
pub fn start(
    args: &MissionArgs,
    mission: &Arc<MissionSpec>,
    clock: WallClock,
    patience: Patience,
) -> Result<Option<Recorder>> {
    let Some(path) = &args.record else { return Ok(None) };
    if args.log.as_deref().is_some_and(|log| is_same(log, path)) {
        return Err(miette!(
            help = "give two names: the log has all that happened, the recording what viewers show of it",
            "--log and --record name the same file"
        ));
    }
    let recording = Recording::new(clock, Some(Arc::clone(mission)));
    Ok(Some(Recorder::start(RecordingFile::create(path)?, recording, patience)?))
}

fn is_same(one: &Path, other: &Path) -> bool {
    let absolute = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path)).into_diagnostic();
    absolute(one).ok().zip(absolute(other).ok()).is_some_and(|(one, other)| one == other)
}
