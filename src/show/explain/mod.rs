//! Why things came as they did, in sentences made of what the records say: the story of a run, and the account of one
//! behavior.

mod account;
mod entry;
mod holdings;
mod moment;
mod sentence;
mod standing;
mod story;

#[cfg(test)]
mod tests;

pub use account::Account;
pub use story::Story;
