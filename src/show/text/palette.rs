//! Colors: the paper's yellow, orange and purple where there are colors, none elsewhere. Glyphs tell the same alone.

use std::fmt::Display;

use anstyle::{Ansi256Color, AnsiColor, Style};

use ambidex_record::LeafState;

/// The styles of everything that is drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Palette {
    /// Not yet run.
    pub waiting: Style,
    /// Running.
    pub active: Style,
    /// Done by running.
    pub done: Style,
    /// Done without running.
    pub skipped: Style,
    /// Failed, lost, or broken.
    pub failed: Style,
    /// Ended by being told to.
    pub canceled: Style,
    /// What is to be seen first.
    pub strong: Style,
    /// Axes, numbers and kinds.
    pub faint: Style,
}

impl Palette {
    /// No color at all.
    pub fn plain() -> Self {
        Self::default()
    }

    /// Colors for a terminal, as in the paper's Fig. 7.
    pub fn ansi() -> Self {
        let color = |code| Style::new().fg_color(Some(Ansi256Color(code).into()));
        let red = Style::new().fg_color(Some(AnsiColor::Red.into()));
        Self {
            waiting: color(179).dimmed(),
            active: color(208),
            done: color(98),
            skipped: color(98).bold(),
            failed: red.bold(),
            canceled: red,
            strong: Style::new().bold(),
            faint: Style::new().dimmed(),
        }
    }

    /// Text in a style.
    pub(crate) fn paint(style: Style, text: impl Display) -> String {
        format!("{style}{text}{style:#}")
    }

    /// How far something is, from 0 to 1, as a bar of so many cells.
    pub(crate) fn bar(&self, progress: f64, cells: usize) -> String {
        let full = (progress * cells as f64).floor() as usize;
        let full = full.min(cells);
        let done = Self::paint(self.active, "━".repeat(full));
        done + &Self::paint(self.faint, "─".repeat(cells - full))
    }

    /// The style of a leaf's state.
    pub(crate) fn of(&self, state: LeafState) -> Style {
        match state {
            LeafState::Waiting => self.waiting,
            LeafState::NotAsked | LeafState::NotNeeded => self.faint,
            LeafState::Active => self.active,
            LeafState::Done => self.done,
            LeafState::Skipped => self.skipped,
            LeafState::Failed => self.failed,
            LeafState::Canceled => self.canceled,
        }
    }
}

/// The glyph that stands before a name.
pub(crate) fn mark(state: LeafState) -> char {
    match state {
        LeafState::Waiting => '○',
        LeafState::Active => '●',
        LeafState::Done => '✓',
        LeafState::Skipped | LeafState::Failed | LeafState::Canceled | LeafState::NotAsked | LeafState::NotNeeded => {
            glyph(state)
        }
    }
}

/// The glyph that bars are made of, with and without color.
pub(crate) fn glyph(state: LeafState) -> char {
    match state {
        LeafState::Waiting => '·',
        LeafState::Active => '█',
        LeafState::Done => '─',
        LeafState::Skipped => '◇',
        LeafState::Failed => '✗',
        LeafState::Canceled => '⊘',
        LeafState::NotAsked => '–',
        LeafState::NotNeeded => '∅',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_text_stays_as_it_is() {
        assert_eq!(Palette::paint(Palette::plain().failed, "x"), "x");
        assert_eq!(Palette::paint(Palette::ansi().strong, "x"), "\u{1b}[1mx\u{1b}[0m");
    }
}
