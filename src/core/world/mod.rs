//! Objects, places and geometry, and the snapshot of it all that a round carries.

mod footprint;
mod free_space;
mod geometry;
mod known_paths;
mod paths;
mod view;

pub use free_space::FreeSpace;
pub use geometry::Geometry;
pub use known_paths::KnownPaths;
pub use paths::{Found, NoPath, find_path};
pub(crate) use view::priority;
pub use view::{Compatible, Unconstrained, Use, View};

#[cfg(test)]
mod tests;
