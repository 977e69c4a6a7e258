//! What others ask of a run, over a socket of its instance that only the same user can open: lines of JSON, a request and
//! its answer each. Root decides; who serves the socket only carries.

mod client;
mod protocol;
mod server;
mod words;

pub use client::{AskError, ask};
pub use protocol::{Answer, PROTOCOL_VERSION, Request, Why, WorldChange, read_answer};
pub use server::{ControlError, ControlSocket};
pub use words::asked;
