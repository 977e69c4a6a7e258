//! What decides: world, behaviors, the task tree, the dispatch of goals; the simulation that runs them without
//! processes, and the replay of what was logged. No IO, no clock, no thread.

pub mod behavior;
pub mod dispatch;
pub mod replay;
pub mod sim;
pub mod tree;
pub mod world;
