//! The terminal: colors, size, log lines, and lines that are drawn again in place, which log lines do not break.
//!
//! A thread of its own writes what is said on stderr: whoever does not read it, holds up nobody else.

use std::io::{self, IsTerminal, Write};
use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::thread;
use std::time::{Duration, Instant};

use ambidex::show::Palette;
use anstream::stream::RawStream;
use anstream::{AutoStream, ColorChoice};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

use crate::values::LogFormat;

/// Log lines that nothing else says: a run tells of its mission itself.
pub const QUIET: &str = "error,ambidex::mission=off";
/// Log lines of a controller that somebody started by hand.
pub const TALKING: &str = "error,ambidex=info";

/// Columns where there is no terminal to ask.
pub const WIDTH: usize = 100;

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

    /// Takes the lines away for a moment.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.0.suspend(print)
    }

    /// Takes the lines away.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }
}

/// How far long work is, where somebody looks.
#[derive(Debug)]
pub struct Progress(ProgressBar);

impl Progress {
    /// Work in so many parts of a kind.
    pub fn new(of: u64, parts: &str, is_quiet: bool) -> Self {
        let target = if is_quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(10) };
        let template = format!("  {{wide_bar}} {{pos}} of {{len}} {parts}, {{eta}} left");
        let style = ProgressStyle::with_template(&template).expect("a fixed template is sound");
        Self(ProgressBar::with_draw_target(Some(of), target).with_style(style.progress_chars("━━─")))
    }

    /// One more part is done.
    pub fn one_more(&self) {
        self.0.inc(1);
    }

    /// Says something above it.
    pub fn say(&self, text: &str) {
        self.0.suspend(|| anstream::eprintln!("{text}"));
    }

    /// Takes it away.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }
}

/// What may wait to be written; what is said beyond that is dropped, and counted.
const WAITING_MAX: usize = 4096;
/// How often it is tried to hand over the last word.
const FINISH_POLL: Duration = Duration::from_millis(5);

/// What becomes of text that nobody reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Patience {
    /// It is dropped: a robot waits for nobody.
    Drops,
    /// It is waited for: nothing moves meanwhile.
    Waits,
}

/// stderr as a person sees it.
#[derive(Debug, Clone)]
pub struct Terminal {
    to: SyncSender<Said>,
    dropped: Arc<AtomicU64>,
    patience: Patience,
    is_tty: bool,
    palette: Palette,
}

/// What goes to the thread that writes.
#[derive(Debug)]
enum Said {
    /// Above the live display.
    Text(Vec<u8>),
    /// The live display.
    Rows(Vec<String>),
    Clear,
    /// Everything before this is written.
    Finish(SyncSender<()>),
}

impl Terminal {
    /// Looks at stderr and sends log lines there, above the live display.
    ///
    /// `filter` says which are shown where `RUST_LOG` does not.
    pub fn start(format: LogFormat, filter: &str, patience: Patience) -> Self {
        let (stderr, display) = (io::stderr(), Display::new(ProgressDrawTarget::stderr_with_hz(10)));
        let (to, from) = mpsc::sync_channel(WAITING_MAX);
        let dropped = Arc::new(AtomicU64::new(0));
        let terminal = Self {
            to,
            dropped: Arc::clone(&dropped),
            patience,
            is_tty: stderr.is_terminal(),
            palette: palette(&stderr),
        };
        let talk = move || write_all_said(&from, &display, &dropped);
        thread::Builder::new().name("talk".into()).spawn(talk).expect("the system gives a thread");
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
            .with_writer(Above(terminal.clone()))
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
        self.send(Said::Text(format!("{text}\n").into_bytes()));
    }

    /// Shows these lines in the live display.
    pub fn show(&self, lines: Vec<String>) {
        self.send(Said::Rows(lines));
    }

    /// Takes the live display away.
    pub fn clear(&self) {
        self.send(Said::Clear);
    }

    /// Waits until everything is written; where a robot waits for nobody, no longer than that. False if it is not.
    pub fn finish(&self, within: Duration) -> bool {
        let (written, is_written) = mpsc::sync_channel(1);
        let mut last = Said::Finish(written);
        if self.patience == Patience::Waits {
            return self.to.send(last).is_ok() && is_written.recv().is_ok();
        }
        let by = Instant::now() + within;
        loop {
            match self.to.try_send(last) {
                Ok(()) => return is_written.recv_timeout(by.saturating_duration_since(Instant::now())).is_ok(),
                Err(TrySendError::Full(back)) if Instant::now() < by => last = back,
                Err(_) => return false,
            }
            thread::sleep(FINISH_POLL);
        }
    }

    fn send(&self, said: Said) {
        match self.patience {
            // The thread lives as long as the process.
            Patience::Waits => drop(self.to.send(said)),
            Patience::Drops => {
                if let Err(TrySendError::Full(Said::Text(_))) = self.to.try_send(said) {
                    self.dropped.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }
}

/// The thread that writes on stderr; it may wait for a reader for ever.
fn write_all_said(from: &Receiver<Said>, display: &Display, dropped: &AtomicU64) {
    for said in from {
        match said {
            // Whoever read stderr may be gone; the run is not.
            Said::Text(text) => display.suspend(|| drop(io::stderr().write_all(&text))),
            Said::Rows(rows) => display.show(rows),
            Said::Clear => display.clear(),
            Said::Finish(written) => drop(written.try_send(())),
        }
        let missing = dropped.swap(0, Ordering::Relaxed);
        if missing > 0 {
            tracing::error!(missing, "messages are missing here: nobody read them");
        }
    }
}

/// Writes log lines above the live display.
#[derive(Debug, Clone)]
struct Above(Terminal);

impl Write for Above {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.send(Said::Text(bytes.to_vec()));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl MakeWriter<'_> for Above {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}
