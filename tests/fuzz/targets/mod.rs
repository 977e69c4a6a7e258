//! What is fuzzed: plain functions of bytes.

pub mod control;
pub mod execution;
mod fields;
pub mod files;
pub mod generate;
pub mod import;
pub mod large;
pub mod live;
pub mod log;
pub mod wire;

/// What became of an input.
#[derive(Default)]
pub struct Taken {
    pub accepted: bool,
    /// What was said of it: what says something new is worth being changed further.
    pub kinds: Vec<u64>,
}

impl Taken {
    /// Something was said that quotes the input: what is quoted, and numbers, do not count.
    pub fn said(&mut self, text: &str) {
        let mut is_quoted = false;
        let counts = |letter: &char| {
            is_quoted ^= matches!(letter, '`' | '"');
            !is_quoted && !letter.is_numeric()
        };
        self.kinds.push(hash(&text.chars().filter(counts).collect::<String>()));
    }
}

/// A number for a text, the same everywhere.
pub fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
