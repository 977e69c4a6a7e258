//! Which records are wanted: filters by name, checked against what the journal has.

use std::ops::RangeInclusive;

use ambidex_model::{ControllerId, Header, Record, ResourceId, Time, Told};
use ambidex_record::History;

use super::kind::Kind;
use super::subjects;
use crate::Unknown;
use crate::text::Wanted;

/// Filters as a person gives them; what is left out selects all, what is given must all be so.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Filters {
    /// A pattern of node names: who sends, who gets it, or what is spoken of.
    pub node: Option<String>,
    /// A resource that is spoken of.
    pub resource: Option<String>,
    /// A controller that says it or is told.
    pub controller: Option<String>,
    /// Any of these kinds; empty for all that are not minor.
    pub kinds: Vec<Kind>,
    /// Minor ones besides.
    pub with_minor: bool,
    /// Rounds; what has none belongs to the one that was decided last.
    pub rounds: Option<RangeInclusive<u32>>,
    /// Not before this moment since the mission began.
    pub from: Option<Time>,
    /// Not after this moment since the mission began.
    pub to: Option<Time>,
}

/// Filters of one journal.
#[derive(Debug, Clone)]
pub struct Selection {
    nodes: Option<Wanted>,
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
        let may_come = header.topology().stem().0 > 0;
        let wanted = |pattern: &String| Wanted::new("node", pattern, names.nodes.iter(), may_come);
        Ok(Self {
            nodes: filters.node.as_ref().map(wanted).transpose()?,
            resource: position("resource", &filters.resource, &names.resources)?.map(ResourceId::from),
            controller: position("controller", &filters.controller, &names.controllers)?.map(ControllerId::from),
            rest: filters.clone(),
        })
    }

    /// Whether a record is wanted; `round` is its own or the one that was decided last.
    pub(super) fn has(&self, record: &Record, round: u32, history: &History) -> bool {
        let Filters { kinds, rounds, from, to, with_minor, .. } = &self.rest;
        let (at, kind) = (history.now(), Kind::of(record));
        let is_news = matches!(record, Record::Told { input: Told::Resumed, .. });
        let is_kind = if kinds.is_empty() { is_news || !kind.is_minor() } else { kinds.contains(&kind) };
        (is_kind || (*with_minor && kind.is_minor()))
            && rounds.as_ref().is_none_or(|rounds| rounds.contains(&round))
            && from.is_none_or(|from| at >= from)
            && to.is_none_or(|to| at <= to)
            && self.resource.is_none_or(|resource| subjects::of_resource(record, resource))
            && self.controller.is_none_or(|controller| subjects::of_controller(record, controller))
            && self.nodes.as_ref().is_none_or(|wanted| {
                subjects::of_node(record, history, &|node| wanted.matches(history.names().node(node)))
            })
    }
}
