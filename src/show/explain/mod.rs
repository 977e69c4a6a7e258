//! Why things came as they did, in sentences made of what the records say: the story of a run, and the account of one
//! behavior.

mod account;
mod because;
mod entry;
mod sentence;
mod step;
mod story;

#[cfg(test)]
mod tests;

pub use account::Account;
pub use story::Story;
