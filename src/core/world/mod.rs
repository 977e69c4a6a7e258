//! Objects, places and geometry, and the snapshot of it all that a round carries.

mod geometry;
mod paths;
mod view;

pub use geometry::Geometry;
pub use view::{Compatible, Unconstrained, Use, View};
