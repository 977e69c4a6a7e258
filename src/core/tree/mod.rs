//! The task tree as pure machines: root, AND, OR, THEN and leaf, and how requests are chosen.
//!
//! A machine is handed an input and hands back effects. It has no clock, waits for nothing and never fails.

mod allocator;
mod composite;
mod lapse;
mod leaf;
mod message;
mod node;
mod ordering;
mod packing;
mod root;

pub use allocator::{Allocator, Chosen, Greedy, Merged, Serial};
pub use message::{Activation, Answer, Down, Release, Up, Verdict};
pub use node::{Effect, Input, Node, Outbox, build};
pub use root::{Begin, Root, Settings};
