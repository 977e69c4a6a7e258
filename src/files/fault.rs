//! Mistakes in files: each with file, line, key, what was found and what is allowed; all of them at once.

use std::collections::BTreeSet;
use std::fmt;
use std::mem;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, Severity, SourceCode};

use super::document::Spot;
use super::reader::shortened;
use super::source::Source;

/// More mistakes than a person reads at once; further ones are only counted.
const MAX_FAULTS: usize = 100;

/// Why files make no mission: every mistake that was found.
#[derive(Debug, Clone)]
pub struct ConfigError {
    faults: Vec<Fault>,
    uncounted: usize,
}

/// One mistake, or what is legal but surely not meant.
#[derive(Debug, Clone)]
pub struct Fault {
    source: Arc<Source>,
    spot: Spot,
    severity: Severity,
    key: String,
    message: String,
    help: Option<String>,
}

impl ConfigError {
    /// The error as it is shown: a single mistake speaks for itself.
    pub fn into_report(mut self) -> miette::Report {
        match self.faults.pop() {
            Some(only) if self.faults.is_empty() => only.into(),
            last => {
                self.faults.extend(last);
                self.into()
            }
        }
    }

    /// The mistakes, file by file in the order of the lines.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }
}

impl Fault {
    /// The file.
    pub fn file(&self) -> &str {
        self.source.name()
    }

    /// Line and column, counted from 1; none when the file could not be read at all.
    pub fn position(&self) -> Option<(usize, usize)> {
        (self.spot.line > 0).then_some((self.spot.line, self.spot.column))
    }

    /// The key whose value is wrong; empty for the file as a whole.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// What was found.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What is allowed, or what to do.
    pub fn help(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// Whether the file can be used all the same.
    pub fn is_warning(&self) -> bool {
        self.severity == Severity::Warning
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let warnings = self.faults.iter().filter(|fault| fault.is_warning()).count();
        match self.faults.len() - warnings + self.uncounted {
            1 => f.write_str("one mistake in the files")?,
            count => write!(f, "{count} mistakes in the files")?,
        }
        match warnings {
            0 => Ok(()),
            1 => f.write_str(", and a warning"),
            count => write!(f, ", and {count} warnings"),
        }
    }
}

impl std::error::Error for ConfigError {}

impl Diagnostic for ConfigError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        (self.uncounted > 0).then(|| Box::new(format!("{} more are not shown", self.uncounted)) as Box<_>)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.faults.iter().map(|fault| fault as &dyn Diagnostic)))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.key.is_empty() {
            write!(f, "{}: ", shortened(&self.key))?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}

impl Diagnostic for Fault {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        (self.spot.line > 0).then_some(&*self.source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let Spot { offset, length, line, .. } = self.spot;
        let label = LabeledSpan::new(Some("here".to_owned()), offset, length.max(1));
        (line > 0).then(|| Box::new(std::iter::once(label)) as Box<_>)
    }
}

/// The mistakes found so far in all files.
#[derive(Debug, Default)]
pub(super) struct Faults {
    sources: Vec<Arc<Source>>,
    list: Vec<Fault>,
    known: BTreeSet<(usize, usize, String)>,
    errors: usize,
    uncounted: usize,
}

impl Faults {
    /// A further file with this text; its number is for the spots in it.
    pub(super) fn open(&mut self, name: &str, text: String) -> usize {
        self.sources.push(Arc::new(Source::new(name, &text)));
        self.sources.len() - 1
    }

    /// Mistakes so far that make a file useless.
    pub(super) fn errors(&self) -> usize {
        self.errors
    }

    /// Adds one at a place in a file; `help` says what is allowed.
    pub(super) fn push(&mut self, spot: Spot, key: &str, message: String, help: Option<String>) {
        self.add(Severity::Error, spot, key, message, help);
    }

    /// Adds what is legal but surely not meant.
    pub(super) fn warn(&mut self, spot: Spot, key: &str, message: String, help: Option<String>) {
        self.add(Severity::Warning, spot, key, message, help);
    }

    fn add(&mut self, severity: Severity, spot: Spot, key: &str, message: String, help: Option<String>) {
        // What is used twice is wrong once.
        if !self.known.insert((spot.file, spot.offset, message.clone())) {
            return;
        }
        self.errors += usize::from(severity == Severity::Error);
        if self.list.len() >= MAX_FAULTS {
            self.uncounted += 1;
            return;
        }
        let source = Arc::clone(&self.sources[spot.file]);
        self.list.push(Fault { source, spot, severity, key: key.to_owned(), message, help });
    }

    /// All of them, file by file in the order of the lines.
    pub(super) fn take(&mut self) -> Vec<Fault> {
        self.list.sort_by_key(|fault| (fault.spot.file, fault.spot.offset));
        mem::take(&mut self.list)
    }

    /// What was built and the warnings beside it.
    ///
    /// # Errors
    /// Everything that was found, if any of it is a mistake.
    pub(super) fn into_result<T>(mut self, built: Option<T>) -> Result<(T, Vec<Fault>), ConfigError> {
        let faults = self.take();
        match built {
            Some(built) if self.errors == 0 => Ok((built, faults)),
            // Nothing was built and nothing says why: never a reason to panic over a file.
            Some(_) | None => {
                Err(ConfigError { uncounted: self.uncounted.max(usize::from(faults.is_empty())), faults })
            }
        }
    }
}
