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

/// Which names a pattern matches; one that is a name matches that alone.
pub(crate) fn matching(what: &str, pattern: &str, names: &[String]) -> Result<Vec<bool>, Unknown> {
    let is_name = names.iter().any(|name| name == pattern);
    let glob = Pattern::new(pattern).ok().filter(|_| !is_name);
    let is_match = |name: &String| name == pattern || glob.as_ref().is_some_and(|glob| glob.matches(name));
    let matches: Vec<bool> = names.iter().map(is_match).collect();
    if !matches.contains(&true) {
        return Err(Unknown::new(what, pattern, names));
    }
    Ok(matches)
}
