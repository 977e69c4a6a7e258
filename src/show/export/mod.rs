//! A run for other programs: as trace events, and as tables. Both are made record by record, in memory that grows with the
//! mission and with what is under way, not with the log.

mod attempts;
mod cells;
mod commands;
mod events;
mod table;
mod trace;
mod tracks;
mod world;

pub use events::TraceEvent;
pub use table::{Row, Rows, Table};
pub use trace::Trace;
