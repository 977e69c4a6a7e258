//! The canvas of both pictures: shapes, signs, colors, widths of text, the axis. Every shape is made in `page`, which
//! alone speaks to the SVG crate; every color stands in `style`.

pub(crate) mod fit;
pub(crate) mod marks;
pub(crate) mod page;
pub(crate) mod scale;
mod style;
