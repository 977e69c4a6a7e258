//! The task tree as pure machines: root, AND, OR, THEN and leaf, and how requests are chosen.
//!
//! A machine is handed an input and hands back effects. It has no clock, waits for nothing and never fails.

mod allocator;
mod composite;
mod effect;
mod lapse;
mod leaf;
mod message;
mod node;
mod ordering;
mod packing;
mod root;
mod topics;

pub use allocator::{Allocator, Chosen, Greedy, Merged, Serial};
pub use effect::{Effect, Input, Outbox};
pub use message::{Activation, Answer, Down, Release, Up, Verdict};
pub use node::{Node, build};
pub use root::{Root, Settings};
