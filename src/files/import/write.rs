//! What was imported as YAML for people: blocks, comments, and quotes where they are needed.
//!
//! The layout is made here, since emitters of YAML put no comments before a block; all values are words, texts of one
//! line and numbers, for which single quotes are enough. Whoever writes with it loads what was written.

use crate::text::scalar;

/// Widest line of comments, letters.
const WIDTH: usize = 110;

/// Lines of a file.
#[derive(Debug, Default)]
pub(super) struct Lines(String);

impl Lines {
    /// A line, indented by two spaces for each level of depth.
    pub(super) fn line(&mut self, depth: usize, text: &str) {
        self.0.extend(std::iter::repeat_n("  ", depth));
        self.0.push_str(text);
        self.0.push('\n');
    }

    /// An empty line between two parts.
    pub(super) fn gap(&mut self) {
        self.0.push('\n');
    }

    /// A comment, on as many lines as it takes.
    pub(super) fn comment(&mut self, depth: usize, text: &str) {
        let mut row = "#".to_owned();
        for word in text.split_whitespace() {
            if row.chars().count() + 1 + word.chars().count() + 2 * depth > WIDTH && row != "#" {
                self.line(depth, &row);
                row = "#".to_owned();
            }
            row += " ";
            row += word;
        }
        self.line(depth, &row);
    }

    /// All lines, each with its end.
    pub(super) fn into_text(self) -> String {
        self.0
    }
}

/// `{key: value, …}`; the values are written already.
pub(super) fn flow<'a>(entries: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let entries = entries.into_iter().map(|(key, value)| format!("{}: {value}", scalar(key)));
    format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
}
