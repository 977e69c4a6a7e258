//! What a person asked for and a log does not have.

use ambidex_model::suggestion;

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
        Self { message: format!("there is no {what} `{found}`"), help: suggestion(found, what, names) }
    }

    /// What is not there, and what is.
    pub(crate) fn told(message: String, help: String) -> Self {
        Self { message, help }
    }

    /// What was probably meant, and what is allowed.
    pub fn help(&self) -> &str {
        &self.help
    }
}
