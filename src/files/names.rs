//! Looking names up: every use of a name that nothing has is a fault with what is allowed.

use std::collections::BTreeMap;

use crate::fault::Faults;
use crate::reader::Name;
use crate::template::{Piece, pieces};
use ambidex_model::{nearest, suggestion};

/// What nothing can be called: `$` and a name stand for an argument wherever the thing is named.
pub(crate) fn refuse_argument(name: &Name, faults: &mut Faults) {
    let found = pieces(&name.value).into_iter().find_map(|piece| match piece {
        Piece::Parameter(name) => Some(name),
        Piece::Plain(_) => None,
    });
    if let Some(argument) = found {
        let help = "a name of yours has no `$` before a letter, a digit or `_`";
        faults.push_with(name, format!("`${argument}` stands for an argument, and there is none here"), help);
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

    /// What could be meant by a name that nothing has; none where nothing is near.
    pub(crate) fn meant(&self, name: &str) -> Option<String> {
        nearest(name, self.names.iter().map(String::as_str)).map(|near| format!("did you mean `{near}`?"))
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
        suggestion(name, self.what, self.names.iter().map(String::as_str))
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
