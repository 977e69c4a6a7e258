//! How a mission is to be run.

use std::sync::Arc;
use std::time::Duration;

use super::topics::Topic;
use super::{Allocator, Greedy};
use crate::world::{Bodies, Compatible};
use ambidex_model::{Header, MissionSpec};

/// How long a controller is awaited by default, robot time.
pub const REATTACH: Duration = Duration::from_secs(10);

/// How long cleanups may take by default once a mission is told to end, robot time.
pub const CLEANUP_GRACE: Duration = Duration::from_secs(10);

/// How a mission is to be run.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How requests are chosen.
    pub allocator: Arc<dyn Allocator>,
    /// What may go on at once beyond resources and objects.
    pub rules: Arc<dyn Compatible>,
    /// Whether a request is refused after whose grant something could never be finished.
    pub prevents_deadlock: bool,
    /// Whether a stall waits for the world instead of ending the mission.
    pub waits_when_stalled: bool,
    /// Whether records tell every message between nodes, and with every decision why all else does not run. All that
    /// can be computed again; it grows with nodes times rounds.
    pub has_messages: bool,
    /// How long a controller is awaited without which nothing can go on, robot time.
    pub reattach: Duration,
    /// How long cleanups may take all together once the mission is told to end, robot time.
    pub cleanup_grace: Duration,
    /// Topics whose readers are not asked again, so that rounds go wrong: by this a test shows that it would notice.
    pub unheard: fn(Topic) -> bool,
}

impl Settings {
    /// Whether an answer depends on nothing but what its leaves can read.
    pub(super) fn is_local(&self) -> bool {
        self.allocator.is_local() && self.rules.is_for_root()
    }

    /// How the run of a log was run, by its first record and the allocator that this one names.
    pub fn of(header: &Header, allocator: Arc<dyn Allocator>) -> Self {
        Self {
            allocator,
            waits_when_stalled: header.waits_when_stalled,
            has_messages: header.has_messages,
            reattach: Duration::from_micros(header.reattach_us),
            cleanup_grace: Duration::from_micros(header.cleanup_grace_us),
            ..Self::default()
        }
    }

    /// The first record of a run of a mission.
    pub fn header(&self, mission: &MissionSpec) -> Header {
        Header {
            has_messages: self.has_messages,
            reattach_us: u64::try_from(self.reattach.as_micros()).unwrap_or(u64::MAX),
            cleanup_grace_us: u64::try_from(self.cleanup_grace.as_micros()).unwrap_or(u64::MAX),
            ..Header::new(mission, self.allocator.name(), self.waits_when_stalled)
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            allocator: Arc::new(Greedy),
            rules: Arc::new(Bodies),
            prevents_deadlock: true,
            waits_when_stalled: false,
            has_messages: true,
            reattach: REATTACH,
            cleanup_grace: CLEANUP_GRACE,
            unheard: |_| false,
        }
    }
}
