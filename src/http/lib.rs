//! The control interface of a run: HTTP with JSON and a stream of events, over a Unix socket that only the same user can
//! open, and over loopback where the daemon was told so; and its client, the command line above all.
//!
//! It is served by a thread of its own, which decides nothing and holds up nobody: what changes something goes to the
//! supervisor and from there to root; what is only read comes from a history that the hub keeps beside the run. The
//! routes are described by the OpenAPI document that is made from them ([`document`]).

mod bodies;
mod client;
mod connection;
mod endpoint;
mod gate;
mod hub;
mod limits;
mod problem;
mod routes;
mod server;
#[cfg(test)]
mod tests;
mod token;

pub use bodies::{Outcome, OutcomeKind, Submitted, Tasks};
pub use client::{AskError, Events, Heard, Request, about, answer_of, ask, ask_later, json, read};
pub use connection::answer;
pub use endpoint::{Endpoint, EndpointError};
pub use gate::Way;
pub use hub::{Event, EventKind, Feed, Hub, News, Subscription};
pub use problem::Problem;
pub use routes::{Served, document};
pub use server::Server;
pub use token::Token;
