//! Fitting text into columns. A character counts as one column.

/// Fewest columns that anything is drawn in; narrower terminals wrap.
pub const MIN_WIDTH: usize = 40;

/// Columns of a text without styles.
pub(super) fn columns(text: &str) -> usize {
    text.chars().count()
}

/// The text cut to a width, with an ellipsis where it was cut.
pub(super) fn clip(text: &str, width: usize) -> String {
    if columns(text) <= width {
        return text.to_owned();
    }
    let Some(room) = width.checked_sub(1) else {
        return String::new();
    };
    let mut cut: String = text.chars().take(room).collect();
    cut.push('…');
    cut
}

/// The text cut or filled to a width.
pub(super) fn fit(text: &str, width: usize) -> String {
    format!("{:<width$}", clip(text, width))
}

/// Items with spaces between them, broken into lines of a width between items only.
pub(super) fn flow<'a>(items: impl IntoIterator<Item = &'a str>, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let mut used = 0;
    for item in items {
        let item = clip(item, width);
        let length = columns(&item);
        if used > 0 && used + 1 + length > width {
            lines.push(String::new());
            used = 0;
        }
        let line = lines.last_mut().expect("it begins with a line");
        if used > 0 {
            line.push(' ');
            used += 1;
        }
        line.push_str(&item);
        used += length;
    }
    lines
}

/// Lines behind a head, the others indented by the head's columns; every line with its end.
pub(super) fn hang(head: &str, head_columns: usize, lines: &[String]) -> String {
    let mut text = String::new();
    for (index, line) in lines.iter().enumerate() {
        match index {
            0 => text.push_str(head),
            _ => text.push_str(&" ".repeat(head_columns)),
        }
        text.push_str(line);
        text.push('\n');
    }
    text
}

/// Names of things that go together: `pick 1 + pick 2`.
pub(super) fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(" + ")
}

/// A count with its noun: `1 step`, `2 steps`.
pub(super) fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_cut_with_an_ellipsis() {
        assert_eq!(clip("gripper", 7), "gripper");
        assert_eq!(clip("gripper", 5), "grip…");
        assert_eq!(clip("gripper", 0), "");
        assert_eq!(fit("ab", 4), "ab  ");
    }

    #[test]
    fn lines_break_between_items_only() {
        let lines = flow(["pick 1 +", "pick 2 +", "a very long name"], 17);
        assert_eq!(lines, ["pick 1 + pick 2 +", "a very long name"]);
        assert_eq!(hang("1: ", 3, &lines), "1: pick 1 + pick 2 +\n   a very long name\n");
        assert_eq!(flow([], 10), [""]);
    }
}
