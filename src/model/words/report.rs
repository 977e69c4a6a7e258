//! What came of a run, folded from its records alone.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{
    Blocked, ControllerId, ControllerMessage, End, EntryKind, Grant, Header, MissionEnd, NodeId, Reason, Record,
    Reopened, Time,
};

/// When a leaf ran once: from its grant to its release.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interval {
    /// The behavior.
    pub leaf: NodeId,
    /// When it was granted.
    pub from: Time,
    /// When its end was applied; none while it runs.
    pub to: Option<Time>,
    /// How it ended.
    pub end: Option<End>,
    /// Whether a node fails with it: it is not asked again.
    pub is_final: bool,
    /// Since when it counts as done no more, though it succeeded.
    pub reopened: Option<Time>,
}

impl Interval {
    /// Whether it succeeded and still counts.
    fn is_done(&self) -> bool {
        self.end == Some(End::Succeeded) && self.reopened.is_none()
    }
}

/// A running fold of records.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// What the ids stand for.
    pub header: Option<Box<Header>>,
    /// What was granted between two releases, in order.
    pub steps: Vec<Vec<NodeId>>,
    /// What is done without having run, in the order in which that was settled, with its time.
    pub skipped: Vec<(NodeId, Time)>,
    /// The last reason of every leaf that had one.
    pub reasons: BTreeMap<NodeId, Reason>,
    /// When leaves ran.
    pub intervals: Vec<Interval>,
    /// Rounds so far.
    pub rounds: u32,
    /// Messages between nodes so far.
    pub messages: u64,
    /// When controllers were lost.
    pub lost: BTreeMap<ControllerId, Time>,
    /// How the mission ended.
    pub end: Option<MissionEnd>,
    /// Time of the last record.
    pub now: Time,
    closed: bool,
    /// Where among the intervals each leaf ran last.
    latest: BTreeMap<NodeId, usize>,
}

impl Tally {
    /// Takes the next record.
    pub fn add(&mut self, record: &Record) {
        match record {
            Record::Header(header) => self.header = Some(header.clone()),
            Record::Sent { .. } => self.messages += 1,
            Record::Decided { at, round, granted, refused, reopened } => {
                self.now = *at;
                self.rounds = *round;
                for grant in granted {
                    self.grant(*at, grant);
                }
                for Blocked { leaf, reason } in refused {
                    self.reasons.insert(*leaf, reason.clone());
                }
                if let Some(Reopened { leaf, lapsed, .. }) = reopened {
                    self.skipped.retain(|(skipped, _)| skipped != leaf);
                    if let Some(run) = self.last_run(*leaf).filter(|run| run.is_done()) {
                        run.reopened = Some(*at);
                    }
                    self.closed |= lapsed.is_some();
                }
            }
            Record::Released { at, leaf, end, consequences, .. } => {
                self.now = *at;
                self.closed = true;
                if let Some(run) = self.last_run(*leaf).filter(|run| run.to.is_none()) {
                    run.to = Some(*at);
                    run.end = Some(*end);
                    run.is_final = consequences.failed.is_some();
                }
            }
            Record::Controller { at, controller, message } => {
                self.now = *at;
                if matches!(message, ControllerMessage::Lost { .. }) {
                    self.lost.insert(*controller, *at);
                }
            }
            Record::World { at, .. } | Record::Resource { at, .. } => self.now = *at,
            Record::Ended { at, end } => {
                self.now = *at;
                // Only the first word counts: what is made safe afterwards ends as canceled.
                if *self.end.get_or_insert(*end) == MissionEnd::Done {
                    self.skip_satisfied(*at);
                }
            }
        }
    }

    /// Robot seconds from the first grant to the last release.
    pub fn makespan_s(&self) -> f64 {
        let first = self.intervals.iter().map(|run| run.from).min();
        let last = self.intervals.iter().filter_map(|run| run.to).max();
        first.zip(last).map_or(0.0, |(first, last)| (last - first).as_secs_f64())
    }

    /// The report, with names; none before a header and an end.
    pub fn report(&self) -> Option<MissionReport> {
        let header = self.header.as_ref()?;
        let name = |leaf: &NodeId| header.names.node(*leaf).to_owned();
        let steps = self.steps.iter().map(|step| {
            let mut names: Vec<String> = step.iter().map(name).collect();
            names.sort();
            names
        });
        Some(MissionReport {
            mission: header.mission.clone(),
            outcome: match self.end? {
                MissionEnd::Done => "done",
                MissionEnd::Failed(_)
                | MissionEnd::ControllerLost(_)
                | MissionEnd::NotAttached
                | MissionEnd::NodeLost(_)
                | MissionEnd::TaskLost => "failed",
                MissionEnd::Stalled => "stalled",
                MissionEnd::Canceled => "canceled",
            },
            steps: steps.collect(),
            skipped: self.skipped.iter().map(|(leaf, _)| name(leaf)).collect(),
            rounds: self.rounds,
            messages: self.messages,
            makespan_s: self.makespan_s(),
        })
    }

    fn grant(&mut self, at: Time, grant: &Grant) {
        if self.closed || self.steps.is_empty() {
            self.steps.push(Vec::new());
            self.closed = false;
        }
        self.steps.last_mut().expect("a step was just opened").push(grant.leaf());
        self.latest.insert(grant.leaf(), self.intervals.len());
        let (leaf, from) = (grant.leaf(), at);
        self.intervals.push(Interval { leaf, from, to: None, end: None, is_final: false, reopened: None });
        self.reasons.remove(&grant.leaf());
        self.skipped.retain(|(leaf, _)| *leaf != grant.leaf());
        let nodes = self.header.as_ref().map_or(0, |header| header.nodes.len());
        for leaf in grant.skipped(nodes).filter(|leaf| self.is_behavior(*leaf)).collect::<Vec<_>>() {
            let is_done = self.skipped.iter().any(|(known, _)| *known == leaf) || self.is_done(leaf);
            if !is_done {
                self.skipped.push((leaf, at));
            }
        }
    }

    fn skip_satisfied(&mut self, at: Time) {
        let met = self.reasons.iter().filter(|(_, reason)| **reason == Reason::Satisfied).map(|(leaf, _)| *leaf);
        let new: Vec<_> = met
            .filter(|leaf| !self.is_done(*leaf) && self.skipped.iter().all(|(known, _)| known != leaf))
            .filter(|leaf| !self.is_way_not_taken(*leaf))
            .map(|leaf| (leaf, at))
            .collect();
        self.skipped.extend(new);
    }

    /// Whether an OR above went another way.
    fn is_way_not_taken(&self, leaf: NodeId) -> bool {
        let Some(nodes) = self.header.as_ref().map(|header| &header.nodes) else {
            return false;
        };
        // A journal can hold anything: a parent stands before its children or is none.
        let parent = |node: NodeId| nodes.get(node.index()).map(|entry| entry.parent).filter(|up| *up < node);
        let is_below = |node: NodeId, top: NodeId| {
            let line = std::iter::successors(Some(node), |node| parent(*node));
            line.take_while(|node| *node >= top).any(|node| node == top)
        };
        let has_run = |top: NodeId| {
            let mut done = self.intervals.iter().filter(|run| run.end == Some(End::Succeeded));
            done.any(|run| is_below(run.leaf, top))
        };
        let line = std::iter::successors(Some(leaf), |node| parent(*node));
        let mut steps = line.filter_map(|child| Some((child, parent(child)?)));
        steps.any(|(child, or)| nodes[or.index()].kind == EntryKind::Or && has_run(or) && !has_run(child))
    }

    fn last_run(&mut self, leaf: NodeId) -> Option<&mut Interval> {
        self.latest.get(&leaf).and_then(|&index| self.intervals.get_mut(index))
    }

    /// Whether a leaf ran and is done.
    fn is_done(&self, leaf: NodeId) -> bool {
        self.latest.get(&leaf).is_some_and(|&index| self.intervals[index].is_done())
    }

    fn is_behavior(&self, node: NodeId) -> bool {
        let entry = self.header.as_ref().and_then(|header| header.nodes.get(node.index()));
        entry.is_none_or(|entry| entry.kind.is_behavior())
    }
}

/// What came of a mission, as `--json` prints it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MissionReport {
    /// The mission's name.
    pub mission: String,
    /// `done`, `failed`, `stalled` or `canceled`.
    pub outcome: &'static str,
    /// What was granted between two releases; names sorted.
    pub steps: Vec<Vec<String>>,
    /// What was done without running.
    pub skipped: Vec<String>,
    /// Rounds.
    pub rounds: u32,
    /// Messages between nodes.
    pub messages: u64,
    /// Robot seconds from the first grant to the last release.
    pub makespan_s: f64,
}
