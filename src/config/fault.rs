//! Mistakes in files: each with file, line, key, what was found and what is allowed; all of them at once.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};

use super::document::Spot;

/// More mistakes than a person reads at once; further ones are only counted.
const MAX_FAULTS: usize = 100;

/// Why files make no mission: every mistake that was found.
#[derive(Debug, Clone)]
pub struct ConfigError {
    faults: Vec<Fault>,
    uncounted: usize,
}

/// One mistake.
#[derive(Debug, Clone)]
pub struct Fault {
    source: Arc<NamedSource<String>>,
    spot: Option<Spot>,
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

    /// Nothing was built and nothing says why: never a reason to panic over a file.
    pub(super) fn unexplained() -> Self {
        Self { faults: Vec::new(), uncounted: 1 }
    }
}

impl Fault {
    /// The file.
    pub fn file(&self) -> &str {
        self.source.name()
    }

    /// Line and column, counted from 1; none when the file could not be read at all.
    pub fn position(&self) -> Option<(usize, usize)> {
        self.spot.filter(|spot| spot.line > 0).map(|spot| (spot.line, spot.column))
    }

    /// The key whose value is wrong; empty for the file as a whole.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// What was found.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.faults.len() + self.uncounted {
            1 => f.write_str("one mistake in the files"),
            count => write!(f, "{count} mistakes in the files"),
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
            write!(f, "{}: ", self.key)?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}

impl Diagnostic for Fault {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.spot.map(|_| &*self.source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let spot = self.spot?;
        let label = LabeledSpan::new(Some("here".to_owned()), spot.offset, spot.length.max(1));
        Some(Box::new(std::iter::once(label)))
    }
}

/// The mistakes found so far in one file.
#[derive(Debug)]
pub(super) struct Faults {
    source: Arc<NamedSource<String>>,
    list: Vec<Fault>,
    uncounted: usize,
}

impl Faults {
    /// None yet, in a file with this text.
    pub(super) fn new(file: &Path, text: String) -> Self {
        Self { source: Arc::new(NamedSource::new(file.display().to_string(), text)), list: Vec::new(), uncounted: 0 }
    }

    /// Whether the file is free of mistakes so far.
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Adds one at a place in the file; `help` says what is allowed.
    pub(super) fn push(&mut self, spot: Spot, key: &str, message: String, help: Option<String>) {
        self.add(Some(spot), key, message, help);
    }

    /// Adds one about the file as a whole.
    pub(super) fn push_whole(&mut self, message: String) {
        self.add(None, "", message, None);
    }

    fn add(&mut self, spot: Option<Spot>, key: &str, message: String, help: Option<String>) {
        if self.list.len() >= MAX_FAULTS {
            self.uncounted += 1;
            return;
        }
        self.list.push(Fault { source: Arc::clone(&self.source), spot, key: key.to_owned(), message, help });
    }

    /// All mistakes of several files as one error; none if there are none.
    pub(super) fn into_error(files: impl IntoIterator<Item = Self>) -> Option<ConfigError> {
        let mut error = ConfigError { faults: Vec::new(), uncounted: 0 };
        for mut file in files {
            file.list.sort_by_key(|fault| fault.spot.map_or(0, |spot| spot.offset));
            error.faults.extend(file.list);
            error.uncounted += file.uncounted;
        }
        (!error.faults.is_empty()).then_some(error)
    }
}

/// What is allowed instead of a word, the nearest first.
pub(super) fn suggestion<'a>(found: &str, what: &str, allowed: impl IntoIterator<Item = &'a str>) -> String {
    const MAX_LISTED: usize = 12;
    let allowed: Vec<&str> = allowed.into_iter().collect();
    if allowed.is_empty() {
        return format!("there is no {what} at all");
    }
    let distance = |word: &&&str| strsim::osa_distance(&found.to_lowercase(), &word.to_lowercase());
    let nearest =
        allowed.iter().min_by_key(distance).filter(|word| distance(word) <= (found.chars().count() / 3).clamp(1, 3));
    let listed = allowed.iter().take(MAX_LISTED).map(|word| format!("`{word}`"));
    let mut listed = listed.collect::<Vec<_>>().join(", ");
    if allowed.len() > MAX_LISTED {
        listed += &format!(" and {} more", allowed.len() - MAX_LISTED);
    }
    match nearest {
        Some(word) => format!("did you mean `{word}`? Allowed: {listed}"),
        None => format!("allowed: {listed}"),
    }
}
