//! Paths from where the base stands, each found once and shared by all who ask while it stands there.

use std::sync::Arc;

use elsa::sync::FrozenBTreeMap;

use super::FreeSpace;
use super::paths::{self, NoPath};
use ambidex_model::Pose;

/// What was found of the paths from one pose in a free space. Who asks first searches; that others have asked changes nothing
/// of what is answered.
pub struct Ways {
    space: Arc<FreeSpace>,
    from: Pose,
    found: FrozenBTreeMap<[u64; 3], Box<Result<Vec<Pose>, NoPath>>>,
}

impl Ways {
    /// Of which nothing was asked yet.
    pub fn new(space: &Arc<FreeSpace>, from: Pose) -> Self {
        Self { space: Arc::clone(space), from, found: FrozenBTreeMap::new() }
    }

    /// Whether they begin there, in that free space.
    pub fn are_from(&self, space: &Arc<FreeSpace>, from: Pose) -> bool {
        Arc::ptr_eq(&self.space, space) && self.from == from
    }

    /// Way points, the goal last.
    ///
    /// # Errors
    /// That there is no free path, or that none was found within bounds.
    pub fn to(&self, to: Pose) -> Result<&[Pose], NoPath> {
        let key = [to.at.x, to.at.y, to.heading].map(f64::to_bits);
        let found = self.found.get(&key).unwrap_or_else(|| {
            let path = paths::find_path(&self.space, self.from, to).path;
            self.found.insert(key, Box::new(path))
        });
        found.as_deref().map_err(|no_path| *no_path)
    }

    /// The free space that they lead through.
    pub fn space(&self) -> &Arc<FreeSpace> {
        &self.space
    }
}

impl std::fmt::Debug for Ways {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Ways").field("from", &self.from).finish_non_exhaustive()
    }
}
