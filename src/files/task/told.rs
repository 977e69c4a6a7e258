//! What is told of a node beside what it is: how long it may take, how often it is tried and done, how urgent it is.

use std::sync::Arc;
use std::time::Duration;

use super::node::{MAY_RUN, OfAll, PERIOD, RETRIES, TIMES, URGENT, WAITS};
use crate::describe::Reads;
use crate::fault::Faults;
use crate::kinds::BACKOFF_S;
use ambidex_model::{BehaviorSpec, Limits, Repeat};

/// How long a node may take, and how often it is tried, as far as that is told.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Told {
    pub(super) retries: Option<u32>,
    pub(super) backoff_s: Option<f64>,
    pub(super) timeout_s: Option<f64>,
    pub(super) priority: Option<i32>,
    pub(super) repeat: Option<Repeat>,
}

impl Told {
    pub(super) fn of(written: &OfAll<'_>, faults: &mut Faults) -> Self {
        Self {
            priority: written.priority.and_then(|item| URGENT.take(item, faults)),
            repeat: repeat(written, faults),
            retries: written.retries.and_then(|item| RETRIES.take(item, faults)),
            backoff_s: written.backoff.and_then(|item| WAITS.take(item, faults)),
            timeout_s: written.timeout.and_then(|item| MAY_RUN.take(item, faults)),
        }
    }

    /// The same, but for what is told by something that wins.
    pub(super) fn or(self, winner: Self) -> Self {
        Self {
            retries: winner.retries.or(self.retries),
            backoff_s: winner.backoff_s.or(self.backoff_s),
            timeout_s: winner.timeout_s.or(self.timeout_s),
            priority: winner.priority.or(self.priority),
            repeat: winner.repeat.or(self.repeat),
        }
    }

    /// What it makes of a behavior, wherever an object lies that this follows, and at whichever stand.
    pub(super) fn tell(self, behavior: &mut BehaviorSpec) {
        behavior.timeout = self.timeout_s.map_or(behavior.timeout, Duration::from_secs_f64);
        behavior.retries = self.retries.unwrap_or(behavior.retries);
        behavior.backoff = self.backoff_s.map_or(behavior.backoff, Duration::from_secs_f64);
        if let Some(followed) = &mut behavior.elsewhere {
            Arc::make_mut(followed).at.iter_mut().for_each(|other| self.tell(other));
        }
        if let Some(stands) = &mut behavior.stands {
            Arc::make_mut(stands).iter_mut().for_each(|other| self.tell(other));
        }
    }

    /// What it makes of a task node; none where nothing is told.
    pub(super) fn limits(self) -> Option<Limits> {
        let is_told = self.retries.is_some() || self.backoff_s.is_some() || self.timeout_s.is_some();
        is_told.then(|| Limits {
            timeout: self.timeout_s.map(Duration::from_secs_f64),
            retries: self.retries.unwrap_or_default(),
            backoff: Duration::from_secs_f64(self.backoff_s.unwrap_or(BACKOFF_S)),
        })
    }
}

/// How often a node is done, and when; none where that is once.
fn repeat(written: &OfAll<'_>, faults: &mut Faults) -> Option<Repeat> {
    let every = written.every.and_then(|item| PERIOD.take(item, faults)).map(Duration::from_secs_f64);
    let Some(item) = written.repeat else {
        if let Some(every) = &written.every {
            faults.push_with(every, "nothing is repeated here", "write `repeat: forever`, or how often, beside it");
        }
        return None;
    };
    let times = TIMES.take(item, faults)?;
    if times.is_none() && written.every.is_none() {
        faults.push_with(
            &item,
            "repeated without end, it never rests",
            "write how often beside it, such as `every: 60 s`",
        );
    }
    Some(Repeat { times, every })
}
