//! Robot time from the clock of tokio, which a test can pause.

use std::time::Duration;

use tokio::time::Instant;

use ambidex_link::monotonic_ns;
use ambidex_model::Time;
use ambidex_model::session::ClockOrigin;

/// Robot time of a run: it starts at zero, or where its log ends, and passes `speed` times as fast as the wall clock.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    origin: ClockOrigin,
    start: Instant,
    from: Time,
    speed: f64,
}

impl Clock {
    /// A clock that is at zero now; `speed` in robot seconds per wall second, finite and above zero.
    pub fn start(speed: f64) -> Self {
        Self::resume(Time::ZERO, speed)
    }

    /// A clock that is at a later moment now.
    pub fn resume(from: Time, speed: f64) -> Self {
        Self { origin: ClockOrigin(monotonic_ns()), start: Instant::now(), from, speed }
    }

    /// What makes the controllers' clocks agree with this one.
    pub fn origin(&self) -> ClockOrigin {
        self.origin
    }

    /// Robot seconds per wall second.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// The present moment in robot time.
    pub fn now(&self) -> Time {
        self.from + self.origin.time_at(self.now_ns(), self.speed).since(Time::ZERO)
    }

    /// The present moment in nanoseconds of the monotonic clock.
    pub fn now_ns(&self) -> u64 {
        let passed_ns = u64::try_from(self.start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.origin.0.saturating_add(passed_ns)
    }

    /// A moment of the monotonic clock as one of tokio's; a little later, so that it has come when this one has.
    pub fn instant_of_ns(&self, at_ns: u64) -> Instant {
        self.start + Duration::from_nanos(at_ns.saturating_sub(self.origin.0)) + Duration::from_micros(1)
    }

    /// When a moment of robot time comes on the wall clock.
    pub fn instant(&self, at: Time) -> Instant {
        // One microsecond more, so that the moment has come even when the division rounds down.
        self.start + at.since(self.from).div_f64(self.speed) + Duration::from_micros(1)
    }
}
