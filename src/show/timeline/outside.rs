//! What others changed in the world, as notes below a diagram.

use ambidex_record::{History, OutsideChange};

use crate::text::{count, phrase};

/// The first changes from outside with their moments, and how many more there were.
pub(super) fn notes(history: &History, most: usize) -> Vec<String> {
    let changes = history.outside_changes();
    let note = |made: &OutsideChange| {
        format!("{:>7.2} s  {}", made.at.seconds(), phrase::changed_by(&made.change, made.origin, history.names()))
    };
    let mut notes: Vec<String> = changes.iter().take(most).map(note).collect();
    let more = changes.len().saturating_sub(most);
    if more > 0 {
        notes.push(format!("{} more from outside", count(more, "change")));
    }
    notes
}
