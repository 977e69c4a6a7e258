//! Robot time from the wall clock.

use std::time::Duration;

use tokio::time::Instant;

use crate::model::Time;

/// Robot time of a run: it starts at zero and passes `speed` times as fast as the wall clock.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    origin: Instant,
    speed: f64,
}

impl Clock {
    /// A clock that is at zero now; `speed` in robot seconds per wall second, finite and above zero.
    pub fn start(speed: f64) -> Self {
        Self {
            origin: Instant::now(),
            speed,
        }
    }

    /// The present moment.
    pub fn now(&self) -> Time {
        Time::ZERO + self.origin.elapsed().mul_f64(self.speed)
    }

    /// When a moment of robot time comes on the wall clock.
    pub fn instant(&self, at: Time) -> Instant {
        // One microsecond more, so that the moment has come even when the division rounds down.
        self.origin + at.since(Time::ZERO).div_f64(self.speed) + Duration::from_micros(1)
    }
}
