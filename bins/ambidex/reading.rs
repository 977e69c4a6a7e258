//! Parts of trees that come while a run works, out of the files that came with them.

use std::sync::{Arc, Mutex, PoisonError};

use ambidex::files::TaskLoader;
use ambidex::model::{Fragment, MissionSpec, Source, WorldState};
use ambidex::runtime;
use ambidex::tree;
use miette::Result;

use crate::diagnostics::{printed_plainly, report_all};

/// Reads them for the world of one run.
pub struct FileReader(Mutex<TaskLoader>);

impl FileReader {
    /// One for a run that began with this, shared by all that read for it.
    ///
    /// # Errors
    /// When the files of its world cannot be read any more.
    pub fn shared(mission: &MissionSpec) -> Result<Arc<dyn runtime::BranchReader>> {
        Ok(Arc::new(Self(Mutex::new(TaskLoader::new(mission).map_err(|error| report_all(&error))?))))
    }

    /// The same for whoever computes its decisions again; none reads for a run that takes no work.
    ///
    /// # Errors
    /// As with [`Self::shared`].
    pub fn again(mission: &MissionSpec) -> Result<Option<tree::BranchReader>> {
        if !mission.tree.is_standing() {
            return Ok(None);
        }
        let reader = Self::shared(mission)?;
        Ok(Some(Arc::new(move |source, mission, world_state| reader.read(source, mission, world_state).ok())))
    }
}

impl runtime::BranchReader for FileReader {
    fn read(&self, source: &Source, mission: &MissionSpec, world_state: &WorldState) -> Result<Fragment, String> {
        let mut loader = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let loaded = loader.load_source(source, mission, world_state);
        loaded.map(|loaded| loaded.fragment).map_err(|error| printed_plainly(&error))
    }
}
