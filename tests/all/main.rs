//! All integration tests in one binary.

mod driver;
mod fixtures;
mod property;
mod rooms;
mod rules;
mod support;
mod tidy;
