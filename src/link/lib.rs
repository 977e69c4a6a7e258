//! The edge to other processes: instances and their locks, the wire, the ports of daemon and controller, the janitor.
//!
//! What crosses it is `docs/wire.md`; what it means is decided elsewhere. Nothing here blocks but the janitor.
//!
//! # The daemon's side
//! ```no_run
//! use ambidex_link::{ClockOrigin, DaemonPort, Instance, Link, Station, fresh_epoch, sweep};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! sweep()?;
//! let instance = Instance::fresh();
//! let station = Station::open(instance.lock_daemon()?)?;
//! let mut arm = DaemonPort::open(&station, "left_arm", fresh_epoch(), ClockOrigin::now())?;
//! loop {
//!     arm.beat(); // every 200 ms
//!     for heard in arm.drain() {
//!         println!("{heard:?}");
//!     }
//! #   break;
//! }
//! # Ok(())
//! # }
//! ```

mod clock;
mod controller_port;
mod daemon_port;
mod error;
mod instance;
mod janitor;
mod link;
mod lock;
pub mod serve;
mod services;
mod station;
pub mod watch;
pub mod wire;
mod wire_in;
mod wire_out;

use std::os::fd::BorrowedFd;
use std::time::Duration;

use iceoryx2::prelude::FileDescriptorBased;

pub use clock::{ClockOrigin, fresh_epoch, monotonic_ns};
pub use controller_port::{Beat, ControllerPort, Pulse};
pub use daemon_port::DaemonPort;
pub use error::IpcError;
pub use instance::Instance;
pub use janitor::{Swept, sweep, tidy};
pub use link::{Heard, Link, LinkError};
pub use lock::{Lock, Present};
pub use station::Station;
pub use wire::WIRE_VERSION;
pub use wire_in::Received;

pub use ambidex_model as model;

/// Wall time without a sign of life after which the other side counts as gone.
pub const DEAD_MAN: Duration = Duration::from_secs(1);

/// How often the daemon beats, wall time: five times within [`DEAD_MAN`].
pub const BEAT_EVERY: Duration = Duration::from_millis(200);

/// How often an idle controller shows that it lives, wall time.
pub const PULSE_EVERY: Duration = Duration::from_millis(100);

fn fd_of(ear: &services::Ear) -> BorrowedFd<'_> {
    // SAFETY: the descriptor is the listener's own and stays open as long as it, which the borrow keeps alive.
    unsafe { BorrowedFd::borrow_raw(ear.file_descriptor().native_handle()) }
}
