//! Whoever asks: one request and its answer, or the stream of events, over the socket of an instance.

mod call;
mod events;
mod request;

pub use call::{AskError, about, ask, ask_later, read};
pub use events::{Events, Heard};
pub use request::{Request, answer_of, json};
