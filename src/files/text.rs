//! Text of files as messages quote it: short, and without letters that would not be seen.

/// Whether a letter would not be seen, or would turn what is seen around.
pub(crate) fn is_unprintable(letter: char) -> bool {
    letter.is_control() || matches!(letter, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The beginning of what was found, for a message.
pub(crate) fn shortened(text: &str) -> String {
    const MAX_SHOWN: usize = 40;
    let text: String = text.chars().take(MAX_SHOWN + 1).map(|at| if is_unprintable(at) { '�' } else { at }).collect();
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
