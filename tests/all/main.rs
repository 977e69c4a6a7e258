//! All integration tests in one binary.

mod aborts;
mod attach;
mod fixtures;
mod home;
mod journals;
mod live;
mod processes;
mod published;
mod rebuilt;
mod rooms;
