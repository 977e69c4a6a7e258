//! What a round ends with beside its grants: something that was done is to be done again, or need not be done, or an
//! intention lapses.

use std::collections::BTreeMap;

use super::goals::holds;
use super::ordering::undecided;
use super::overtaking::{Overtaken, Overtaking};
use crate::world::View;
use ambidex_model::{NodeId, Reason, Record, Reopened};

/// What root knows at the end of a round.
pub(super) struct RoundEnd<'a> {
    /// With this round's grants.
    pub(super) view: &'a View,
    /// Why everything else does not run.
    pub(super) refused: &'a BTreeMap<NodeId, Reason>,
}

/// What is done again, or need not be done.
#[derive(Debug, Clone)]
pub(super) enum Found {
    Reopened(Reopened),
    Overtaken(Overtaken),
}

impl RoundEnd<'_> {
    /// At most one in a round.
    pub(super) fn find(&self) -> Option<Found> {
        let of_leaf = |(leaf, lacking)| {
            let overtaken = self.overtaken(leaf).map(Found::Overtaken);
            overtaken.or_else(|| self.redo(leaf, lacking).map(Found::Reopened))
        };
        self.lacking().find_map(of_leaf).or_else(|| self.lapsed().map(Found::Reopened))
    }

    /// What a blocked leaf need not do any more, while nothing below that THEN runs or waits.
    fn overtaken(&self, leaf: NodeId) -> Option<Overtaken> {
        let tree = &self.view.mission.tree;
        let (holds, can_go_on) = (&|leaf, _: &[_]| holds(self.view, leaf), &|then| self.is_idle(then));
        Overtaking { tree, state: &self.view.state, holds, can_go_on }.by(leaf)
    }

    fn lapsed(&self) -> Option<Reopened> {
        let mut reopened = self.lapse()?;
        if reopened.lapsed().is_some() {
            let mut after = self.view.state.clone();
            after.apply(&Record::Decided {
                at: self.view.now,
                round: self.view.round,
                granted: Vec::new(),
                refused: Vec::new(),
                reopened: Some(reopened.clone()),
                deadlines: Vec::new(),
                urged: None,
                overdue: None,
            });
            reopened.undecided = undecided(&self.view.mission.tree, &after, reopened.node);
        }
        Some(reopened)
    }
}
