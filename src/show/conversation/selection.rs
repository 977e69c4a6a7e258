//! Which records are wanted: filters by name, checked against what the journal has.

use std::ops::RangeInclusive;

use glob::Pattern;

use ambidex_model::{ControllerId, Header, Record, ResourceId, Time, suggestion};

use super::commands::Commands;
use super::{Kind, spoken};

/// Filters as a person gives them; what is left out selects all, what is given must all be so.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Filters {
    /// A pattern of node names: who sends, who gets it, or what is spoken of.
    pub node: Option<String>,
    /// A resource that is spoken of.
    pub resource: Option<String>,
    /// A controller that says it or is told.
    pub controller: Option<String>,
    /// Any of these kinds; empty for all.
    pub kinds: Vec<Kind>,
    /// Rounds; what has none belongs to the one that was decided last.
    pub rounds: Option<RangeInclusive<u32>>,
    /// Not before this moment.
    pub from: Option<Time>,
    /// Not after this moment.
    pub to: Option<Time>,
}

/// A name that nothing in the journal has.
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

/// Filters of one journal.
#[derive(Debug, Clone)]
pub struct Selection {
    nodes: Option<Vec<bool>>,
    resource: Option<ResourceId>,
    controller: Option<ControllerId>,
    rest: Filters,
}

impl Selection {
    /// Finds what the filters name.
    ///
    /// # Errors
    /// When no node, resource or controller is called so.
    pub fn new(filters: &Filters, header: &Header) -> Result<Self, Unknown> {
        let names = &header.names;
        let position = |what: &str, found: &Option<String>, names: &[String]| {
            let position = |found: &String| {
                names.iter().position(|name| name == found).ok_or_else(|| Unknown::new(what, found, names))
            };
            found.as_ref().map(position).transpose()
        };
        Ok(Self {
            nodes: filters.node.as_ref().map(|pattern| matching(pattern, &names.nodes)).transpose()?,
            resource: position("resource", &filters.resource, &names.resources)?.map(ResourceId::from),
            controller: position("controller", &filters.controller, &names.controllers)?.map(ControllerId::from),
            rest: filters.clone(),
        })
    }

    /// Whether a record is wanted; `round` is its own or the one that was decided last.
    pub(super) fn has(&self, record: &Record, round: u32, commands: &Commands) -> bool {
        let Filters { kinds, rounds, from, to, .. } = &self.rest;
        let at = record.at();
        (kinds.is_empty() || kinds.contains(&Kind::of(record)))
            && rounds.as_ref().is_none_or(|rounds| rounds.contains(&round))
            && from.is_none_or(|from| at >= from)
            && to.is_none_or(|to| at <= to)
            && self.resource.is_none_or(|resource| spoken::of_resource(record, resource))
            && self.controller.is_none_or(|controller| spoken::of_controller(record, controller))
            && self.nodes.as_ref().is_none_or(|marks| spoken::of_node(record, commands, marks))
    }
}

/// Which names a pattern matches; one that is a name matches that.
fn matching(pattern: &str, names: &[String]) -> Result<Vec<bool>, Unknown> {
    let glob = Pattern::new(pattern).ok();
    let is_match = |name: &String| name == pattern || glob.as_ref().is_some_and(|glob| glob.matches(name));
    let matches: Vec<bool> = names.iter().map(is_match).collect();
    if !matches.contains(&true) {
        return Err(Unknown::new("node", pattern, names));
    }
    Ok(matches)
}
