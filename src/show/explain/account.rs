//! Why behaviors, or each below some nodes, ran or did not, round by round.

use std::collections::BTreeMap;
use std::fmt::Write;

use ambidex_model::{
    Blocked, Change, Grant, Header, Message, MissionEnd, NodeId, Origin, Reason, Record, Reopened, Time,
};
use ambidex_record::{History, LeafState};

use super::because::{Because, because};
use super::entry::{Entry, Leaf, Wait};
use super::sentence;
use crate::text::{MIN_WIDTH, Wanted, ended, hang, mission_ended, phrase};
use crate::{Palette, Unknown};

/// A running fold of records about some nodes.
#[derive(Debug, Clone)]
pub struct Account {
    history: History,
    wanted: Wanted,
    nodes: BTreeMap<NodeId, Option<Asked>>,
    round: Option<u32>,
    rounds: Option<(u32, u32)>,
    leaves: BTreeMap<NodeId, Leaf>,
}

/// What the node asked for over time.
#[derive(Debug, Clone, Copy)]
struct Asked {
    rounds: u32,
    least: f64,
    most: f64,
}

/// A decision of root.
struct Decision<'a> {
    at: Time,
    round: u32,
    granted: &'a [Grant],
    refused: &'a [Blocked],
    reopened: Option<&'a Reopened>,
}

impl Account {
    /// An account of the nodes with such a name, of one round or all; `*`, `?` and `[…]` match as in a shell.
    ///
    /// # Errors
    /// When no node is called so.
    pub fn new(header: &Header, pattern: &str, round: Option<u32>) -> Result<Self, Unknown> {
        let topology = header.topology();
        let is_standing = topology.stem().0 > 0;
        let wanted = Wanted::new("node", pattern, header.names.nodes.iter(), is_standing)?;
        let mut account = Self {
            // What tasks were that are gone stays.
            history: if is_standing { History::with_past(header) } else { History::new(header) },
            wanted,
            leaves: BTreeMap::new(),
            nodes: BTreeMap::new(),
            round,
            rounds: None,
        };
        let known: Vec<NodeId> = topology.nodes().collect();
        account.look_at(&known);
        Ok(account)
    }

    /// Takes in those of some nodes that are called so, with the behaviors below them.
    fn look_at(&mut self, nodes: &[NodeId]) {
        let history = &self.history;
        let is_meant = |node: &NodeId| self.wanted.matches(history.names().node(*node));
        let meant: Vec<NodeId> = nodes.iter().copied().filter(is_meant).collect();
        let below = meant.iter().flat_map(|node| history.leaves_below(*node));
        self.leaves.extend(below.map(|leaf| (leaf, Leaf::default())));
        self.nodes.extend(meant.into_iter().map(|node| (node, None)));
    }

    /// Whether it is about what a node says.
    pub fn is_about(&self, node: NodeId) -> bool {
        self.nodes.contains_key(&node) || self.leaves.contains_key(&node)
    }

    /// Takes the next record.
    pub fn add(&mut self, record: &Record) {
        let at = self.history.moment(record.at());
        match record {
            Record::Sent { from, message: Message::Answer { potential: Some(potential), .. }, .. } => {
                self.ask(*from, *potential);
            }
            Record::Decided { round, granted, refused, reopened, .. } => {
                let reopened = reopened.as_ref();
                self.decide(&Decision { at, round: *round, granted, refused, reopened });
            }
            Record::Released { leaf, end, consequences, changes, .. } if self.leaves.contains_key(leaf) => {
                let ends = sentence::ended(&self.history, at, *leaf, *end, *consequences);
                let changes = sentence::changes(changes, self.history.names());
                let said: Vec<String> = ["It".to_owned()].into_iter().chain(ends).chain(changes).collect();
                self.tell(*leaf, Entry::moment(at, None, ended(*end), said.join(" ")));
            }
            Record::World { change, origin, .. } => self.change(at, change, *origin),
            Record::Removed { node, .. }
            | Record::TaskEnded { task: node, .. }
            | Record::Canceled { task: node, .. } => {
                self.happen(at, *node, record);
            }
            Record::Granting { task: Some(task), .. } => self.happen(at, *task, record),
            Record::Added { .. } | Record::Granting { task: None, .. } | Record::Stalled { .. } => {}
            Record::ObjectAdded { .. }
            | Record::ObjectRemoved { .. }
            | Record::Declined { .. }
            | Record::Checkpoint { .. } => {}
            Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => {}
            Record::Woke { .. } | Record::Served { .. } | Record::Awaited { .. } => {}
            Record::Infeasible { .. }
            | Record::TimedOut { .. }
            | Record::Reopened { .. }
            | Record::Stopped { .. }
            | Record::Leaving { .. }
            | Record::Cleaning { .. }
            | Record::Cleaned { .. }
            | Record::Overtaken { .. } => {
                self.turn(at, record);
            }
            Record::Header(_)
            | Record::Ending { .. }
            | Record::Ended { .. }
            | Record::Sent { .. }
            | Record::Released { .. }
            | Record::Denied { .. }
            | Record::Resource { .. }
            | Record::Controller { .. } => {}
        }
        let is_first_end = self.history.end().is_none();
        let met =
            if let Record::Ended { end: MissionEnd::Done, .. } = record { self.history.met() } else { Vec::new() };
        self.history.apply(record);
        if let Record::Added { top, nodes, .. } = record {
            let added: Vec<NodeId> = (0..nodes.len()).map(|index| NodeId::from(top.index() + index)).collect();
            self.look_at(&added);
        }
        if let Record::Ended { end, .. } = record
            && is_first_end
        {
            self.end(at, *end, &met);
        }
        if matches!(record, Record::Decided { .. } | Record::Released { .. } | Record::Ended { .. }) {
            self.tell_what_is_not_needed(at);
        }
        self.remember(record);
    }

    /// What happened beside the rounds to some leaves.
    fn turn(&mut self, at: Time, record: &Record) {
        let Some(said) = phrase::turned(record, &self.history) else { return };
        let state = sentence::turned(record);
        let said = format!("{}.", sentence::capital(&said, self.history.names()));
        let meant: Vec<NodeId> =
            self.leaves.keys().copied().filter(|leaf| sentence::is_turned(record, *leaf, &self.history)).collect();
        meant.into_iter().for_each(|leaf| self.tell(leaf, Entry::moment(at, None, state, said.clone())));
    }

    /// What happened to a part of the tree, to its leaves.
    fn happen(&mut self, at: Time, top: NodeId, record: &Record) {
        let Some(said) = phrase::turned(record, &self.history) else { return };
        let said = format!("{}.", sentence::capital(&said, self.history.names()));
        let state = sentence::turned(record);
        let meant: Vec<NodeId> =
            self.leaves.keys().copied().filter(|leaf| self.history.is_within(*leaf, top)).collect();
        meant.into_iter().for_each(|leaf| self.tell(leaf, Entry::moment(at, None, state, said.clone())));
    }

    /// What others changed, to the leaves that waited for it.
    fn change(&mut self, at: Time, change: &Change, origin: Origin) {
        let said = format!("From outside: {}.", phrase::changed_by(change, origin, self.history.names()));
        let waits = |leaf: &NodeId| {
            let reason = self.history.leaf(*leaf).filter(|leaf| leaf.state().is_open()).and(self.history.reason(*leaf));
            reason.is_some_and(|reason| is_about(reason.root_cause(), change))
        };
        let meant: Vec<NodeId> = self.leaves.keys().copied().filter(waits).collect();
        meant.into_iter().for_each(|leaf| self.tell(leaf, Entry::moment(at, None, LeafState::Waiting, said.clone())));
    }

    /// The account in sentences.
    ///
    /// # Errors
    /// When it was to be about a round that the journal does not have.
    pub fn text(&self, width: usize, palette: &Palette) -> Result<String, Unknown> {
        let width = width.max(MIN_WIDTH);
        if self.nodes.is_empty() {
            let names: Vec<String> = self.history.names().nodes.iter().cloned().collect();
            return Err(Unknown::new("node", self.wanted.pattern(), &names));
        }
        if let Some(round) = self.round {
            let is_there = self.rounds.is_some_and(|(first, last)| (first..=last).contains(&round));
            if !is_there {
                return Err(self.no_round(round));
            }
        }
        let accounts: Vec<String> =
            self.nodes.iter().map(|(node, asked)| self.account(*node, *asked, width, palette)).collect();
        Ok(accounts.join("\n"))
    }

    /// What is told of one node.
    fn account(&self, node: NodeId, asked: Option<Asked>, width: usize, palette: &Palette) -> String {
        let mut text = self.head(node, asked, width, palette);
        for leaf in self.history.leaves_below(node) {
            if leaf != node {
                let name = self.history.names().node(leaf);
                let _ = writeln!(text, "\n{}", Palette::paint(palette.strong, name));
            }
            text.push_str(&self.leaves[&leaf].text(self.round, width, palette));
        }
        text
    }

    fn ask(&mut self, node: NodeId, potential: f64) {
        let Some(asked) = self.nodes.get_mut(&node) else { return };
        let asked = asked.get_or_insert(Asked { rounds: 0, least: potential, most: potential });
        asked.rounds += 1;
        asked.least = asked.least.min(potential);
        asked.most = asked.most.max(potential);
    }

    fn decide(&mut self, decision: &Decision) {
        let first = self.rounds.map_or(decision.round, |(first, _)| first.min(decision.round));
        self.rounds = Some((first, decision.round));
        let entries = |leaf: &NodeId| (*leaf, self.entries(*leaf, decision));
        let told: Vec<_> = self.leaves.keys().map(entries).collect();
        for (leaf, entries) in told {
            entries.into_iter().for_each(|entry| self.tell(leaf, entry));
        }
    }

    /// What a decision means for a leaf.
    fn entries(&self, leaf: NodeId, decision: &Decision) -> Vec<Entry> {
        let names = self.history.names();
        let moment = |state, said| Entry::moment(decision.at, Some(decision.round), state, said);
        let mut entries = Vec::new();
        if let Some(reopened) = decision.reopened.filter(|reopened| reopened.node == leaf) {
            entries.push(moment(LeafState::Waiting, format!("It {}", sentence::reopened(reopened, names))));
        }
        if let Some(grant) = decision.granted.iter().find(|grant| grant.leaf() == leaf) {
            entries.push(moment(LeafState::Active, self.started(grant, decision)));
            return entries;
        }
        let skipper = decision.granted.iter().find(|grant| self.history.skipped_by(grant).contains(&leaf));
        if let Some(grant) = skipper {
            let next = names.node(grant.leaf());
            let said = format!("It is skipped: its goal is met already, and {next} goes on from there.");
            entries.push(moment(LeafState::Skipped, said));
            return entries;
        }
        let refused = decision.refused.iter().find(|one| one.leaf == leaf).map(|one| &one.reason);
        let state = self.history.state(leaf);
        let is_settled = !state.is_open() || state == LeafState::NotNeeded;
        if is_settled || (refused.is_none() && !entries.is_empty()) {
            return entries;
        }
        let (reason, because) = match refused {
            Some(reason) => (Some(reason.clone()), because(reason, &self.history)),
            None => {
                let reason = self.history.not_asked(leaf);
                let why = reason.as_ref().map(|reason| format!(": {}", reason.sentence(names)));
                let sentence = format!("it is not asked{}", why.unwrap_or_default());
                (reason, Because { sentence, detail: None })
            }
        };
        entries.push(Entry {
            waits: Some(Wait { reason, because, is_first_only: false }),
            ..moment(LeafState::Waiting, String::new())
        });
        entries
    }

    /// How a leaf starts: with what, before whom, and beside whom.
    fn started(&self, grant: &Grant, decision: &Decision) -> String {
        let names = self.history.names();
        let mut said = vec![format!(
            "It starts with potential {:.3}{} and has {}.",
            grant.request.potential,
            sentence::measured(grant.request.distance),
            phrase::bindings(&grant.bindings, names)
        )];
        said.extend(sentence::hands(grant, decision.granted, names));
        said.extend(sentence::beats(grant, &sentence::losers(grant.leaf(), decision.refused), false, names));
        let beside = decision.granted.iter().map(|other| other.leaf()).filter(|other| *other != grant.leaf());
        let beside = phrase::nodes(beside, names);
        if !beside.is_empty() {
            let verb = if decision.granted.len() > 2 { "start" } else { "starts" };
            said.push(format!("{beside} {verb} with it."));
        }
        said.extend(sentence::beside(self.history.running().keys().copied(), names));
        said.join(" ")
    }

    /// What the end means for whatever was not done before it; of that, what is met in the end is skipped.
    fn end(&mut self, at: Time, end: MissionEnd, met: &[NodeId]) {
        let over = format!("The mission is over: {}.", mission_ended(end, self.history.names()));
        let state = |leaf: &NodeId| self.history.state(*leaf);
        let is_told = |leaf: &NodeId| {
            met.contains(leaf) && state(leaf).is_done() || !state(leaf).is_done() && state(leaf) != LeafState::NotNeeded
        };
        let open: Vec<NodeId> = self.leaves.keys().copied().filter(is_told).collect();
        for leaf in open {
            let said =
                if met.contains(&leaf) { "It is skipped: its goal is met already.".into() } else { over.clone() };
            self.tell(leaf, Entry::moment(at, None, self.history.state(leaf), said));
        }
    }

    /// What an OR above leaves over when it is done is told once.
    fn tell_what_is_not_needed(&mut self, at: Time) {
        for (leaf, told) in &mut self.leaves {
            let is_left = self.history.state(*leaf) == LeafState::NotNeeded;
            if let Some(way) =
                self.history.instead_of(*leaf).filter(|_| is_left && told.state() != Some(LeafState::NotNeeded))
            {
                let said = format!("It is not needed: {}.", phrase::did_it(way, self.history.names()));
                told.tell(Entry::moment(at, None, LeafState::NotNeeded, said));
            }
        }
    }

    /// Adds an entry, or makes the last one longer.
    fn tell(&mut self, leaf: NodeId, entry: Entry) {
        if let Some(leaf) = self.leaves.get_mut(&leaf) {
            leaf.tell(entry);
        }
    }

    /// What every leaf was when the round was over that is asked for.
    fn remember(&mut self, record: &Record) {
        if let Record::Decided { round, .. } = record
            && Some(*round) == self.round
        {
            for (&node, leaf) in &mut self.leaves {
                leaf.then = Some(self.history.state(node));
            }
        }
    }

    fn head(&self, node: NodeId, asked: Option<Asked>, width: usize, palette: &Palette) -> String {
        let header = self.history.header();
        let name = header.names.node(node);
        let entry = &header.nodes[node.index()];
        let within = match entry.parent == node {
            true => String::new(),
            false => format!(" in {}", phrase::part(entry.parent, &header.names)),
        };
        let kind = Palette::paint(palette.faint, format!("({}{within})", entry.kind.word()));
        let mut text = format!("{} {kind}\n", Palette::paint(palette.strong, name));
        if let Some(Asked { rounds, least, most }) = asked {
            let times = if rounds == 1 { "once".to_owned() } else { format!("in {rounds} rounds") };
            let potential = match least == most {
                true => format!("potential {least:.3}"),
                false => format!("potentials from {least:.3} to {most:.3}"),
            };
            let said = format!("It asked for resources {times}, with {potential}.");
            text.push_str(&hang("  ", 2, &said, width));
        }
        text
    }

    fn no_round(&self, round: u32) -> Unknown {
        let help = match self.rounds {
            Some((first, last)) => format!("the log has rounds {first} to {last}"),
            None => "the log has no rounds".into(),
        };
        Unknown::told(format!("there is no round {round}"), help)
    }
}

/// Whether what a behavior lacks is about what has changed.
fn is_about(reason: &Reason, change: &Change) -> bool {
    match *change {
        Change::Fact(changed, _) => matches!(reason, Reason::Fact { fact, .. } if *fact == changed),
        Change::Object(changed, _) | Change::Laid(changed, ..) | Change::Taken(changed, _) => matches!(
            reason,
            Reason::Elsewhere { object, .. } | Reason::OutOfReach { object } if *object == changed
        ),
        Change::Blocked(_) | Change::Cleared(_) => {
            matches!(reason, Reason::NoPath { .. } | Reason::PathNotFound { .. })
        }
        Change::Base(_) | Change::Emptied(_) => false,
    }
}
