//! What a run shows while it goes on and when it ends: who uses which resource, one plain line per event, a summary.

mod line;
mod rows;
mod stage;
mod summary;
#[cfg(test)]
mod tests;

pub use line::line;
pub(crate) use line::said;
pub use rows::rows;
pub use stage::{absent, stage};
pub use summary::summary;
