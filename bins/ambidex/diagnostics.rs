//! Faults of files as a terminal shows them: a few lines around the place, of a long line only what is near, and nothing
//! that speaks to the terminal.

use std::error::Error;
use std::fmt::{self, Write as _};
use std::io::Write;
use std::iter;

use ambidex::files::{Fault, FilesError, Severity};
use ambidex::model::{is_obeyed, make_legible};
use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError, MietteSpanContents, NamedSource,
    Report, SourceCode, SourceSpan, SpanContents,
};

/// Longest lines that are shown whole, bytes.
const MAX_LINE: usize = 400;
/// How much of a longer one is shown before and behind the place, bytes.
const AROUND: usize = 60;

/// A text in one line, without what a terminal obeys.
pub fn legible(text: &str) -> String {
    let mut text = text.to_owned();
    make_legible(&mut text);
    text
}

/// Says what was found in files that can be used all the same.
pub fn say_all(warnings: &[Fault]) {
    warnings.iter().for_each(|warning| say(&report(warning)));
}

/// Says lines on stderr as they are, but for what a terminal obeys.
pub fn say_lines<'a>(lines: impl Iterator<Item = &'a str>) {
    lines.for_each(|line| drop(writeln!(std::io::stderr(), "{}", legible(line))));
}

/// Says on stderr what is wrong.
pub fn say(report: &Report) {
    drop(writeln!(std::io::stderr(), "{}", printed(report)));
}

/// A report as it is printed; of many mistakes first how many there are, then each by itself.
fn printed(report: &Report) -> String {
    let all = report.downcast_ref::<All>().map(|all| &all.error);
    let each = all.iter().flat_map(|error| error.faults()).map(|fault| format!("\n{:?}", self::report(fault)));
    iter::once(format!("{report:?}")).chain(each).collect()
}

/// All mistakes as text without colors, for whoever is not at this terminal.
pub fn printed_plainly(error: &FilesError) -> String {
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
    let mut text = String::new();
    for fault in error.faults() {
        // A text takes all that is written to it.
        let _ = handler.render_report(&mut text, &Shown::new(fault));
    }
    if error.uncounted() > 0 {
        let _ = writeln!(text, "{} more are not shown", error.uncounted());
    }
    text.trim_end().to_owned()
}

/// One mistake or warning as it is shown.
pub fn report(fault: &Fault) -> Report {
    Shown::new(fault).into()
}

/// All mistakes as they are shown: a single one speaks for itself.
pub fn report_all(error: &FilesError) -> Report {
    match error.faults() {
        [only] => report(only),
        _ => All { error: error.clone() }.into(),
    }
}

/// A fault with the text around it.
#[derive(Debug)]
struct Shown {
    fault: Fault,
    source: Source,
}

/// Several of them, which [`say`] prints behind it: as related ones each would have an empty head.
#[derive(Debug)]
struct All {
    error: FilesError,
}

impl Shown {
    fn new(fault: &Fault) -> Self {
        Self { source: Source::new(fault.file(), fault.text()), fault: fault.clone() }
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fault.fmt(f)
    }
}

impl Error for Shown {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.fault.source()
    }
}

impl Diagnostic for Shown {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.fault.help().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.fault.severity() {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        })
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.fault.bytes().map(|_| &self.source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let bytes = self.fault.bytes()?;
        let label = LabeledSpan::new(Some("here".to_owned()), bytes.start, bytes.len().max(1));
        Some(Box::new(iter::once(label)))
    }
}

impl fmt::Display for All {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(f)
    }
}

impl Error for All {}

impl Diagnostic for All {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let uncounted = self.error.uncounted();
        (uncounted > 0).then(|| Box::new(format!("{uncounted} more are not shown")) as Box<_>)
    }
}

/// A file and its text.
#[derive(Debug)]
pub(crate) struct Source(NamedSource<String>);

impl Source {
    /// The text of a file; letters that a terminal would obey are replaced by others of the same length.
    pub(crate) fn new(name: &str, text: &str) -> Self {
        let legible = |letter: char| match letter {
            '\n' | '\t' | '\r' => letter,
            _ if !is_obeyed(letter) => letter,
            _ => match letter.len_utf8() {
                1 => '?',
                2 => '·',
                _ => '\u{fffd}',
            },
        };
        Self(NamedSource::new(name, text.chars().map(legible).collect()))
    }

    /// The file.
    pub(crate) fn name(&self) -> &str {
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
    use ambidex::files::{InMemory, check};
    use proptest::prelude::*;

    use super::*;

    fn shown(text: &str, at: usize) -> String {
        let source = Source::new("file", text);
        let contents = source.read_span(&SourceSpan::from(at..at + 3), 1, 1).unwrap();
        let data = String::from_utf8(contents.data().to_vec()).unwrap();
        format!("{}:{} {data}", contents.line() + 1, contents.column() + 1)
    }

    /// What is printed of a mission in memory, without its frame.
    fn printed(mission: &str) -> String {
        let mut files = InMemory::default();
        files.insert("mission.yaml", mission);
        let error = check(&files, "mission.yaml".as_ref(), &[]).expect_err("it has mistakes");
        super::printed(&report_all(&error))
    }

    #[test]
    fn one_mistake_speaks_for_itself_and_several_are_counted() {
        for (mission, there, not_there) in [
            ("[1, 2]", vec!["× found a list instead of a mission", "[mission.yaml:1:1]"], vec!["mistakes in"]),
            ("tsk: 1", vec!["× 5 mistakes in the files", "did you mean `task`?", "[mission.yaml:1:1]"], vec![]),
            ("", vec!["found nothing instead of a mission"], vec!["mistakes in"]),
            ("mission: |\n  one\n  two\nrobot: r\nworld: {}\n", vec!["one line of printable letters"], vec!["╭─▶"]),
            ("mission: a\n\"b\\e[31m\": 1\n", vec!["a mission has no key `b�[31m`"], vec!["\u{1b}[31mb"]),
        ] {
            let printed = printed(mission);
            assert!(there.iter().all(|words| printed.contains(words)), "{mission}: {printed}");
            assert!(!not_there.iter().any(|words| printed.contains(words)), "{mission}: {printed}");
        }
        for (mission, count) in [("tsk: 1", 5), ("mission: a\ntask: {mve: a}\nrobot: b\n", 3)] {
            let printed = printed(mission);
            assert_eq!(printed.matches('×').count(), count + 1, "{printed}");
            let is_empty_head = |line: &str| matches!(line.trim(), "Error:" | "Warning:" | "Advice:");
            assert!(!printed.lines().any(is_empty_head), "{printed}");
        }
        let many: String = (0..150).map(|n| format!("key{n}: 1\n")).collect();
        assert!(printed(&many).contains("54 more are not shown"), "{}", printed(&many));
    }

    proptest! {
        #[test]
        fn any_text_can_be_shown(text in "[-a-z0-9 :\\[\\]{},&*!|>'\"#~%@.é\r\n\t]{0,120}") {
            prop_assert!(printed(&text).contains("mission.yaml"));
        }
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
        assert_eq!(shown("a\u{1b}[31m\u{9b}\u{202e}z\u{61c}\u{2028}", 0), "1:1 a?[31m·\u{fffd}z·\u{fffd}");
    }
}
