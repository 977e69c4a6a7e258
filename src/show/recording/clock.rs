//! Robot time on the clock of whoever looks at a recording.

use ambidex_model::Time;

/// How moments of robot time become those of the wall clock. It is set once, so that what was a second apart for the robot
/// is so in the recording, whenever it was written and however somebody sets the clock of the machine meanwhile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallClock {
    /// Nanoseconds since 1970 when robot time was zero.
    origin_ns: u64,
    speed: f64,
}

impl WallClock {
    /// For a run that has no wall clock, as a simulation: robot time itself, counted from the beginning of 1970.
    pub const NONE: Self = Self { origin_ns: 0, speed: 1.0 };

    /// A clock on which it is `now_ns` nanoseconds since 1970 while robot time is `now`, and which passes `speed` robot
    /// seconds per second.
    pub fn set(now_ns: u64, now: Time, speed: f64) -> Self {
        let before_ns = (now.0 as f64 * 1e3 / speed) as u64;
        Self { origin_ns: now_ns.saturating_sub(before_ns), speed }
    }

    /// Nanoseconds since 1970 at a moment of robot time.
    pub fn at_ns(&self, at: Time) -> u64 {
        let passed_ns = at.since(Time::ZERO).div_f64(self.speed).as_nanos();
        self.origin_ns.saturating_add(u64::try_from(passed_ns).unwrap_or(u64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robot_time_passes_as_fast_as_the_robot_lives() {
        let check = |clock: WallClock, at_us, expected_ns| assert_eq!(clock.at_ns(Time(at_us)), expected_ns, "{at_us}");
        check(WallClock::NONE, 1_500_000, 1_500_000_000);
        let usual = WallClock::set(1_000_000_000_000, Time::ZERO, 1.0);
        check(usual, 0, 1_000_000_000_000);
        check(usual, 2_000_000, 1_002_000_000_000);
        let fast = WallClock::set(1_000_000_000_000, Time(40_000_000), 20.0);
        check(fast, 40_000_000, 1_000_000_000_000);
        check(fast, 60_000_000, 1_001_000_000_000);
        check(fast, 0, 998_000_000_000);
    }
}
