//! How a mission begins, and how it goes on after its runtime was gone.

use super::{Outbox, Root};
use crate::behavior;
use ambidex_model::state::Stage;
use ambidex_model::{Change, End, Origin, Outcome, Record, Time};

impl Root {
    /// The first time the mission begins. Any other time it goes on after its runtime was gone: whatever is different
    /// now came from outside, and what ran then ended.
    pub(super) fn begin(&mut self, now: Time, changes: Vec<Change>, out: &mut Outbox) {
        (self.is_wanted, self.is_suspended) = (true, false);
        if self.state.stage() == Stage::Waiting {
            let mut world_state = Box::new(self.state.world().clone());
            for change in changes {
                world_state.apply(change);
            }
            self.edit(Record::Began { at: now, world_state }, out);
            return;
        }
        self.find_out(now, changes, Origin::Resumed, out);
        self.serve_all(now, out);
        self.interrupt(now, out);
    }

    /// Takes over what controllers say after a time in which nobody heard them.
    pub(super) fn find_out(&mut self, now: Time, changes: Vec<Change>, origin: Origin, out: &mut Outbox) {
        for change in changes {
            for change in behavior::understood(change, &self.state, &self.mission) {
                self.change_world(now, change, origin, out);
            }
        }
    }

    /// What ran when its runtime was gone has ended: nobody works on it any more.
    pub(super) fn interrupt(&mut self, now: Time, out: &mut Outbox) {
        self.is_suspended = false;
        for leaf in self.state.running().keys().copied().collect::<Vec<_>>() {
            self.release(now, leaf, Outcome { end: End::Interrupted, changes: Vec::new() }, out);
        }
    }
}
