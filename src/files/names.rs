//! Looking names up: every use of a name that nothing has is a fault with what is allowed.

use std::collections::BTreeMap;

use crate::fault::Faults;
use crate::reader::Name;
use ambidex_model::suggestion;

/// The names of one kind of thing, by id.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Register {
    what: &'static str,
    names: Vec<String>,
    ids: BTreeMap<String, usize>,
}

impl Register {
    /// None yet; `what` is the thing's noun.
    pub(crate) fn new(what: &'static str) -> Self {
        Self { what, ..Self::default() }
    }

    /// Those names, in this order.
    pub(crate) fn of<'a>(what: &'static str, names: impl IntoIterator<Item = &'a str>) -> Self {
        let mut register = Self::new(what);
        for name in names {
            register.intern(name);
        }
        register
    }

    /// The names of a map's entries, whatever they name.
    pub(crate) fn of_entries<T>(what: &'static str, entries: &[(Name, T)]) -> Self {
        Self::of(what, entries.iter().map(|(name, _)| name.value.as_str()))
    }

    /// The id of a name, a new one if it is new.
    pub(crate) fn intern(&mut self, name: &str) -> usize {
        if let Some(&id) = self.ids.get(name) {
            return id;
        }
        let id = self.names.len();
        self.names.push(name.to_owned());
        self.ids.insert(name.to_owned(), id);
        id
    }

    /// The id of a name, if there is such a thing.
    pub(crate) fn id(&self, name: &str) -> Option<usize> {
        self.ids.get(name).copied()
    }

    /// The id of a name as written in a file; a fault if nothing has it.
    pub(crate) fn find(&self, name: &Name, faults: &mut Faults) -> Option<usize> {
        let found = self.id(&name.value);
        if found.is_none() {
            let message = format!("there is no {} `{}`", self.what, name.value);
            let allowed = self.names.iter().map(String::as_str);
            faults.push_with(name, message, suggestion(&name.value, self.what, allowed));
        }
        found
    }

    /// The name behind an id; `?` for an id that is not of this register.
    pub(crate) fn name(&self, id: usize) -> &str {
        self.names.get(id).map_or("?", String::as_str)
    }

    /// All names by id.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// All names by id.
    pub(crate) fn into_names(self) -> Vec<String> {
        self.names
    }
}
