//! The one clock: `CLOCK_MONOTONIC`, which all processes of a host share.

use rustix::time::{ClockId, clock_gettime};

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
