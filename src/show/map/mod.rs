//! The room from above: what stands and lies where, what the arms reach, and where a run drove.

mod picture;
mod plan;
mod scene;

pub use picture::picture;
pub use scene::{Drive, Moment, Scene};
