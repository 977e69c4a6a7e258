//! What travels between the parts of Ambidex and what every controller needs: the words, what a run has come to, the
//! motion of simulated controllers, the sessions of real ones. No IO, no clock.

pub mod motion;
pub mod session;
pub mod state;
mod words;

pub use words::*;
