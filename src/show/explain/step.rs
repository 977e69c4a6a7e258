//! What happened at one step of a run: what ended, what that led to, who waits.

use std::collections::BTreeMap;

use ambidex_model::{Access, Binding, Blocked, Grant, Names, NodeId, Reason, Record, Time};
use ambidex_record::{History, LeafState};

use super::because::because;
use super::sentence;
use crate::text::{ended, phrase};

/// A line of the story: what it is about and what it says.
pub(super) type Told = (LeafState, String);

/// From what ended or changed to the last decision that followed.
#[derive(Debug, Clone, Default)]
pub(super) struct Step {
    pub(super) at: Time,
    pub(super) happened: Vec<Told>,
    /// Whether anything was decided yet: what happens after that is another step.
    pub(super) is_decided: bool,
    waits: BTreeMap<NodeId, (Reason, String)>,
}

impl Step {
    /// Who waits that did not wait for the same before; `known` is what was told of everybody so far.
    pub(super) fn waiting(&self, known: &mut BTreeMap<NodeId, Reason>, names: &Names) -> Vec<Told> {
        let mut groups: Vec<(&str, Vec<NodeId>)> = Vec::new();
        for (leaf, (reason, said)) in &self.waits {
            let before = known.insert(*leaf, reason.clone());
            if !is_news(before.as_ref(), reason) {
                continue;
            }
            match groups.iter_mut().find(|(other, _)| *other == said) {
                Some((_, leaves)) => leaves.push(*leaf),
                None => groups.push((said, vec![*leaf])),
            }
        }
        let told = groups.into_iter().map(|(said, leaves)| {
            let who = phrase::nodes(leaves.iter().copied(), names);
            let wait = if leaves.len() == 1 { "waits:" } else { "wait, each because" };
            (LeafState::Waiting, format!("{who} {wait} {said}."))
        });
        told.collect()
    }

    /// Takes what root decided.
    pub(super) fn decide(&mut self, record: &Record, history: &History) {
        let Record::Decided { granted, refused, reopened, .. } = record else {
            return;
        };
        let names = history.names();
        if !self.is_decided && self.happened.is_empty() {
            self.at = history.moment(record.at());
        }
        self.is_decided = true;
        if let Some(reopened) = reopened {
            let said = format!("{} {}", names.node(reopened.node), sentence::reopened(reopened, names));
            self.happened.push((LeafState::Waiting, said));
        }
        if !granted.is_empty() {
            self.happened.push((LeafState::Active, started(granted, refused, history)));
        }
        for grant in granted {
            self.waits.remove(&grant.leaf());
            let skipped = sentence::skipped(&history.skipped_by(grant), names);
            self.happened.extend(skipped.map(|said| (LeafState::Skipped, said)));
        }
        for Blocked { leaf, reason } in refused {
            let is_kept = self.waits.get(leaf).is_some_and(|(before, _)| !is_news(Some(before), reason));
            // That a node fails was told with what failed.
            let is_told = matches!(reason, Reason::Satisfied | Reason::Ending { .. });
            if !is_told && !is_kept && !history.state(*leaf).is_done() {
                self.waits.insert(*leaf, (reason.clone(), because(reason, history).whole()));
            }
        }
    }

    /// Takes the end of a behavior.
    pub(super) fn release(&mut self, record: &Record, history: &History) {
        let Record::Released { leaf, end, consequences, changes, .. } = record else {
            return;
        };
        let (names, at) = (history.names(), history.moment(record.at()));
        let ends = sentence::ended(history, at, *leaf, *end, *consequences);
        let said = [names.node(*leaf).to_owned()].into_iter().chain(ends).chain(sentence::changes(changes, names));
        self.happens(at, ended(*end), said.collect::<Vec<_>>().join(" "));
    }

    /// Takes anything else that happens.
    pub(super) fn happens(&mut self, at: Time, state: LeafState, said: String) {
        if self.happened.is_empty() {
            self.at = at;
        }
        self.happened.push((state, said));
    }
}

/// Whether a reason says more than the one before: who lost to a request need not be told that it has the resource.
fn is_news(before: Option<&Reason>, now: &Reason) -> bool {
    match (before, now) {
        (None, Reason::Outbid { .. }) => false,
        (Some(Reason::Outbid { by: winner, .. }), Reason::Held { by, .. } | Reason::Outbid { by, .. }) => by != winner,
        (Some(_), Reason::Outbid { .. }) => false,
        (before, now) => before != Some(now),
    }
}

/// What starts, with what, and why it and not others.
fn started(granted: &[Grant], refused: &[Blocked], history: &History) -> String {
    let names = history.names();
    let who = phrase::nodes(granted.iter().map(|grant| grant.leaf()), names);
    let mut said = Vec::new();
    if let [only] = granted {
        said.push(format!("{who} starts with {}.", phrase::bindings(&only.bindings, names)));
    } else {
        said.push(format!("{who} start together."));
        said.extend(shares(granted, names));
    }
    for grant in granted {
        let losers = sentence::losers(grant.leaf(), refused);
        said.extend(sentence::beats(grant, &losers, granted.len() > 1, names));
    }
    said.extend(sentence::beside(history.running().keys().copied(), names));
    said.join(" ")
}

/// What several grants have together, and what each has besides.
fn shares(granted: &[Grant], names: &Names) -> Vec<String> {
    let is_same = |one: &Binding, other: &Binding| (one.resource, one.access) == (other.resource, other.access);
    let has = |grant: &Grant, binding: &Binding| grant.bindings.iter().any(|other| is_same(binding, other));
    let [first, rest @ ..] = granted else {
        return Vec::new();
    };
    let is_shared =
        |binding: &Binding| matches!(binding.access, Access::Shared(_)) && rest.iter().all(|other| has(other, binding));
    let (shared, _): (Vec<Binding>, Vec<Binding>) = first.bindings.iter().partition(|binding| is_shared(binding));
    let mut said = Vec::new();
    if !shared.is_empty() {
        said.push(format!("They share {}.", phrase::bindings(&shared, names)));
    }
    let own = granted.iter().filter_map(|grant| {
        let own: Vec<Binding> = grant.bindings.iter().filter(|binding| !is_shared(binding)).copied().collect();
        (!own.is_empty()).then(|| format!("{} has {}", names.node(grant.leaf()), phrase::bindings(&own, names)))
    });
    let own: Vec<String> = own.collect();
    if !own.is_empty() {
        said.push(format!("{}.", phrase::listed(&own)));
    }
    said
}
