//! Looking names up: every use of a name that nothing has is a fault with what is allowed.

use std::collections::BTreeMap;

use crate::fault::Faults;
use crate::reader::Name;
use ambidex_model::{Misnamed, nearest, suggestion};

/// What nothing can be called: `$` and a name stand for an argument wherever the thing is named.
pub(crate) fn refuse_argument(name: &Name, faults: &mut Faults) {
    if let Some(misnamed) = Misnamed::by_arguments(&name.value) {
        faults.push_with(name, misnamed.to_string(), "a name of yours has no `$` before a letter, a digit or `_`");
    }
}

/// The names of one kind of thing, by id.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Register {
    what: &'static str,
    names: Vec<String>,
    ids: BTreeMap<String, usize>,
}

impl Register {
    /// None yet; `what` is the thing's noun.
    pub(crate) const fn new(what: &'static str) -> Self {
        Self { what, names: Vec::new(), ids: BTreeMap::new() }
    }

    /// Those names, in this order.
    pub(crate) fn of<'a>(what: &'static str, names: impl IntoIterator<Item = &'a str>) -> Self {
        let mut register = Self::new(what);
        for name in names {
            register.intern(name);
        }
        register
    }

    /// Names by id, empty where what was called so is gone.
    pub(crate) fn by_id(what: &'static str, names: &[String]) -> Self {
        let mut register = Self::new(what);
        names.iter().for_each(|name| register.add(name));
        register
    }

    /// A further name with the next id; empty where what was called so is gone.
    pub(crate) fn add(&mut self, name: &str) {
        if !name.is_empty() {
            self.ids.insert(name.to_owned(), self.names.len());
        }
        self.names.push(name.to_owned());
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
        self.add(name);
        self.names.len() - 1
    }

    /// The id of a name, if there is such a thing.
    pub(crate) fn id(&self, name: &str) -> Option<usize> {
        self.ids.get(name).copied()
    }

    /// What could be meant by a name that nothing has; none where nothing is near.
    pub(crate) fn meant(&self, name: &str) -> Option<String> {
        nearest(name, self.used()).map(|near| format!("did you mean `{near}`?"))
    }

    /// The id of a name as written in a file; a fault if nothing has it.
    pub(crate) fn find(&self, name: &Name, faults: &mut Faults) -> Option<usize> {
        let found = self.id(&name.value);
        if found.is_none() {
            faults.push_with(name, self.lacks(&name.value), || self.suggestion(&name.value));
        }
        found
    }

    /// That nothing has a name.
    pub(crate) fn lacks(&self, name: &str) -> String {
        format!("there is no {} `{name}`", self.what)
    }

    /// What was probably meant by a name that nothing has, and what is allowed.
    pub(crate) fn suggestion(&self, name: &str) -> String {
        suggestion(name, self.what, self.used())
    }

    /// Names of what is there.
    fn used(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str).filter(|name| !name.is_empty())
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
