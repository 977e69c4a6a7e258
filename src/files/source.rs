//! A file's text as messages show it: a few lines, of a long line only what is around the place, and nothing that speaks
//! to the terminal.

use miette::{MietteError, MietteSpanContents, NamedSource, SourceCode, SourceSpan, SpanContents};

/// Longest lines that are shown whole, bytes.
const MAX_LINE: usize = 400;
/// How much of a longer one is shown before and behind the place, bytes.
const AROUND: usize = 60;

/// A file and its text.
#[derive(Debug)]
pub(super) struct Source(NamedSource<String>);

impl Source {
    /// The text of a file; letters that a terminal would obey are replaced by others of the same length.
    pub(super) fn new(name: &str, text: &str) -> Self {
        let legible = |letter: char| match letter {
            '\n' | '\t' | '\r' => letter,
            '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => '\u{fffd}',
            _ if letter.is_control() && letter.is_ascii() => '?',
            _ if letter.is_control() => '·',
            _ => letter,
        };
        Self(NamedSource::new(name, text.chars().map(legible).collect()))
    }

    /// The file.
    pub(super) fn name(&self) -> &str {
        self.0.name()
    }
}

impl SourceCode for Source {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let whole = self.0.read_span(span, before, after)?;
        if whole.data().split(|byte| *byte == b'\n').all(|line| line.len() <= MAX_LINE) {
            return Ok(whole);
        }
        let text = self.0.inner();
        let at = text.floor_char_boundary(span.offset());
        let line = text[..at].rfind('\n').map_or(0, |end| end + 1);
        let end = text[at..].find('\n').map_or(text.len(), |length| at + length);
        let from = text.floor_char_boundary(at.saturating_sub(AROUND)).max(line);
        let to = text.ceil_char_boundary((at + span.len() + AROUND).min(end));
        let shown = SourceSpan::from(from..to);
        let (number, column) = (text[..line].matches('\n').count(), text[line..from].chars().count());
        let name = self.name().to_owned();
        Ok(Box::new(MietteSpanContents::new_named(name, &text.as_bytes()[from..to], shown, number, column, 1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str, at: usize) -> String {
        let source = Source::new("file", text);
        let contents = source.read_span(&SourceSpan::from(at..at + 3), 1, 1).unwrap();
        let data = String::from_utf8(contents.data().to_vec()).unwrap();
        format!("{}:{} {data}", contents.line() + 1, contents.column() + 1)
    }

    #[test]
    fn of_a_long_line_the_place_is_shown() {
        assert_eq!(shown("one\ntwo\nthree\n", 4), "1:1 one\ntwo\nthree\n");
        let long = format!("one\n{}here{}\nthree\n", "ä".repeat(300), "b".repeat(1000));
        let expected = format!("2:271 {}here{}", "ä".repeat(30), "b".repeat(59));
        assert_eq!(shown(&long, 604), expected);
    }

    #[test]
    fn nothing_speaks_to_the_terminal() {
        assert_eq!(shown("a\u{1b}[31m\u{9b}\u{202e}z", 0), "1:1 a?[31m·\u{fffd}z");
    }
}
