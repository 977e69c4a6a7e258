//! What reading needs beside the file: where faults go, and what terms of a behavior can name.

use std::collections::BTreeSet;

use crate::fault::Faults;
use crate::reader::Name;
use crate::types::Type;
use ambidex_model::suggestion;

/// Reading of a file.
pub(crate) struct Reading<'f> {
    pub(crate) faults: &'f mut Faults,
    /// Of the behavior at hand; empty outside of one.
    pub(crate) scope: Scope,
}

/// What the terms of a behavior can name beside what is in the world.
#[derive(Debug, Default)]
pub(crate) struct Scope {
    /// Its parameters by name.
    pub(crate) parameters: Vec<(String, Type)>,
    /// Which of them some term uses.
    pub(crate) used: BTreeSet<usize>,
    /// The names of its claims, in their order.
    pub(crate) claims: Vec<Name>,
}

impl<'f> Reading<'f> {
    /// Reading outside of behaviors.
    pub(crate) fn new(faults: &'f mut Faults) -> Self {
        Self { faults, scope: Scope::default() }
    }

    /// The parameter of a name, which is then used; a fault if there is none.
    pub(crate) fn parameter(&mut self, name: &str, at: &Name) -> Option<usize> {
        let names = || self.scope.parameters.iter().map(|(name, _)| name.as_str());
        let found = names().position(|known| known == name);
        if found.is_none() {
            let help = || suggestion(name, "parameter", names());
            self.faults.push_with(at, format!("there is no parameter `{name}`"), help);
        }
        self.scope.used.extend(found);
        found
    }
}
