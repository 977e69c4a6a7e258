//! stdout as a page: colors and width where somebody looks at it, and a reader that may leave before the end.

use std::io::{self, BufWriter, StdoutLock, Write};

use ambidex::show::Palette;
use miette::{IntoDiagnostic, Result};
use serde::Serialize;

use crate::terminal::{self, WIDTH};

/// stdout of a verb that prints text.
#[derive(Debug)]
pub struct Page {
    out: BufWriter<StdoutLock<'static>>,
    palette: Palette,
}

impl Page {
    /// A page with the colors that stdout takes.
    pub fn new() -> Self {
        let stdout = io::stdout();
        let palette = terminal::palette(&stdout);
        Self { out: BufWriter::with_capacity(1 << 16, stdout.lock()), palette }
    }

    /// Colors, if they are wanted.
    pub fn palette(&self) -> Palette {
        self.palette
    }

    /// Columns to keep to.
    pub fn width(&self) -> usize {
        terminal::size(io::stdout()).map_or(WIDTH, |(columns, _)| columns)
    }

    /// Prints a line; false where nobody reads any more, as behind `head`.
    pub fn line(&mut self, line: &str) -> Result<bool> {
        let written = self.out.write_all(line.as_bytes()).and_then(|()| self.out.write_all(b"\n"));
        is_read(written)
    }

    /// Prints a text that has its line ends.
    pub fn text(&mut self, text: &str) -> Result<bool> {
        is_read(self.out.write_all(text.as_bytes()).and_then(|()| self.out.flush()))
    }

    /// Prints an answer, as one object of JSON or as text.
    pub fn tell<T: Serialize>(
        mut self,
        is_json: bool,
        answer: &T,
        text: impl FnOnce(&T, usize, &Palette) -> String,
    ) -> Result<()> {
        if is_json {
            self.line(&serde_json::to_string(answer).into_diagnostic()?)?;
            self.flush()?;
        } else {
            let text = text(answer, self.width(), &self.palette);
            self.text(&text)?;
        }
        Ok(())
    }

    /// Hands on what was printed so far.
    pub fn flush(&mut self) -> Result<bool> {
        is_read(self.out.flush())
    }
}

/// Whether somebody still reads, as far as a write tells; any other failure is one.
pub fn is_read(written: io::Result<()>) -> Result<bool> {
    match written {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(error).into_diagnostic(),
    }
}
