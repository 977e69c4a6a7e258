//! Robot time from the wall clock.

use std::time::Duration;

use tokio::time::Instant;

use ambidex_link::ClockOrigin;
use ambidex_model::Time;

/// Robot time of a run: it starts at zero and passes `speed` times as fast as the wall clock.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    origin: ClockOrigin,
    start: Instant,
    speed: f64,
}

impl Clock {
    /// A clock that is at zero now; `speed` in robot seconds per wall second, finite and above zero.
    pub fn start(speed: f64) -> Self {
        Self { origin: ClockOrigin::now(), start: Instant::now(), speed }
    }

    /// What makes the controllers' clocks agree with this one.
    pub fn origin(&self) -> ClockOrigin {
        self.origin
    }

    /// Robot seconds per wall second.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// The present moment.
    pub fn now(&self) -> Time {
        self.origin.time(self.speed)
    }

    /// When a moment of robot time comes on the wall clock.
    pub fn instant(&self, at: Time) -> Instant {
        // One microsecond more, so that the moment has come even when the division rounds down.
        self.start + at.since(Time::ZERO).div_f64(self.speed) + Duration::from_micros(1)
    }
}
