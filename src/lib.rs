//! Ambidex lets a single robot multitask: task trees as actors, resources as leases, controllers
//! as processes over shared memory.

pub mod config;
pub mod model;
pub mod motion;
pub mod runtime;
pub mod sim;
pub mod tree;
pub mod world;
