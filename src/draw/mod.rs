//! Text for people, from records and what is folded from them: diagram, summary, live display, tree; and pictures in
//! [`svg`]. Pure: no IO, no decisions.
//!
//! Every function that makes text is told how many columns there are and keeps to them, down to [`MIN_WIDTH`].

mod axis;
mod course;
mod crew;
mod palette;
mod progress;
mod status;
mod summary;
pub mod svg;
mod text;
mod timing;
mod tree;
mod why;

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

pub use course::LeafState;
pub use palette::Palette;
pub use progress::Progress;
pub use status::{
    ControllerRow, Daemon, FactRow, GoalRow, Health, HolderRow, NodeRow, ObjectRow, Phase, ResourceRow, Snapshot,
    Status, WorldRow,
};
pub use summary::summary;
pub use text::MIN_WIDTH;
pub use timing::timing;
pub use tree::tree;
pub use why::{fault_sentence, last_reasons};
