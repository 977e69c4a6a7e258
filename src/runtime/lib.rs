//! The actors: one task per node, one per controller link, one for the dispatch, one for the journal.
//!
//! They carry messages and time; every decision is made by the machines inside.

mod clock;
pub mod control;
mod desk;
mod diagnostics;
mod dispatch_task;
mod journal_task;
mod link_task;
pub mod log;
mod node_task;
mod port;
mod signal;
mod supervisor;

pub use clock::Clock;
pub use desk::BranchReader;
pub use diagnostics::Feed;
pub use journal_task::Sink;
pub use port::{Port, Readable, Wake, process_end};
pub use supervisor::{Control, Ended, Options, run};
