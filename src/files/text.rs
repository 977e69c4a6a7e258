//! Text of files as messages quote it, short and without letters that would not be seen; and text as YAML writes it.

use ambidex_model::is_obeyed;

/// The beginning of what was found, for a message.
pub(crate) fn shortened(text: &str) -> String {
    const MAX_SHOWN: usize = 40;
    let text: String = text.chars().take(MAX_SHOWN + 1).map(|at| if is_obeyed(at) { '�' } else { at }).collect();
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// A word or text of one line, in quotes unless every reader of YAML takes it for itself.
pub(crate) fn scalar(text: &str) -> String {
    const MEANT: [&str; 14] =
        ["null", "true", "false", "yes", "no", "on", "off", "y", "n", "nan", "inf", "infinity", "pi", "tau"];
    let is_first = |letter: char| letter.is_ascii_alphabetic() || "_$".contains(letter);
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_$./- ".contains(letter);
    let starts = text.starts_with(is_first) || text.starts_with("../") || text.starts_with("./");
    let is_meant = MEANT.contains(&text.to_lowercase().as_str());
    if starts && !is_meant && !text.ends_with(' ') && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "''"))
    }
}
