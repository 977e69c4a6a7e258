//! The terminal: colors, size, log lines, and lines that are drawn again in place, which log lines do not break.

use std::io::{self, IsTerminal, Write};
use std::os::fd::AsFd;

use ambidex::show::Palette;
use anstream::stream::RawStream;
use anstream::{AutoStream, ColorChoice};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

use crate::args::LogFormat;

/// Log lines that nothing else says: a run tells of its mission itself.
pub const QUIET: &str = "error,ambidex::mission=off";
/// Log lines of a controller that somebody started by hand.
pub const TALKING: &str = "error,ambidex=info";

/// Columns where there is no terminal to ask.
pub const WIDTH: usize = 100;

const CLEAR_ALL: &str = "\x1b[H\x1b[2J";

/// Columns and lines of a terminal; none where there is no terminal.
pub fn size(stream: impl AsFd) -> Option<(usize, usize)> {
    let size = rustix::termios::tcgetwinsize(stream).ok().filter(|size| size.ws_col > 0 && size.ws_row > 1);
    size.map(|size| (usize::from(size.ws_col), usize::from(size.ws_row)))
}

/// The colors that are wanted on a stream.
pub fn palette(stream: &impl RawStream) -> Palette {
    match AutoStream::choice(stream) {
        ColorChoice::Never => Palette::plain(),
        ColorChoice::Auto | ColorChoice::Always | ColorChoice::AlwaysAnsi => Palette::ansi(),
    }
}

/// Lines that are drawn again in place; nothing where nobody looks.
#[derive(Debug, Clone)]
pub struct Display(ProgressBar);

impl Display {
    /// Lines on stdout.
    pub fn stdout() -> Self {
        Self::new(ProgressDrawTarget::stdout())
    }

    fn new(target: ProgressDrawTarget) -> Self {
        let style = ProgressStyle::with_template("{msg}").expect("a fixed template is sound");
        let bar = ProgressBar::no_length().with_style(style);
        bar.set_draw_target(target);
        Self(bar)
    }

    /// Draws these lines over what was drawn last, if anything is different.
    pub fn show(&self, lines: Vec<String>) {
        let text = lines.join("\n");
        if text != self.0.message() {
            self.0.set_message(text);
        }
    }

    /// Clears all of stdout's terminal: one that was resized has broken old lines anew, nobody knows where.
    pub fn start_over(&self) {
        self.suspend(|| drop(io::stdout().write_all(CLEAR_ALL.as_bytes())));
    }

    /// Leaves the lines where they are, whatever is printed next.
    pub fn leave(&self, lines: Vec<String>) {
        self.0.abandon_with_message(lines.join("\n"));
    }

    /// Takes the lines away for a moment.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.0.suspend(print)
    }

    /// Takes the lines away.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }
}

/// stderr as a person sees it.
#[derive(Debug, Clone)]
pub struct Terminal {
    display: Display,
    is_tty: bool,
    palette: Palette,
}

impl Terminal {
    /// Looks at stderr and sends log lines there, above the live display.
    ///
    /// `filter` says which are shown where `RUST_LOG` does not.
    pub fn start(format: LogFormat, filter: &str) -> Self {
        let (stderr, display) = (io::stderr(), Display::new(ProgressDrawTarget::stderr_with_hz(10)));
        let terminal = Self { display, is_tty: stderr.is_terminal(), palette: palette(&stderr) };
        let asked = std::env::var(EnvFilter::DEFAULT_ENV).ok();
        let filter = match asked.as_deref().map(EnvFilter::try_new) {
            Some(Ok(asked)) => asked,
            Some(Err(error)) => {
                terminal.say(&format!("warning: RUST_LOG is not used: {error}"));
                EnvFilter::new(filter)
            }
            None => EnvFilter::new(filter),
        };
        let log = tracing_subscriber::fmt()
            .with_env_filter(filter)
            .with_writer(Above(terminal.display.clone()))
            .with_ansi(terminal.has_color());
        match format {
            LogFormat::Text => log.init(),
            LogFormat::Json => log.json().init(),
        }
        terminal
    }

    /// Whether somebody looks at it.
    pub fn is_tty(&self) -> bool {
        self.is_tty
    }

    /// Whether colors are wanted.
    pub fn has_color(&self) -> bool {
        self.palette != Palette::plain()
    }

    /// Columns to keep to.
    pub fn width(&self) -> usize {
        size(io::stderr()).map_or(WIDTH, |(columns, _)| columns)
    }

    /// Colors, if they are wanted.
    pub fn palette(&self) -> Palette {
        self.palette
    }

    /// Prints a text above the live display.
    pub fn say(&self, text: &str) {
        // Whoever read stderr may be gone; the run is not.
        self.display.suspend(|| drop(writeln!(io::stderr(), "{text}")));
    }

    /// Shows these lines in the live display.
    pub fn show(&self, lines: Vec<String>) {
        self.display.show(lines);
    }

    /// Takes the live display away.
    pub fn clear(&self) {
        self.display.clear();
    }
}

/// Writes log lines above the live display.
#[derive(Debug, Clone)]
struct Above(Display);

impl Write for Above {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.suspend(|| io::stderr().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

impl MakeWriter<'_> for Above {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}
