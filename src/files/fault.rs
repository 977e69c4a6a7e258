//! Mistakes in files as plain data: each with file, place, key, what was found and what is allowed; all of them at once.

use std::collections::BTreeSet;
use std::fmt;
use std::mem;
use std::ops::Range;
use std::sync::Arc;

use crate::document::SourceSpan;
use crate::text::shortened;
use ambidex_model::make_legible;

/// More mistakes than a person reads at once; further ones are only counted.
const MAX_FAULTS: usize = 100;

/// Mistakes for which a look is taken at all names that could be meant: one is not cheap.
const MAX_SUGGESTED: usize = 30;

/// Why files make no mission: every mistake that was found.
#[derive(Debug, Clone)]
pub struct FilesError {
    faults: Vec<Fault>,
    uncounted: usize,
}

/// One mistake, or what is legal but surely not meant.
#[derive(Debug, Clone)]
pub struct Fault {
    source: Arc<Source>,
    span: SourceSpan,
    severity: Severity,
    key: String,
    message: String,
    help: Option<String>,
}

/// Whether a file can be used all the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// It cannot be used.
    Error,
    /// It can, but this is surely not what its writer meant.
    Warning,
}

/// A file that was opened.
#[derive(Debug)]
pub(crate) struct Source {
    name: String,
    pub(crate) text: String,
}

impl FilesError {
    /// The mistakes and warnings, file by file in the order of the lines.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// How many further ones were found than [`Self::faults`] has room for.
    pub fn uncounted(&self) -> usize {
        self.uncounted
    }
}

impl Fault {
    /// The path of the file as it was opened, without what a terminal obeys; of a value from elsewhere where that is.
    pub fn file(&self) -> &str {
        &self.source.name
    }

    /// The whole text of the file; empty when it could not be read.
    pub fn text(&self) -> &str {
        &self.source.text
    }

    /// Line and column, counted from 1; none when the file could not be read at all.
    pub fn position(&self) -> Option<(usize, usize)> {
        (self.span.line > 0).then_some((self.span.line, self.span.column))
    }

    /// The bytes of the text that are meant; none when the file could not be read at all.
    pub fn bytes(&self) -> Option<Range<usize>> {
        (self.span.line > 0).then_some(self.span.offset..self.span.offset + self.span.length)
    }

    /// The key whose value is wrong; empty for the file as a whole.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// What was found, without key and place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What is allowed, or what to do about it.
    pub fn help(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// Whether the file can be used all the same.
    pub fn severity(&self) -> Severity {
        self.severity
    }

    /// Whether it is no mistake but a warning.
    pub fn is_warning(&self) -> bool {
        self.severity == Severity::Warning
    }
}

impl fmt::Display for FilesError {
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

impl std::error::Error for FilesError {}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.key.is_empty() {
            write!(f, "{}: ", shortened(&self.key))?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}

/// Where a mistake is: a place, and the key that stands there or above it.
pub(crate) struct At<'k> {
    span: SourceSpan,
    key: &'k str,
}

impl<'k> From<(SourceSpan, &'k str)> for At<'k> {
    fn from((span, key): (SourceSpan, &'k str)) -> Self {
        Self { span, key }
    }
}

impl<'k> From<(SourceSpan, &'k String)> for At<'k> {
    fn from((span, key): (SourceSpan, &'k String)) -> Self {
        Self { span, key }
    }
}

/// What is allowed, or what to do: words, or what makes them after a look at all names that could be meant.
pub(crate) trait Help {
    /// The words; none where names could be meant and nobody looks.
    fn text(self, is_suggested: bool) -> Option<String>;
}

impl Help for &str {
    fn text(self, _: bool) -> Option<String> {
        Some(self.to_owned())
    }
}

impl Help for String {
    fn text(self, _: bool) -> Option<String> {
        Some(self)
    }
}

impl<F: FnOnce() -> String> Help for F {
    fn text(self, is_suggested: bool) -> Option<String> {
        is_suggested.then(self)
    }
}

/// The mistakes found so far in all files.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    sources: Vec<Arc<Source>>,
    list: Vec<Fault>,
    known: BTreeSet<(usize, usize, String)>,
    errors: usize,
    uncounted: usize,
}

impl Faults {
    /// None yet in files some of which were opened before, so that places in them mean the same.
    pub(crate) fn after(opened: &[Arc<Source>]) -> Self {
        Self { sources: opened.to_vec(), ..Self::default() }
    }

    /// The files that were opened so far, by number.
    pub(crate) fn opened(&self) -> &[Arc<Source>] {
        &self.sources
    }

    /// A further file with this text; its number is for the places in it.
    pub(crate) fn open(&mut self, name: &str, text: String) -> usize {
        let mut name = name.to_owned();
        make_legible(&mut name);
        self.sources.push(Arc::new(Source { name, text }));
        self.sources.len() - 1
    }

    /// Mistakes so far that make a file useless, each as often as somebody came upon it.
    pub(crate) fn errors(&self) -> usize {
        self.errors
    }

    /// Adds a mistake at a place in a file.
    pub(crate) fn push<'k>(&mut self, at: impl Into<At<'k>>, message: impl Into<String>) {
        self.push_or_with(at, message, None);
    }

    /// Adds a mistake and what is allowed, or what to do.
    pub(crate) fn push_with<'k>(&mut self, at: impl Into<At<'k>>, message: impl Into<String>, help: impl Help) {
        let is_suggested = self.list.len() < MAX_SUGGESTED;
        self.add(Severity::Error, at.into(), message.into(), || help.text(is_suggested));
    }

    /// Adds a mistake, and what to do if that is known.
    pub(crate) fn push_or_with<'k>(&mut self, at: impl Into<At<'k>>, message: impl Into<String>, help: Option<String>) {
        self.add(Severity::Error, at.into(), message.into(), || help);
    }

    /// Adds what is legal but surely not meant.
    pub(crate) fn warn<'k>(&mut self, at: impl Into<At<'k>>, message: String, help: Option<String>) {
        self.add(Severity::Warning, at.into(), message, || help);
    }

    fn add(
        &mut self,
        severity: Severity,
        At { span, key }: At<'_>,
        message: String,
        help: impl FnOnce() -> Option<String>,
    ) {
        self.errors += usize::from(severity == Severity::Error);
        // What is used twice is told once.
        if !self.known.insert((span.file, span.offset, message.clone())) {
            return;
        }
        if self.list.len() >= MAX_FAULTS {
            self.uncounted += 1;
            return;
        }
        let legible = |mut text: String| {
            make_legible(&mut text);
            text
        };
        let (key, message, help) = (legible(key.to_owned()), legible(message), help().map(legible));
        let source = Arc::clone(&self.sources[span.file]);
        self.list.push(Fault { source, span, severity, key, message, help });
    }

    /// All of them, file by file in the order of the lines.
    pub(crate) fn take(&mut self) -> Vec<Fault> {
        self.list.sort_by_key(|fault| (fault.span.file, fault.span.offset));
        mem::take(&mut self.list)
    }

    /// What was built and the warnings beside it.
    ///
    /// # Errors
    /// Everything that was found, if any of it is a mistake.
    pub(crate) fn into_result<T>(mut self, built: Option<T>) -> Result<(T, Vec<Fault>), FilesError> {
        let faults = self.take();
        match built {
            Some(built) if self.errors == 0 => Ok((built, faults)),
            // Nothing was built and nothing says why: never a reason to panic over a file.
            Some(_) | None => Err(FilesError { uncounted: self.uncounted.max(usize::from(faults.is_empty())), faults }),
        }
    }
}
