//! What a decision makes of the state, and what it waits for.

use std::sync::Arc;

use super::State;
use super::apply::each;
use crate::{FactId, PlaceId, Record, Time};

impl State {
    pub(super) fn decided(&mut self, record: &Record) -> bool {
        let Record::Decided { round, granted, reopened, deadlines, urged, overdue, .. } = record else { return false };
        self.round = *round;
        if let Some(urged) = urged {
            self.urged = Arc::new(urged.iter().map(|urged| (urged.node, urged.priority)).collect());
        }
        if let Some(overdue) = overdue {
            self.overdue = Arc::new(overdue.iter().copied().collect());
        }
        // What one task is granted brings another no nearer to the controller that it waits for.
        if !granted.is_empty() && self.stem().0 == 0 {
            (self.is_awaiting, self.awaited_until) = (false, None);
            self.awaited_of_others = Arc::default();
        }
        let are_granted = each(granted, |grant| self.grant(grant));
        let are_timed = each(deadlines, |deadline| self.begin_time(*deadline));
        reopened.iter().all(|reopened| self.reopen(reopened)) && are_granted && are_timed
    }

    pub(super) fn awaits(&mut self, until: Option<Time>, facts: &[FactId], places: &[PlaceId]) -> bool {
        if facts.is_empty() && places.is_empty() {
            (self.is_awaiting, self.awaited_until) = (true, until);
            return true;
        }
        let are_known = facts.iter().all(|fact| fact.index() < self.world.facts.len());
        if are_known {
            self.awaited_of_others = Arc::new((facts.to_vec(), places.to_vec()));
        }
        are_known
    }
}
