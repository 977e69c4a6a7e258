//! All integration tests in one binary.

mod fixtures;
mod rooms;
mod tidy;
