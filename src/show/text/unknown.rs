//! What a person asked for and a log does not have.

use ambidex_model::{make_legible, suggestion};
use glob::Pattern;

/// A name or a round that nothing in the log has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Unknown {
    message: String,
    help: String,
}

impl Unknown {
    /// The thing's noun, the name, and the names there are.
    pub(crate) fn new(what: &str, found: &str, allowed: &[String]) -> Self {
        let names = allowed.iter().map(String::as_str);
        Self::told(format!("there is no {what} `{found}`"), suggestion(found, what, names))
    }

    /// What is not there, and what is.
    pub(crate) fn told(mut message: String, mut help: String) -> Self {
        [&mut message, &mut help].into_iter().for_each(make_legible);
        Self { message, help }
    }

    /// What was probably meant, and what is allowed.
    pub fn help(&self) -> &str {
        &self.help
    }
}

/// Names that a pattern matches; one that is a name matches that alone.
#[derive(Debug, Clone)]
pub(crate) struct Wanted {
    pattern: String,
    glob: Option<Pattern>,
}

impl Wanted {
    /// A pattern that must match one of the names that there are, unless others may come.
    pub(crate) fn new<'a>(
        what: &str,
        pattern: &str,
        names: impl Iterator<Item = &'a String> + Clone,
        may_come: bool,
    ) -> Result<Self, Unknown> {
        let is_name = names.clone().any(|name| name == pattern);
        let wanted = Self { pattern: pattern.to_owned(), glob: Pattern::new(pattern).ok().filter(|_| !is_name) };
        match may_come || names.clone().any(|name| wanted.matches(name)) {
            true => Ok(wanted),
            false => Err(Unknown::new(what, pattern, &names.cloned().collect::<Vec<_>>())),
        }
    }

    /// Whether it matches a name.
    pub(crate) fn matches(&self, name: &str) -> bool {
        name == self.pattern || self.glob.as_ref().is_some_and(|glob| glob.matches(name))
    }

    /// As it was written.
    pub(crate) fn pattern(&self) -> &str {
        &self.pattern
    }
}
