//! The tasks of a run, each with how far it is: in a line, in a table, or with its tree.

mod detail;
mod summary;
#[cfg(test)]
mod tests;
mod text;

pub use detail::{TaskDetail, detail};
pub use summary::{TaskState, TaskSummary, summaries};
pub use text::{line, table, tree};
