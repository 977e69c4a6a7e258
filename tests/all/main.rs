//! All integration tests in one binary.

mod aborts;
mod attach;
mod broken;
mod dispatching;
mod driver;
mod fixtures;
mod home;
mod importing;
mod journals;
mod live;
mod processes;
mod property;
mod published;
mod rebuilt;
mod rooms;
mod rules;
mod support;
mod tidy;
