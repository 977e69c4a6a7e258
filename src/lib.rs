//! Ambidex lets a single robot multitask: task trees as actors, resources as leases, controllers
//! as processes over shared memory.

pub mod behavior;
pub mod config;
pub mod controller;
pub mod dispatch;
pub mod draw;
pub mod ipc;
pub mod journal;
pub mod model;
pub mod motion;
pub mod runtime;
pub mod sim;
pub mod tree;
pub mod world;
