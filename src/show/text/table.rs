//! Lines of columns: each cell is cut or filled to its column, the last takes what is there.

use anstyle::Style;

use super::layout::{clip, columns};
use crate::Palette;

/// Columns below which heads are cut short.
pub(crate) const NARROW: usize = 60;
/// Columns between two columns.
pub(crate) const GAP: usize = 2;

/// A column; the last of a table has the width that is left.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    pub(crate) head: &'static str,
    pub(crate) width: usize,
    pub(crate) is_number: bool,
}

/// A text in a style.
pub(crate) type Cell = (Style, String);

impl Column {
    /// A column for texts up to the longest of these, within bounds.
    pub(crate) fn of<'a>(head: &'static str, texts: impl Iterator<Item = &'a str>, most: usize) -> Self {
        let longest = texts.map(columns).max().unwrap_or_default();
        Self { head, width: longest.min(most).max(columns(head)), is_number: false }
    }

    /// A column of this width.
    pub(crate) fn wide(head: &'static str, width: usize) -> Self {
        Self { head, width, is_number: false }
    }

    /// A column of numbers with so many digits, and at least as wide as its head.
    pub(crate) fn number(head: &'static str, digits: usize) -> Self {
        Self { head, width: digits.max(columns(head)), is_number: true }
    }
}

/// Columns that are left beside these.
pub(crate) fn rest(table: &[Column], width: usize) -> usize {
    let used: usize = table.iter().map(|column| column.width + GAP).sum();
    width.saturating_sub(used)
}

/// The heads of a table.
pub(crate) fn head(table: &[Column], palette: &Palette) -> String {
    let heads: Vec<Cell> = table.iter().map(|column| (palette.strong, column.head.to_owned())).collect();
    line(table, &heads)
}

/// One line of a table.
pub(crate) fn line(table: &[Column], cells: &[Cell]) -> String {
    let mut line = String::new();
    // Spaces that wait for a text behind them, so that lines end where their last text does.
    let mut due = 0;
    for (column, (style, text)) in table.iter().zip(cells) {
        let text = clip(text, column.width);
        let free = column.width - columns(&text);
        let (before, behind) = if column.is_number { (free, 0) } else { (0, free) };
        due += before;
        if !text.is_empty() {
            line.push_str(&" ".repeat(due));
            line.push_str(&Palette::paint(*style, &text));
            due = 0;
        }
        due += behind + GAP;
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_keep_to_their_columns() {
        let table = [Column::wide("name", 6), Column::number("owners", 1), Column::wide("who", 8)];
        let plain = |texts: [&str; 3]| line(&table, &texts.map(|text| (Style::new(), text.to_owned())));
        assert_eq!(head(&table, &Palette::plain()), "name    owners  who");
        assert_eq!(plain(["gripper", "2", "pick 1 + pick 2"]), "gripp…       2  pick 1 …");
        assert_eq!(plain(["base", "", "x"]), "base            x");
        assert_eq!(plain(["base", "", ""]), "base");
        assert_eq!(rest(&table[..2], 20), 4);
    }
}
