//! The paper's Fig. 7: when each behavior was waiting, active and done; as text, and as a picture which also shows who
//! held which resource, on which channel. A picture is of one run, or of two on one axis.

mod axis;
mod bounds;
mod heading;
mod lanes;
mod legend;
mod outside;
mod panel;
mod picture;
mod rows;
#[cfg(test)]
mod tests;
mod text;

pub use picture::{compare, picture};
pub use text::text;
