//! What decides: world, behaviors, the task tree, the dispatch of goals; and the simulation that runs them without
//! processes. No IO, no clock, no thread.

pub mod behavior;
pub mod dispatch;
pub mod sim;
pub mod tree;
pub mod world;
