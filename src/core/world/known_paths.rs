//! What was found of the paths from one pose, so that nothing is searched twice.

use super::FreeSpace;
use super::paths::{self, NoPath};
use ambidex_model::Pose;

/// The paths that one behavior asked for from where the base stands. Obstacles never change during a mission, so that
/// only another pose of the base makes them void.
#[derive(Debug, Clone, Default)]
pub struct KnownPaths {
    from: Option<Pose>,
    found: Vec<(Pose, Result<Vec<Pose>, NoPath>)>,
}

impl KnownPaths {
    /// Way points, the goal last; searched for where they are not known.
    ///
    /// # Errors
    /// That there is no free path, or that none was found within bounds.
    pub fn path(&mut self, space: &FreeSpace, from: Pose, to: Pose) -> Result<&[Pose], NoPath> {
        if self.from != Some(from) {
            self.from = Some(from);
            self.found.clear();
        }
        let at = self.found.iter().position(|(goal, _)| *goal == to).unwrap_or_else(|| {
            self.found.push((to, paths::find_path(space, from, to).path));
            self.found.len() - 1
        });
        match &self.found[at].1 {
            Ok(path) => Ok(path),
            Err(no_path) => Err(*no_path),
        }
    }
}
