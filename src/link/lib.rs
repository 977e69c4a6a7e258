//! The edge to other processes: instances and their locks, the wire, the ports of daemon and controller, the janitor,
//! and [`serve`] for a controller of your own.
//!
//! What crosses it is `docs/wire.md`; what it means is decided elsewhere. Nothing here blocks but the janitor, the locks
//! (up to 5 s), and [`serve`].
//!
//! # The daemon's side
//! ```no_run
//! use std::sync::Arc;
//!
//! use ambidex_link::model::session::ClockOrigin;
//! use ambidex_link::model::{Labels, MissionSpec};
//! use ambidex_link::{DaemonPort, Instance, IpcNode, Link, fresh_epoch, monotonic_ns, sweep};
//!
//! # fn daemon(mission: MissionSpec) -> Result<(), Box<dyn std::error::Error>> {
//! sweep()?;
//! let labels = Arc::new(Labels::new(&mission.names));
//! let instance = Instance::fresh();
//! let node = IpcNode::open(instance.lock_daemon()?)?;
//! let mut arm = DaemonPort::open(&node, "left_arm", &labels, fresh_epoch(), ClockOrigin(monotonic_ns()))?;
//! loop {
//!     arm.beat(); // every 300 ms
//!     for heard in arm.drain() {
//!         println!("{heard:?}");
//!     }
//! #   break;
//! }
//! # Ok(())
//! # }
//! ```

mod clock;
mod damage;
mod error;
mod instances;
mod janitor;
mod link;
mod node;
mod ports;
mod serve;
pub mod watch;
pub mod wire;

pub use clock::{fresh_epoch, monotonic_ns};
pub use damage::survive_truncation;
pub use error::IpcError;
pub use instances::{Instance, Lock, Present, shared_memory};
pub use janitor::{Resident, Survey, Surveyed, Swept, count_dead_nodes, survey, sweep, sweep_all, tidy};
pub use link::{Heard, Link, LinkError};
pub use node::IpcNode;
pub use ports::{ControllerPort, DaemonPort, GuardedPort};
pub use serve::{Exit, ServeError, ServeEvent, ServeOptions, Stop, Stopper, Watcher, serve};
pub use wire::WIRE_VERSION;

pub use ambidex_model as model;
