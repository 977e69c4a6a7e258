//! Robot time from the monotonic clock of a host.

use crate::Time;

/// The moment of a run that is zero in robot time, in nanoseconds of the monotonic clock.
///
/// The daemon takes it once and hands it to every controller, so that all stamp in one time base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClockOrigin(pub u64);

impl ClockOrigin {
    /// Robot time at `now_ns`, where `speed` robot seconds pass per wall second; zero before the origin.
    pub fn time_at(self, now_ns: u64, speed: f64) -> Time {
        let passed_ns = now_ns.saturating_sub(self.0);
        Time((passed_ns as f64 * speed / 1e3) as u64)
    }
}
