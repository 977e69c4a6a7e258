//! What a timeline is drawn from, folded from records: phases by behavior, leases by resource, rounds.

use ambidex_model::{
    ChannelId, Consequences, End, EntryKind, Fault, Grant, Header, Lease, LeaseKind, MissionEnd, NodeId, Record,
    Resource, Tally, Time,
};

/// A running fold of records for a timeline.
#[derive(Debug, Clone, Default)]
pub struct History {
    tally: Tally,
    /// By node; empty for what is no behavior.
    phases: Vec<Vec<(Time, Phase)>>,
    lanes: Vec<Lane>,
    rounds: Vec<Time>,
    /// By node, the first one behind its subtree.
    ends: Vec<NodeId>,
}

/// What a behavior is from some moment on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// It has not run.
    Waiting,
    /// It runs.
    Active,
    /// It ran and is done.
    Done,
    /// It is done without having run.
    Skipped,
    /// It failed; final where it does not ask again.
    Failed { fault: Fault, is_final: bool },
    /// It was told to end.
    Canceled,
    /// It was done and is not any more.
    Reopened,
    /// What is above it has failed, or is done another way.
    Unwanted,
}

/// A phase from its beginning to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    pub(super) phase: Phase,
    pub(super) from: Time,
    pub(super) to: Time,
    /// It lasts when the records end.
    pub(super) is_open: bool,
}

/// What became of a resource.
#[derive(Debug, Clone, Default)]
pub(super) struct Lane {
    ended: Vec<Held>,
    open: Vec<Held>,
    /// When it was shared on which channel; no end where it is when the records end.
    pub(super) channels: Vec<(ChannelId, Time, Option<Time>)>,
    channel: Option<ChannelId>,
}

/// A lease from its beginning to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    pub(super) holder: NodeId,
    pub(super) behavior: NodeId,
    pub(super) kind: LeaseKind,
    /// The node that it was inherited from.
    pub(super) inherited: Option<NodeId>,
    pub(super) from: Time,
    pub(super) to: Option<Time>,
    /// Leases at the same time have different slots; the lowest free one is taken.
    pub(super) slot: usize,
}

impl History {
    /// Takes the next record.
    pub fn add(&mut self, record: &Record) {
        self.tally.add(record);
        match record {
            Record::Header(header) => self.begin(header),
            Record::Decided { at, granted, reopened, .. } => {
                if self.rounds.last() != Some(at) {
                    self.rounds.push(*at);
                }
                granted.iter().for_each(|grant| self.grant(*at, grant));
                if let Some(reopened) = reopened {
                    self.enter(reopened.leaf, *at, Phase::Reopened);
                }
            }
            Record::Released { at, leaf, end, consequences, .. } => self.release(*at, *leaf, *end, *consequences),
            Record::Resource { at, resource, state } => {
                if let Some(lane) = self.lanes.get_mut(resource.index()) {
                    lane.change(*at, state);
                }
            }
            Record::Ended { at, end: MissionEnd::Done } => self.skip_met(*at),
            Record::Ended { .. } | Record::Sent { .. } | Record::World { .. } | Record::Controller { .. } => {}
        }
    }

    /// The fold of the same records for diagram and summary in text.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The first grant, since waiting for controllers says nothing of the task.
    pub(super) fn start(&self) -> Time {
        self.tally.intervals.first().map(|run| run.from).unwrap_or_default()
    }

    /// The last release, or the last record where something runs on.
    pub(super) fn end(&self) -> Time {
        let runs_on = self.tally.intervals.iter().any(|run| run.to.is_none());
        let last = self.tally.intervals.iter().filter_map(|run| run.to).max();
        last.filter(|_| !runs_on).unwrap_or(self.tally.now)
    }

    /// Every behavior in tree order.
    pub(super) fn behaviors(&self) -> impl Iterator<Item = NodeId> + '_ {
        (0..self.phases.len()).filter(|&node| !self.phases[node].is_empty()).map(NodeId::from)
    }

    pub(super) fn has_run(&self, leaf: NodeId) -> bool {
        self.phases[leaf.index()].iter().any(|(_, phase)| *phase == Phase::Active)
    }

    /// Every resource in resource order.
    pub(super) fn lanes(&self) -> &[Lane] {
        &self.lanes
    }

    /// When rounds were decided; several at one moment are one.
    pub(super) fn rounds(&self) -> &[Time] {
        &self.rounds
    }

    /// When each step began.
    pub(super) fn step_times(&self) -> impl Iterator<Item = Time> + '_ {
        let mut before = 0;
        self.tally.steps.iter().filter_map(move |step| {
            let first = self.tally.intervals.get(before);
            before += step.len();
            first.map(|run| run.from)
        })
    }

    /// What a behavior was, from the first grant to the end.
    pub(super) fn stretches(&self, leaf: NodeId) -> impl Iterator<Item = Stretch> + '_ {
        let phases = &self.phases[leaf.index()];
        let (start, end) = (self.start(), self.end());
        phases.iter().enumerate().map(move |(index, &(from, phase))| {
            let next = phases.get(index + 1).map(|(next, _)| *next);
            let from = from.max(start);
            Stretch { phase, from, to: next.unwrap_or(end).max(from), is_open: next.is_none() }
        })
    }

    fn begin(&mut self, header: &Header) {
        let waiting =
            |kind: &EntryKind| if kind.is_behavior() { vec![(Time::ZERO, Phase::Waiting)] } else { Vec::new() };
        self.phases = header.nodes.iter().map(|node| waiting(&node.kind)).collect();
        self.lanes = vec![Lane::default(); header.resource_types.len()];
        self.ends = (1..=header.nodes.len()).map(NodeId::from).collect();
        for node in (1..header.nodes.len()).rev() {
            let parent = header.nodes[node].parent.index();
            // The header is read from a file: what does not come before its child is no parent.
            if parent < node {
                self.ends[parent] = self.ends[parent].max(self.ends[node]);
            }
        }
    }

    fn grant(&mut self, at: Time, grant: &Grant) {
        for leaf in grant.skipped(self.phases.len()) {
            match self.phase(leaf) {
                Some(Phase::Waiting | Phase::Reopened | Phase::Failed { .. } | Phase::Canceled | Phase::Unwanted) => {
                    self.enter(leaf, at, Phase::Skipped);
                }
                Some(Phase::Active | Phase::Done | Phase::Skipped) | None => {}
            }
        }
        self.enter(grant.leaf(), at, Phase::Active);
    }

    fn release(&mut self, at: Time, leaf: NodeId, end: End, consequences: Consequences) {
        let phase = match end {
            End::Succeeded => Phase::Done,
            End::Failed(fault) => Phase::Failed { fault, is_final: consequences.failed.is_some() },
            End::Canceled => Phase::Canceled,
        };
        self.enter(leaf, at, phase);
        let settled = consequences.failed.into_iter().chain(consequences.completed.map(|completed| completed.node));
        for top in settled {
            let end = self.ends.get(top.index()).copied().unwrap_or(top);
            for below in (top.0..end.0).map(NodeId) {
                match self.phase(below) {
                    Some(Phase::Waiting | Phase::Reopened | Phase::Failed { is_final: false, .. }) => {
                        self.enter(below, at, Phase::Unwanted);
                    }
                    Some(
                        Phase::Active
                        | Phase::Done
                        | Phase::Skipped
                        | Phase::Failed { is_final: true, .. }
                        | Phase::Canceled
                        | Phase::Unwanted,
                    )
                    | None => {}
                }
            }
        }
    }

    /// What was met at the end without having run.
    fn skip_met(&mut self, at: Time) {
        let met: Vec<NodeId> =
            self.tally.skipped.iter().filter(|(_, then)| *then == at).map(|(leaf, _)| *leaf).collect();
        for leaf in met {
            if !matches!(self.phase(leaf), Some(Phase::Done | Phase::Skipped | Phase::Active)) {
                self.enter(leaf, at, Phase::Skipped);
            }
        }
    }

    fn phase(&self, leaf: NodeId) -> Option<Phase> {
        self.phases.get(leaf.index())?.last().map(|(_, phase)| *phase)
    }

    fn enter(&mut self, leaf: NodeId, at: Time, phase: Phase) {
        if let Some(phases) = self.phases.get_mut(leaf.index()).filter(|phases| !phases.is_empty()) {
            phases.push((at, phase));
        }
    }
}

impl Lane {
    /// Every lease, those that last when the records end behind the others.
    pub(super) fn leases(&self) -> impl Iterator<Item = &Held> {
        self.ended.iter().chain(&self.open)
    }

    fn change(&mut self, at: Time, state: &Resource) {
        let is_same = |held: &Held, lease: &Lease| {
            (held.holder, held.behavior, held.kind) == (lease.holder, lease.behavior, lease.kind)
        };
        let is_kept = |held: &Held| state.leases().iter().any(|lease| is_same(held, lease));
        let (open, gone): (Vec<Held>, Vec<Held>) = self.open.drain(..).partition(is_kept);
        self.open = open;
        // What came and went at one moment was never seen.
        let seen = gone.into_iter().filter(|held| held.from < at);
        self.ended.extend(seen.map(|held| Held { to: Some(at), ..held }));
        for lease in state.leases() {
            if self.open.iter().any(|held| is_same(held, lease)) {
                continue;
            }
            let slot = (0..).find(|slot| self.open.iter().all(|held| held.slot != *slot)).unwrap_or_default();
            let (holder, behavior, kind, inherited) = (lease.holder, lease.behavior, lease.kind, lease.from);
            self.open.push(Held { holder, behavior, kind, inherited, from: at, to: None, slot });
        }
        self.share(at, state.channel());
    }

    fn share(&mut self, at: Time, channel: Option<ChannelId>) {
        if self.channel == channel {
            return;
        }
        if let Some(last) = self.channels.last_mut().filter(|last| last.2.is_none()) {
            last.2 = Some(at);
            if last.1 == at {
                self.channels.pop();
            }
        }
        self.channel = channel;
        match (channel, self.channels.last_mut()) {
            (Some(channel), Some(last)) if *last == (channel, last.1, Some(at)) => last.2 = None,
            (Some(channel), _) => self.channels.push((channel, at, None)),
            (None, _) => {}
        }
    }
}
