//! Ambidex lets a single robot multitask: task trees as actors, resources as leases, controllers
//! as processes over shared memory.
//!
//! Each crate below is a floor of the house (`docs/architecture.md`); this one is their common face.

pub use ambidex_core as core;
pub use ambidex_core::{behavior, dispatch, replay, sim, tree, world};
pub use ambidex_files as files;
pub use ambidex_http as http;
pub use ambidex_link as link;
pub use ambidex_model as model;
pub use ambidex_model::motion;
pub use ambidex_record as record;
pub use ambidex_runtime as runtime;
pub use ambidex_show as show;
