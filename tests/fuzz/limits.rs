//! What one input may cost.

use std::time::Duration;

/// CPU time of all threads. Without optimization everything takes many times as long, so that only what does not scale
/// is found there.
pub const CPU: Duration = if cfg!(debug_assertions) { Duration::from_secs(30) } else { Duration::from_secs(1) };

/// Most bytes in use at once, above those in use before.
pub const BYTES: usize = 100_000_000;

/// Wall time after which an input is said never to end: far above that of a machine that does much else.
pub const HANGS: Duration = Duration::from_secs(120);

/// Largest input that is made: what is read at most, and a little more.
pub const INPUT: usize = (1 << 20) + 4096;
