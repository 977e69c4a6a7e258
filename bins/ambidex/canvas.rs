//! Lines on stdout that are drawn again in place, without an alternate screen and without flicker.

use std::io::{self, IsTerminal, Write};

use ambidex::show::Palette;

/// Columns where there is no terminal to ask.
const WIDTH: usize = 100;
/// Lines of a text that is not drawn again.
const HEIGHT: usize = 500;

const HIDE_CURSOR: &str = "\x1b[?25l";
const SHOW_CURSOR: &str = "\x1b[?25h";
/// What stands between these a terminal shows at once, if it knows how to.
const BEGIN_FRAME: &str = "\x1b[?2026h";
const END_FRAME: &str = "\x1b[?2026l";
const CLEAR_LINE_BEHIND: &str = "\x1b[K";
const CLEAR_BELOW: &str = "\x1b[J";
const CLEAR_ALL: &str = "\x1b[H\x1b[2J";

/// Columns and lines of stdout; the lines without the last, where the cursor rests.
pub fn size() -> (usize, usize) {
    let size = rustix::termios::tcgetwinsize(io::stdout()).ok().filter(|size| size.ws_col > 0 && size.ws_row > 1);
    size.map_or((WIDTH, HEIGHT), |size| (usize::from(size.ws_col), usize::from(size.ws_row) - 1))
}

/// Columns of stdout, and as many lines as a text may have that is not drawn again.
pub fn long_size() -> (usize, usize) {
    (size().0, HEIGHT)
}

/// Colors of stdout.
pub fn palette() -> Palette {
    match anstream::AutoStream::choice(&io::stdout()) {
        anstream::ColorChoice::Never => Palette::plain(),
        anstream::ColorChoice::Auto | anstream::ColorChoice::Always | anstream::ColorChoice::AlwaysAnsi => {
            Palette::ansi()
        }
    }
}

/// Whether stdout can be drawn on again.
pub fn is_terminal() -> bool {
    io::stdout().is_terminal()
}

/// What was drawn last. Dropped, it shows the cursor again.
#[derive(Debug)]
pub struct Canvas {
    drawn: Vec<String>,
    size: (usize, usize),
}

impl Canvas {
    /// Hides the cursor.
    ///
    /// # Errors
    /// When stdout does not take it.
    pub fn new() -> io::Result<Self> {
        io::stdout().write_all(HIDE_CURSOR.as_bytes())?;
        Ok(Self { drawn: Vec::new(), size: size() })
    }

    /// Draws these lines over what was drawn last.
    ///
    /// # Errors
    /// When stdout does not take it.
    pub fn show(&mut self, lines: Vec<String>) -> io::Result<()> {
        let size = size();
        let is_resized = size != self.size;
        if lines == self.drawn && !is_resized {
            return Ok(());
        }
        let mut frame = String::from(BEGIN_FRAME);
        if is_resized {
            // The terminal has broken old lines anew, nobody knows where.
            frame.push_str(CLEAR_ALL);
            self.drawn.clear();
        } else if !self.drawn.is_empty() {
            frame.push_str(&format!("\r\x1b[{}A", self.drawn.len()));
        }
        for (index, line) in lines.iter().enumerate() {
            if self.drawn.get(index) != Some(line) {
                frame.push_str(line);
                frame.push_str(CLEAR_LINE_BEHIND);
            }
            frame.push_str("\r\n");
        }
        frame.push_str(CLEAR_BELOW);
        frame.push_str(END_FRAME);
        (self.drawn, self.size) = (lines, size);
        let mut stdout = io::stdout().lock();
        stdout.write_all(frame.as_bytes())?;
        stdout.flush()
    }
}

impl Drop for Canvas {
    fn drop(&mut self) {
        let mut stdout = io::stdout().lock();
        drop(stdout.write_all(SHOW_CURSOR.as_bytes()).and_then(|()| stdout.flush()));
    }
}
