//! Tasks that come and go: what a log tells of those that are over.

use std::collections::VecDeque;
use std::sync::Arc;

use ambidex_model::state::{Saved, Task};
use ambidex_model::{End, MissionEnd, NodeEntry, NodeId, Record, Time};

use super::History;
use super::states::{Counts, LeafStates};

/// How many tasks that are over are remembered where the past is not kept.
const REMEMBERED: usize = 200;

/// A task that is over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EndedTask {
    /// Its top.
    pub task: NodeId,
    /// What was known of it.
    pub known: Task,
    /// When it ended.
    pub at: Time,
    /// How.
    pub end: MissionEnd,
    /// Why, where it failed, as a sentence.
    pub said: Option<String>,
    /// What had become of its behaviors.
    pub counts: Counts,
}

impl History {
    /// Whether tasks come and go in this run.
    pub fn is_standing(&self) -> bool {
        self.header.is_standing()
    }

    /// Tasks that are over, in the order of their ends: the last ones, where the past is not kept.
    pub fn ended_tasks(&self) -> &VecDeque<EndedTask> {
        &self.ended_tasks
    }

    /// The log begins where another was put aside. What cannot be read is passed over.
    pub(super) fn go_on_from(&mut self, at: Time, saved: &str) {
        let Ok(saved) = serde_json::from_str::<Saved>(saved) else { return };
        let Saved { state, nodes, names, .. } = saved;
        self.states = LeafStates::restored(&nodes, &state, at, self.past.is_some());
        self.potentials = nodes.map(|_| None);
        let header = Arc::make_mut(&mut self.header);
        (header.nodes, header.names) = (nodes, names.legible());
        self.resources = state.table().iter().map(|(_, resource)| resource.clone()).collect();
        self.base = Some(state.world().base);
        self.state = state;
    }

    /// Takes over what comes, before the state has it.
    pub(super) fn add(&mut self, record: &Record) {
        let Record::Added { top, under, behind, nodes, names, channels, .. } = record else { return };
        let is_next = [self.state.topology(), &self.states.topology].iter().all(|topology| topology.next() == *top);
        if !is_next || !self.state.topology().has(*under) || self.header.nodes.len() > top.index() {
            return;
        }
        let header = Arc::make_mut(&mut self.header);
        let entry = |(index, entry): (usize, &NodeEntry)| {
            let parent = if index == 0 { *under } else { NodeId(top.0 + entry.parent.0) };
            NodeEntry { parent, kind: entry.kind.clone() }
        };
        header.nodes.add(top.index(), nodes.iter().enumerate().map(entry).collect());
        let mut legible: Vec<String> = names.clone();
        legible.resize(nodes.len(), "?".into());
        legible.iter_mut().for_each(ambidex_model::make_legible);
        header.names.nodes.add(top.index(), legible);
        header.names.channels.extend(channels.iter().cloned());
        self.potentials.add(top.index(), vec![None; nodes.len()]);
        self.states.add(*top, *under, *behind as usize, nodes);
    }

    /// At what a task failed, before it goes.
    fn failing(&self, end: MissionEnd) -> Option<String> {
        let MissionEnd::Failed(leaf) = end else { return None };
        let names = self.names();
        let name = names.node(leaf);
        if let Some(reason) = self.state.infeasible().get(&leaf) {
            return Some(format!("{name} can never run: {}", reason.sentence(names)));
        }
        match self.leaf(leaf).and_then(|leaf| leaf.last_end()) {
            Some(End::Failed(fault)) => Some(format!("{name}: {}", fault.sentence(names))),
            Some(End::Succeeded | End::Canceled | End::Interrupted) | None => Some(name.to_owned()),
        }
    }

    /// A part of the tree is about to go. Where the past is kept, what became of it stays.
    pub(super) fn remove(&mut self, at: Time, node: NodeId, end: Option<MissionEnd>) {
        if let (Some(end), Some(known)) = (end, self.state.tasks().get(&node)) {
            let (said, mut counts) = (self.failing(end), self.counts(node));
            if end == MissionEnd::Done {
                // What was needed and did not run was met already.
                let met = counts.of.saturating_sub(counts.done + counts.not_needed + counts.not_asked);
                (counts.done, counts.skipped) = (counts.done + met, counts.skipped + met);
            }
            let ended = EndedTask { task: node, known: known.clone(), at, end, said, counts };
            if self.past.is_none() && self.ended_tasks.len() >= REMEMBERED {
                self.ended_tasks.pop_front();
            }
            self.ended_tasks.push_back(ended);
        }
        if node.0 == 0 || !self.state.topology().has(node) || !self.states.topology.has(node) {
            return;
        }
        self.states.close(node, at, end);
        if self.past.is_some() {
            return;
        }
        let header = Arc::make_mut(&mut self.header);
        for run in self.states.remove(node) {
            let run = run.start.index()..run.end.index();
            header.nodes.remove(run.clone());
            header.names.nodes.remove(run.clone());
            self.potentials.remove(run);
        }
    }
}
