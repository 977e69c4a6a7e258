//! What all products have in common: words for what happens, fitting into columns, colors.

mod branches;
mod brief;
mod ending;
mod layout;
mod palette;
pub(crate) mod phrase;
pub(crate) mod table;
mod unknown;
pub(crate) mod work;

pub(crate) use branches::{branches, last_children};
pub(crate) use ending::{NOT_ENDED, ended, ending, mission_ended, of_end, shortest_cause};
pub use layout::{MIN_WIDTH, count};
pub(crate) use layout::{clip, columns, fit, flow, hang, listed, round_step};
pub use palette::Palette;
pub(crate) use palette::{glyph, mark};
pub use unknown::Unknown;
pub(crate) use unknown::Wanted;
