//! What people see of a run, from its [`History`](ambidex_record::History): one folder per product. Pure: no IO, no
//! decisions.
//!
//! Every function that makes text is told how many columns there are and keeps to them, down to [`MIN_WIDTH`].

pub mod audit;
pub mod chaos;
pub mod conversation;
pub mod doctor;
pub mod explain;
pub mod export;
pub mod live;
pub mod map;
pub mod recording;
pub mod status;
mod svg;
pub mod tasks;
mod text;
pub mod timeline;
pub mod tree;
pub mod trials;

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

pub use text::{MIN_WIDTH, Palette, Unknown, count};
