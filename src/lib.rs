//! Ambidex lets a single robot multitask: task trees as actors, resources as leases, controllers
//! as processes over shared memory.

pub mod config;
pub mod model;
pub mod motion;
