//! What a verb writes into a file, or on stdout for `-`.

use std::fs::{File, Permissions};
use std::io::{self, BufWriter, StdoutLock, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use ambidex::record::shown;
use miette::{Context, IntoDiagnostic, Result, miette};
use tempfile::NamedTempFile;

use crate::page::{Page, is_read};

/// Writes to a file, or to stdout for `-`.
///
/// # Errors
/// When the file cannot be written.
pub fn write(to: &Path, text: &str) -> Result<()> {
    if to == Path::new("-") {
        return Page::new().text(text).map(drop);
    }
    std::fs::write(to, text).into_diagnostic().wrap_err_with(|| cannot_write(to))
}

/// Refuses to write over what is read.
///
/// # Errors
/// When both are the same file.
pub fn spare(input: &Path, output: Option<&Path>) -> Result<()> {
    let same = |output: &Path| input.canonicalize().ok().is_some_and(|input| output.canonicalize().ok() == Some(input));
    match output.filter(|output| same(output)) {
        Some(output) => Err(miette!("{} would be written over with what is made of it", shown(output))),
        None => Ok(()),
    }
}

/// What is written piece by piece: on stdout, or into a file that takes the place of what is there once all is written.
pub struct Output(Place);

enum Place {
    Stdout(BufWriter<StdoutLock<'static>>),
    /// A file beside the one that it is to replace.
    Beside {
        file: BufWriter<NamedTempFile>,
        to: PathBuf,
    },
    /// What is no file, such as a pipe, is not replaced.
    There {
        out: BufWriter<File>,
        to: PathBuf,
    },
}

impl Output {
    /// Stdout for `-`, and where nothing is named.
    ///
    /// # Errors
    /// When the file cannot be made.
    pub fn open(to: Option<&Path>) -> Result<Self> {
        let Some(to) = to.filter(|to| *to != Path::new("-")) else {
            return Ok(Self(Place::Stdout(BufWriter::with_capacity(1 << 16, io::stdout().lock()))));
        };
        // A link stays one: what it leads to is replaced.
        let to = to.canonicalize().unwrap_or_else(|_| to.to_owned());
        if to.metadata().is_ok_and(|there| !there.is_file()) {
            let file = File::options().write(true).open(&to).into_diagnostic().wrap_err_with(|| cannot_write(&to))?;
            return Ok(Self(Place::There { out: BufWriter::new(file), to }));
        }
        let folder = to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut beside = tempfile::Builder::new();
        beside.prefix(".ambidex-").permissions(Permissions::from_mode(0o666));
        match beside.tempfile_in(folder) {
            Ok(file) => Ok(Self(Place::Beside { file: BufWriter::new(file), to })),
            // The error names the file beside, which nobody has given a name.
            Err(error) if folder.is_dir() => Err(miette!("{}: {}", cannot_write(&to), error.kind())),
            Err(_) => Err(miette!("{}: there is no folder {}", cannot_write(&to), shown(folder))),
        }
    }

    /// Whether a file is written beside another.
    pub fn is_beside(&self) -> bool {
        matches!(self.0, Place::Beside { .. })
    }

    /// What is said where it takes nothing.
    pub fn complaint(&self) -> String {
        match &self.0 {
            Place::Stdout(_) => "cannot write to stdout".to_owned(),
            Place::Beside { to, .. } | Place::There { to, .. } => cannot_write(to),
        }
    }

    /// Hands on the last of it, and puts the file in its place.
    ///
    /// # Errors
    /// When it is not taken.
    pub fn commit(self) -> Result<()> {
        match self.0 {
            Place::Stdout(mut out) => is_read(out.flush()).map(drop),
            Place::There { mut out, .. } => out.flush().into_diagnostic(),
            Place::Beside { file, to } => {
                let file = file.into_inner().map_err(io::IntoInnerError::into_error).into_diagnostic()?;
                file.persist(&to).map(drop).map_err(|error| error.error).into_diagnostic()
            }
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.0 {
            Place::Stdout(out) => out.write(bytes),
            Place::Beside { file, .. } => file.write(bytes),
            Place::There { out, .. } => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.0 {
            Place::Stdout(out) => out.flush(),
            Place::Beside { file, .. } => file.flush(),
            Place::There { out, .. } => out.flush(),
        }
    }
}

fn cannot_write(to: &Path) -> String {
    format!("cannot write {}", shown(to))
}
