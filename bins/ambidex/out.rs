//! What a verb writes into a file, or on stdout for `-`.

use std::path::Path;

use ambidex::record::shown;
use miette::{Context, IntoDiagnostic, Result, miette};

use crate::page::Page;

/// Writes to a file, or to stdout for `-`.
///
/// # Errors
/// When the file cannot be written.
pub fn write(to: &Path, text: &str) -> Result<()> {
    if to == Path::new("-") {
        return Page::new().text(text).map(drop);
    }
    std::fs::write(to, text).into_diagnostic().wrap_err_with(|| format!("cannot write {}", shown(to)))
}

/// Refuses to write over what is read.
///
/// # Errors
/// When both are the same file.
pub fn spare(input: &Path, output: Option<&Path>) -> Result<()> {
    let same = |output: &Path| input.canonicalize().ok().is_some_and(|input| output.canonicalize().ok() == Some(input));
    match output.filter(|output| same(output)) {
        Some(output) => Err(miette!("{} would be written over with its own picture", shown(output))),
        None => Ok(()),
    }
}
