//! Sessions between a daemon and a controller, both sides as pure machines: attachments and their generations, what is
//! stale, the dead-man. Time is handed in, in nanoseconds of one monotonic clock that both sides share.
//!
//! The same machines run in processes and in the simulation. No port and no clock in here.

mod clock;
mod controller;
mod monitor;
mod pace;
mod presence;
mod reporter;

use std::time::Duration;

pub use clock::ClockOrigin;
pub use controller::{Reply, Session};
pub use monitor::{DIAGNOSE_EVERY, Monitor};
pub use pace::Pace;
pub use presence::{Attendance, Hearing, Presence};
pub use reporter::Reported;

use crate::motion::{ControllerState, ToController};
use crate::{Inhibition, Time};

/// Wall time without a sign of life after which the other side counts as gone.
pub const DEAD_MAN: Duration = Duration::from_secs(1);

/// How often the daemon beats, wall time: three times within [`DEAD_MAN`], so that one may be late by most of a second.
/// It looks for pulses as often.
pub const BEAT_EVERY: Duration = Duration::from_millis(300);

/// How often an idle controller shows that it lives, and looks for beats, wall time. Neither wakes the other.
pub const PULSE_EVERY: Duration = Duration::from_millis(400);

/// How often a controller that reports is asked for what it sees, wall time.
pub const REPORT_EVERY: Duration = Duration::from_millis(100);

/// How often it says once more what has not changed, wall time.
pub const REPEAT_EVERY: Duration = Duration::from_secs(1);

/// The daemon lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// Process id of the daemon.
    pub pid: u32,
    /// This life of the daemon; never 0.
    pub epoch: u64,
    /// When it was sent, nanoseconds.
    pub sent_ns: u64,
}

/// State and attachment of a controller, as it publishes them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// The daemon it is attached to, 0 for none.
    pub epoch: u64,
    /// The attachment, 0 for none.
    pub generation: u32,
    /// When the state was so, robot time; zero while not attached.
    pub at: Time,
    /// Why it may not move; none if it may.
    pub inhibited: Option<Inhibition>,
    /// As of the end of the last step.
    pub state: ControllerState,
}

/// A pulse with its sender and the moment it was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StampedPulse {
    /// The controller's process.
    pub pid: u32,
    /// When it was sent, nanoseconds.
    pub sent_ns: u64,
    /// What it says.
    pub pulse: Pulse,
}

/// A message from a daemon, with what tells whether it is stale.
#[derive(Debug, Clone, PartialEq)]
pub struct Received {
    /// What the controller is told.
    pub message: ToController,
    /// The daemon that sent it.
    pub epoch: u64,
    /// Zero of robot time; only a configuration carries it.
    pub origin: ClockOrigin,
}
