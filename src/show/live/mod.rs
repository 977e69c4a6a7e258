//! What a run shows while it goes on and when it ends: who uses which resource, one plain line per event, a summary.

mod line;
mod rows;
mod summary;
#[cfg(test)]
mod tests;

pub use line::line;
pub use rows::rows;
pub use summary::summary;
