//! Names of a fixed size, as controllers know them.

use arrayvec::ArrayString;

/// Longest name of an object, a place or a fact that is reported, bytes: mission files know none that is longer.
pub const NAME_MAX: usize = 64;

/// Name of an object, a place or a fact as a controller knows it.
pub type Name = ArrayString<NAME_MAX>;

/// A name, or the beginning of one that is longer than any in a mission.
pub(super) fn shortened(name: &str) -> Name {
    let mut short = Name::new();
    for letter in name.chars() {
        if short.try_push(letter).is_err() {
            break;
        }
    }
    short
}
