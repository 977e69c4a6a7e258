//! Pictures as SVG, from what is folded from records: timelines with lanes, and task trees. Pure: text out, no files.
//!
//! Every shape is made in `page`, which alone speaks to the SVG crate; every color stands in `style`.

mod fit;
mod marks;
mod page;
mod style;
mod tree;

pub use tree::tree;
