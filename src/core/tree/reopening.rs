//! What a round ends with beside its grants: something that was done is to be done again, or an intention lapses.

use std::collections::BTreeMap;

use super::ordering::undecided;
use crate::world::View;
use ambidex_model::{NodeId, Reason, Record, Reopened};

/// What root knows at the end of a round.
pub(super) struct RoundEnd<'a> {
    /// With this round's grants.
    pub(super) view: &'a View,
    /// Why everything else does not run.
    pub(super) refused: &'a BTreeMap<NodeId, Reason>,
}

impl RoundEnd<'_> {
    /// At most one in a round.
    pub(super) fn reopen(&self) -> Option<Reopened> {
        let mut reopened = self.redo().or_else(|| self.lapse())?;
        if reopened.lapsed().is_some() {
            let mut after = self.view.state.clone();
            after.apply(&Record::Decided {
                at: self.view.now,
                round: self.view.round,
                granted: Vec::new(),
                refused: Vec::new(),
                reopened: Some(reopened.clone()),
            });
            reopened.undecided = undecided(&self.view.mission.tree, &after, reopened.node);
        }
        Some(reopened)
    }
}
