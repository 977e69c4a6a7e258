//! Named instances of the robot: where they lie, who has which place in them, and how their transport is set.

mod instance;
mod lock;
mod paths;
mod private;

use iceoryx2::prelude::ipc_threadsafe;

pub use instance::Instance;
pub(crate) use instance::{DAEMONS_FILES, check_controller_name};
pub(crate) use lock::{DAEMON_FILE, GlobalLock, holder, name_in, remove_instance};
pub use lock::{Lock, Present};
pub use paths::shared_memory;
pub(crate) use paths::{PREFIX, base, prefix_of, segments};
pub(crate) use private::restrict;

/// The transport: shared memory whose ports may be used from any thread.
pub(crate) type Transport = ipc_threadsafe::Service;
