//! Fitting text into columns. A wide letter takes two of them, a combining one none.

use textwrap::{Options, WordSplitter};
use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

/// Fewest columns that anything is drawn in; narrower terminals wrap.
pub const MIN_WIDTH: usize = 40;

/// Stands for a space at which no line breaks.
const UNBROKEN: char = '\u{a0}';

/// Columns of a text without styles.
pub(crate) fn columns(text: &str) -> usize {
    text.width()
}

/// The text cut to a width, with an ellipsis where it was cut.
pub(crate) fn clip(text: &str, width: usize) -> String {
    if columns(text) <= width {
        return text.to_owned();
    }
    let Some(room) = width.checked_sub(1) else {
        return String::new();
    };
    let mut used = 0;
    let fits = |letter: &char| {
        used += letter.width().unwrap_or(0);
        used <= room
    };
    text.chars().take_while(fits).chain(['…']).collect()
}

/// The text cut or filled to a width.
pub(crate) fn fit(text: &str, width: usize) -> String {
    let text = clip(text, width);
    let free = width.saturating_sub(columns(&text));
    text + &" ".repeat(free)
}

/// Words behind a head in lines of a width, all but the first indented; every line with its end.
///
/// The head may be styled; what it takes of the first line are the columns of the indent.
pub(crate) fn hang(head: &str, indent: usize, said: &str, width: usize) -> String {
    let rest = " ".repeat(indent);
    let options = Options::new(width).word_splitter(WordSplitter::NoHyphenation);
    let options = options.subsequent_indent(&rest).initial_indent(&rest);
    let lines = textwrap::fill(said, options);
    format!("{head}{}\n", lines.get(indent..).unwrap_or_default())
}

/// The same of items with spaces between them; none is broken, what is too long is cut.
pub(crate) fn flow<'a>(head: &str, indent: usize, items: impl IntoIterator<Item = &'a str>, width: usize) -> String {
    let room = width.saturating_sub(indent);
    let unbroken = |item| clip(item, room).replace(' ', &UNBROKEN.to_string());
    let items: Vec<String> = items.into_iter().map(unbroken).collect();
    hang(head, indent, &items.join(" "), width).replace(UNBROKEN, " ")
}

/// Names of things that go together: `pick 1 + pick 2`.
pub(crate) fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(" + ")
}

/// A count with its noun: `1 step`, `2 steps`.
pub fn count(number: impl TryInto<u64>, noun: &str) -> String {
    let number = number.try_into().unwrap_or(u64::MAX);
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}

/// The least of 1, 2, 5, 10, 20, … tenths of a second that is not less: between the ticks of an axis.
pub(crate) fn round_step(least_s: f64) -> f64 {
    let mut decade = 0.1;
    loop {
        for factor in [1.0, 2.0, 5.0] {
            if decade * factor >= least_s {
                return decade * factor;
            }
        }
        decade *= 10.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_cut_with_an_ellipsis() {
        let check = |text: &str, width: usize, expected: &str| assert_eq!(clip(text, width), expected);
        check("gripper", 7, "gripper");
        check("gripper", 5, "grip…");
        check("gripper", 0, "");
        check("物体を取る", 10, "物体を取る");
        check("物体を取る", 6, "物体…");
        check("e\u{301}e\u{301}e\u{301}", 3, "e\u{301}e\u{301}e\u{301}");
        check("e\u{301}e\u{301}e\u{301}", 2, "e\u{301}…");
        assert_eq!(fit("ab", 4), "ab  ");
        assert_eq!(fit("物体", 5), "物体 ");
    }

    #[test]
    fn lines_break_between_items_only() {
        let check = |items: &[&str], width: usize, expected: &str| {
            assert_eq!(flow("1: ", 3, items.iter().copied(), width), expected);
        };
        check(&["pick 1 +", "pick 2 +", "a very long name"], 20, "1: pick 1 + pick 2 +\n   a very long name\n");
        check(&["物体 1 +", "物体 2"], 13, "1: 物体 1 +\n   物体 2\n");
        check(&[], 10, "1: \n");
        assert_eq!(hang("", 2, "after move 2-1", 14), "after move\n  2-1\n");
        assert_eq!(
            hang("\u{1b}[1mpick\u{1b}[0m  ", 6, "waits for the base", 18),
            "\u{1b}[1mpick\u{1b}[0m  waits for\n      the base\n"
        );
    }
}
