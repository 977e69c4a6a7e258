//! What a verb gives: on stdout as data, or in a file; stderr talks.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use ambidex::draw::Palette;
use miette::{Context, IntoDiagnostic, Result};

/// Width where stdout is no terminal.
const WIDTH: usize = 100;

/// Writes to a file, or to stdout for `-`.
pub fn write(to: &Path, text: &str) -> Result<()> {
    if to == Path::new("-") {
        return print(text);
    }
    std::fs::write(to, text).into_diagnostic().wrap_err_with(|| format!("cannot write {}", to.display()))
}

/// Prints on stdout. Whoever read it may be gone, as `head` when it has enough: that is no fault.
pub fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        done => done.into_diagnostic().wrap_err("cannot write to stdout"),
    }
}

/// Says a line on stderr.
pub fn say(line: &str) {
    drop(writeln!(io::stderr(), "{line}"));
}

/// Columns of stdout.
pub fn width() -> usize {
    let size = rustix::termios::tcgetwinsize(io::stdout()).ok();
    size.map(|size| usize::from(size.ws_col)).filter(|&columns| columns > 0).unwrap_or(WIDTH)
}

/// Colors, if they are wanted on stdout.
pub fn palette() -> Palette {
    match anstream::AutoStream::choice(&io::stdout()) {
        anstream::ColorChoice::Never => Palette::plain(),
        anstream::ColorChoice::Auto | anstream::ColorChoice::Always | anstream::ColorChoice::AlwaysAnsi => {
            Palette::ansi()
        }
    }
}

/// Refuses to write over what is read.
///
/// # Errors
/// When both are the same file.
pub fn spare(input: &Path, output: Option<&Path>) -> Result<()> {
    let same = |output: &Path| input.canonicalize().ok().is_some_and(|input| output.canonicalize().ok() == Some(input));
    match output.filter(|output| same(output)) {
        Some(output) => Err(miette::miette!("{} would be written over with its own picture", output.display())),
        None => Ok(()),
    }
}
