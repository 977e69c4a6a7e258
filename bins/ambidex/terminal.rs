//! The terminal: colors, width, log lines, and a live display that log lines do not break.

use std::io::{self, IsTerminal, Write};

use ambidex::show::Palette;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

use crate::args::LogFormat;

/// Log lines that nothing else says: a run tells of its mission itself.
pub const QUIET: &str = "error,ambidex::mission=off";
/// Log lines of a controller that somebody started by hand.
pub const TALKING: &str = "error,ambidex=info";

/// Width where there is no terminal to ask.
const WIDTH: usize = 100;

/// stderr as a person sees it.
#[derive(Debug, Clone)]
pub struct Terminal {
    display: ProgressBar,
    is_tty: bool,
    has_color: bool,
}

impl Terminal {
    /// Looks at stderr and sends log lines there, above the live display.
    ///
    /// `filter` says which are shown where `RUST_LOG` does not.
    pub fn start(format: LogFormat, filter: &str) -> Self {
        let has_color = anstream::AutoStream::choice(&io::stderr()) != anstream::ColorChoice::Never;
        let style = ProgressStyle::with_template("{msg}").expect("a fixed template is sound");
        let display = ProgressBar::no_length().with_style(style);
        display.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
        let terminal = Self { display, is_tty: io::stderr().is_terminal(), has_color };
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
            .with_ansi(has_color);
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
        self.has_color
    }

    /// Columns.
    pub fn width(&self) -> usize {
        let size = rustix::termios::tcgetwinsize(io::stderr()).ok();
        size.map(|size| usize::from(size.ws_col)).filter(|&columns| columns > 0).unwrap_or(WIDTH)
    }

    /// Colors, if they are wanted.
    pub fn palette(&self) -> Palette {
        if self.has_color { Palette::ansi() } else { Palette::plain() }
    }

    /// Prints a text above the live display.
    pub fn say(&self, text: &str) {
        // Whoever read stderr may be gone; the run is not.
        self.display.suspend(|| drop(writeln!(io::stderr(), "{text}")));
    }

    /// Shows these lines in the live display.
    pub fn show(&self, lines: &[String]) {
        self.display.set_message(lines.join("\n"));
    }

    /// Takes the live display away.
    pub fn clear(&self) {
        self.display.finish_and_clear();
    }
}

/// Writes log lines above the live display.
#[derive(Debug, Clone)]
struct Above(ProgressBar);

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
