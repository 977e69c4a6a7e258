//! Text for people, from records and what is folded from them: diagram, summary, live display, status, tree,
//! conversation, explanations; and pictures in [`svg`]. Pure: no IO, no decisions.
//!
//! Every function that makes text is told how many columns there are and keeps to them, down to [`MIN_WIDTH`].

mod axis;
mod conversation;
mod course;
mod crew;
mod explain;
mod palette;
mod phrase;
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

pub use conversation::{Conversation, Filters, Kind, Selection, Unknown};
pub use course::LeafState;
pub use explain::{Account, Story};
pub use palette::Palette;
pub use phrase::fault_sentence;
pub use progress::Progress;
pub use status::{
    ControllerRow, Daemon, FactRow, GoalRow, Health, HolderRow, NodeRow, ObjectRow, Phase, ResourceRow, Snapshot,
    Status, WorldRow,
};
pub use summary::summary;
pub use text::MIN_WIDTH;
pub use timing::timing;
pub use tree::tree;
pub use why::last_reasons;
