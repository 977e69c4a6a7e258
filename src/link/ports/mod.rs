//! The two ends of a link over shared memory.

mod answer;
mod controller;
mod daemon;
mod guarded;
mod services;

use std::os::fd::BorrowedFd;

use iceoryx2::prelude::FileDescriptorBased;

pub use controller::ControllerPort;
pub use daemon::DaemonPort;
pub use guarded::GuardedPort;

fn fd_of(listener: &services::Listener) -> BorrowedFd<'_> {
    // SAFETY: the descriptor is the listener's own and stays open as long as it, which the borrow keeps alive.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}
