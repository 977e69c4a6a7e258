//! Pictures as SVG, from what is folded from records: timelines with lanes, and task trees. Pure: text out, no files.
//!
//! Every shape is made in `page`, which alone speaks to the SVG crate; every color stands in `style`.

mod fit;
mod history;
mod marks;
mod page;
mod scale;
mod style;
#[cfg(test)]
mod tests;
mod timeline;
mod tree;

pub use history::History;
pub use timeline::{compare, timeline};
pub use tree::tree;
