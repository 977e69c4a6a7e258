//! The task tree, as indented text and as the paper draws it (Fig. 3 and 4).

mod label;
mod layout;
mod picture;
mod plan;
mod text;

pub use picture::picture;
pub use text::text;
