//! The whole terminal for a page that is drawn again in place: another screen, no echo, keys as they are pressed. It is
//! given back however the program leaves, a panic included.

use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;

use ambidex::link::Stop;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcsetattr};

use crate::terminal;

const ENTER: &str = "\x1b[?1049h\x1b[?25l\x1b[2J";
const LEAVE: &str = "\x1b[?25h\x1b[?1049l";
/// Ctrl-C where the terminal makes no signal of it.
const CTRL_C: u8 = 3;

/// How the terminal was before; none while nobody has taken it.
static BEFORE: Mutex<Option<Before>> = Mutex::new(None);
static GIVES_BACK_ON_PANIC: Once = Once::new();

struct Before(Option<Termios>);

/// What somebody at the terminal wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// To see more.
    Stay,
    /// To be done with it: `q`.
    Leave,
    /// To end the program: Ctrl-C, or a signal.
    Stop,
}

/// The terminal while it shows a page.
#[derive(Debug)]
pub struct Screen {
    shown: (Option<(usize, usize)>, Vec<String>),
    has_keys: bool,
}

impl Screen {
    /// Takes the terminal behind stdout; none where there is none.
    ///
    /// # Errors
    /// When it does not obey.
    pub fn take() -> io::Result<Option<Self>> {
        if !io::stdout().is_terminal() {
            return Ok(None);
        }
        GIVES_BACK_ON_PANIC.call_once(|| {
            let tell = std::panic::take_hook();
            std::panic::set_hook(Box::new(move |panic| {
                give_back();
                tell(panic);
            }));
        });
        let keys = io::stdin().is_terminal().then(|| tcgetattr(io::stdin())).transpose()?;
        *BEFORE.lock().unwrap_or_else(PoisonError::into_inner) = Some(Before(keys.clone()));
        let screen = Self { shown: (None, Vec::new()), has_keys: keys.is_some() };
        if let Some(mut keys) = keys {
            keys.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG);
            tcsetattr(io::stdin(), OptionalActions::Flush, &keys)?;
        }
        write(ENTER)?;
        Ok(Some(screen))
    }

    /// Draws these lines over what was drawn last, if anything is different.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn show(&mut self, lines: Vec<String>) -> io::Result<()> {
        let page = (terminal::size(io::stdout()), lines);
        if page == self.shown {
            return Ok(());
        }
        let lines: Vec<String> = page.1.iter().map(|line| format!("\x1b[2K{line}")).collect();
        write(&format!("\x1b[H{}\r\n\x1b[J", lines.join("\r\n")))?;
        self.shown = page;
        Ok(())
    }

    /// What is wished within a time.
    ///
    /// # Errors
    /// When the terminal is gone.
    pub fn wish(&mut self, stop: &Stop, within: Duration) -> io::Result<Wish> {
        let timeout = Timespec::try_from(within).map_err(io::Error::other)?;
        let stdin = io::stdin();
        let mut sources = vec![PollFd::new(stop, PollFlags::IN)];
        sources.extend(self.has_keys.then(|| PollFd::new(&stdin, PollFlags::IN)));
        match poll(&mut sources, Some(&timeout)) {
            Ok(0) | Err(rustix::io::Errno::INTR) => return Ok(Wish::Stay),
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        let [is_stopped, is_typed] =
            [0, 1].map(|source| sources.get(source).is_some_and(|fd| !fd.revents().is_empty()));
        match (is_stopped, is_typed) {
            (true, _) => Ok(Wish::Stop),
            (false, true) => self.key(),
            (false, false) => Ok(Wish::Stay),
        }
    }

    fn key(&mut self) -> io::Result<Wish> {
        let mut keys = [0; 64];
        let count = rustix::io::read(io::stdin(), &mut keys)?;
        // A keyboard that is gone presses nothing any more.
        self.has_keys = count > 0;
        let wish = keys[..count].iter().find_map(|key| match *key {
            b'q' | b'Q' => Some(Wish::Leave),
            CTRL_C => Some(Wish::Stop),
            _ => None,
        });
        Ok(wish.unwrap_or(Wish::Stay))
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
    }
}

/// Makes the terminal what it was before it was taken.
fn give_back() {
    if let Some(Before(keys)) = BEFORE.lock().unwrap_or_else(PoisonError::into_inner).take() {
        drop(write(LEAVE));
        if let Some(keys) = keys {
            let _ = tcsetattr(io::stdin(), OptionalActions::Flush, &keys);
        }
    }
}

fn write(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush())
}
