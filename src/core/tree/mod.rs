//! The task tree as pure machines: root, AND, OR, THEN and leaf, and how requests are chosen.
//!
//! A machine is handed an input and hands back effects. It has no clock, waits for nothing and never fails.

mod ahead;
mod allocator;
mod beginning;
mod certificate;
mod cleaning;
mod composite;
mod effect;
mod failing;
mod fairness;
mod feasibility;
mod goals;
mod lapse;
mod leaf;
mod machines;
mod message;
mod node;
mod offers;
mod ordering;
mod outside;
mod overtaking;
mod packing;
mod reaching;
mod reasons;
mod redo;
mod reopening;
mod repeating;
mod root;
mod saving;
mod settings;
mod stopping;
mod tasks;
mod topics;
mod urgency;
mod waiting;
mod winners;
mod work;

use ambidex_model::NodeId;

pub use ahead::split_stands;
pub use allocator::{Allocator, Chosen, Greedy, Serial};
pub use certificate::{Unfinishable, can_finish};
pub use effect::{Effect, Input, Outbox};
pub use feasibility::infeasible_at_start;
pub use machines::Machines;
pub use message::{Activation, Answer, Down, News, Release, Requests, Scope, Up, Verdict};
pub use node::{Node, below_root, build};
pub use offers::Offers;
pub use root::Root;
pub use saving::BranchReader;
pub use settings::{CLEANUP_GRACE, REATTACH, Settings};
pub use topics::Topic;
pub use work::NODES_MAX;

/// The top of the task: root's one child.
const TOP: NodeId = NodeId(1);
