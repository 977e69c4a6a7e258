//! Objects, places and geometry, and the snapshot of it all that a round carries.

mod bodies;
mod footprint;
mod free_space;
mod geometry;
mod paths;
mod view;
mod ways;

pub use bodies::{Bodies, beside_running, overlap};
pub use free_space::FreeSpace;
pub use geometry::Geometry;
pub use paths::{Found, NoPath, find_path};
pub(crate) use view::priority;
pub use view::{Compatible, Unconstrained, Use, View};

#[cfg(test)]
mod tests;
pub use ways::Ways;
