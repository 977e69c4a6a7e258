//! The one clock: `CLOCK_MONOTONIC`, which all processes of a host share, and robot time made from it.

use rustix::time::{ClockId, clock_gettime};

use ambidex_model::Time;

/// Nanoseconds of `CLOCK_MONOTONIC`.
pub fn monotonic_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.cast_unsigned() * 1_000_000_000 + now.tv_nsec.cast_unsigned()
}

/// A number for this life of a daemon that none before it had: the time of day in nanoseconds.
pub fn fresh_epoch() -> u64 {
    let now = clock_gettime(ClockId::Realtime);
    (now.tv_sec.cast_unsigned() * 1_000_000_000 + now.tv_nsec.cast_unsigned()).max(1)
}

/// The moment of a run that is zero in robot time, in nanoseconds of [`monotonic_ns`].
///
/// The daemon takes it once and hands it to every controller, so that all stamp in one time base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClockOrigin(pub u64);

impl ClockOrigin {
    /// Robot time begins now.
    pub fn now() -> Self {
        Self(monotonic_ns())
    }

    /// Robot time at `now_ns`, where `speed` robot seconds pass per wall second; zero before the origin.
    pub fn time_at(self, now_ns: u64, speed: f64) -> Time {
        let passed_ns = now_ns.saturating_sub(self.0);
        Time((passed_ns as f64 * speed / 1e3) as u64)
    }

    /// Robot time now.
    pub fn time(self, speed: f64) -> Time {
        self.time_at(monotonic_ns(), speed)
    }
}
