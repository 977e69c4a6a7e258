//! A controller's process: attach your own robot by handing a [`Controller`](ambidex_model::motion::Controller) to [`serve`].
//!
//! The runtime starts it or you do; it waits for a daemon, takes its commands one at a time, and outlives it.
//! Motion is asked for in steps of [`STEP`](ambidex_model::motion::STEP) of robot time. Other languages: `docs/wire.md`.
//!
//! # A head of your own
#![doc = concat!("```no_run\n", include_str!("../examples/head.rs"), "```")]

mod error;
mod server;
mod stop;

pub use error::ServeError;
pub use server::{Exit, ServeEvent, ServeOptions, Watcher, serve};
pub use stop::{Stop, Stopper};
