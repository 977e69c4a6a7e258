//! All integration tests in one binary.

mod aborts;
mod agreement;
mod attach;
mod broken;
mod checking;
mod digests;
mod dispatching;
mod driver;
mod fixtures;
mod history;
mod home;
mod importing;
mod journals;
mod live;
mod pictures;
mod processes;
mod property;
mod published;
mod reading;
mod rebuilt;
mod rooms;
mod rules;
mod shipped;
mod support;
mod tidy;
mod watching;
