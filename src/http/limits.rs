//! How much of what may be asked.

use std::num::NonZeroU32;
use std::time::Duration;

use governor::clock::{Clock, DefaultClock};
use governor::middleware::NoOpMiddleware;
use governor::state::{InMemoryState, NotKeyed};
use governor::{Quota, RateLimiter};

/// Who may be connected at once; one more is told so and hung up on.
pub const CONNECTIONS_MAX: usize = 32;
/// Streams of events at once.
pub const STREAMS_MAX: usize = 8;
/// Longest body, bytes.
pub const BODY_MAX: usize = 16 * 1024;
/// Longest body with task files, bytes.
pub const FILES_MAX: usize = 1024 * 1024;
/// Longest path with headers, bytes. What is written waits in a buffer of that size, too.
pub const HEAD_MAX: usize = 16 * 1024;
/// Most headers.
pub const HEADERS_MAX: usize = 64;
/// How long the next head may take, and how long whoever is connected may ask nothing.
pub const HEAD_WITHIN: Duration = Duration::from_secs(10);
/// How long a body may take.
pub const BODY_WITHIN: Duration = Duration::from_secs(10);
/// How long the run may take for an answer.
pub const ANSWER_WITHIN: Duration = Duration::from_secs(10);
/// How long whoever is written to may take nothing.
pub const TAKEN_WITHIN: Duration = Duration::from_secs(60);
/// What may wait for the reader of a stream, bytes; beyond that it gets the next snapshot instead.
pub const QUEUE_MAX: usize = 256 * 1024;
/// How often something is said on a stream where nothing happens.
pub const HEARTBEAT: Duration = Duration::from_secs(10);
/// How long those that wait are told that the run is over, and streams their last events.
pub const LAST_WORDS: Duration = Duration::from_millis(500);

/// Requests a second that change something, from all together.
const CHANGES_A_SECOND: NonZeroU32 = NonZeroU32::new(200).expect("above zero");
/// So many at once.
const CHANGES_AT_ONCE: NonZeroU32 = NonZeroU32::new(400).expect("above zero");

/// The rate of requests that change something.
#[derive(Debug)]
pub struct Rate<C: Clock = DefaultClock> {
    limiter: RateLimiter<NotKeyed, InMemoryState, C, NoOpMiddleware<C::Instant>>,
}

impl Rate {
    /// Nothing was asked yet.
    pub fn new() -> Self {
        let quota = Quota::per_second(CHANGES_A_SECOND).allow_burst(CHANGES_AT_ONCE);
        Self::of(quota, DefaultClock::default())
    }

    /// One request, and the next in an hour.
    #[cfg(test)]
    pub fn of_one() -> Self {
        Self::of(Quota::with_period(Duration::from_secs(3_600)).expect("above zero"), DefaultClock::default())
    }
}

impl<C: Clock> Rate<C> {
    fn of(quota: Quota, clock: C) -> Self {
        Self { limiter: RateLimiter::new(quota, InMemoryState::default(), clock) }
    }

    /// Counts a request.
    ///
    /// # Errors
    /// How long to wait, where it is one too many.
    pub fn take(&self) -> Result<(), Duration> {
        self.limiter.check().map_err(|not_until| not_until.wait_time_from(self.limiter.clock().now()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use governor::clock::FakeRelativeClock;

    #[test]
    fn as_many_as_the_bucket_holds_then_as_many_as_drip_into_it() {
        let clock = FakeRelativeClock::default();
        let quota = Quota::per_second(CHANGES_A_SECOND).allow_burst(CHANGES_AT_ONCE);
        let rate = Rate::of(quota, clock.clone());
        let taken = || (0..1_000).take_while(|_| rate.take().is_ok()).count();
        assert_eq!(taken(), CHANGES_AT_ONCE.get() as usize);
        assert!(rate.take().is_err_and(|wait| wait <= Duration::from_millis(5)));
        clock.advance(Duration::from_millis(100));
        assert_eq!(taken(), 20);
        clock.advance(Duration::from_secs(60));
        assert_eq!(taken(), CHANGES_AT_ONCE.get() as usize);
    }
}
