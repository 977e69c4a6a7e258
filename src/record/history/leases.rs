//! Who held a resource when, and on which channel it was shared.

use ambidex_model::{ChannelId, Lease, LeaseKind, Loss, NodeId, Resource, Time};

/// What became of a resource.
#[derive(Debug, Clone, Default)]
pub struct Lane {
    ended: Vec<Held>,
    open: Vec<Held>,
    channels: Vec<(ChannelId, Time, Option<Time>)>,
    channel: Option<ChannelId>,
    outages: Vec<(Loss, Time, Option<Time>)>,
}

/// A lease from its beginning to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// What was held, by whom and why.
    pub lease: Lease,
    /// When it began.
    pub from: Time,
    /// When it ended; none where it lasts when the records end.
    pub to: Option<Time>,
    /// Leases at the same time have different tracks; the lowest free one is taken.
    pub track: usize,
}

impl Lane {
    /// Every lease, those that last when the records end behind the others.
    pub fn leases(&self) -> impl Iterator<Item = &Held> {
        self.ended.iter().chain(&self.open)
    }

    /// When it was shared on which channel; no end where it is when the records end.
    pub fn channels(&self) -> &[(ChannelId, Time, Option<Time>)] {
        &self.channels
    }

    /// When it was unavailable and why; no end where it is when the records end.
    pub fn outages(&self) -> &[(Loss, Time, Option<Time>)] {
        &self.outages
    }

    /// Takes apart what has ended, which it then knows no more: for whoever follows a log without end.
    #[must_use]
    pub fn take_past(&mut self) -> Self {
        Self {
            ended: std::mem::take(&mut self.ended),
            channels: self.channels.extract_if(.., |(.., to)| to.is_some()).collect(),
            outages: self.outages.extract_if(.., |(.., to)| to.is_some()).collect(),
            ..Self::default()
        }
    }

    /// Takes what the resource is like from a moment on.
    pub fn change(&mut self, at: Time, state: &Resource) {
        let is_out = self.outages.last().is_some_and(|(.., to)| to.is_none());
        match (state.service().outage(), self.outages.last_mut()) {
            (Some(why), _) if !is_out => self.outages.push((why, at, None)),
            (None, Some(last)) if is_out => last.2 = Some(at),
            (Some(_) | None, _) => {}
        }
        let key = |lease: &Lease| -> (NodeId, NodeId, LeaseKind) { (lease.holder, lease.behavior, lease.kind) };
        let is_kept = |held: &Held| state.leases().iter().any(|lease| key(lease) == key(&held.lease));
        let (open, gone): (Vec<Held>, Vec<Held>) = self.open.drain(..).partition(is_kept);
        self.open = open;
        // What came and went at one moment was never seen.
        let seen = gone.into_iter().filter(|held| held.from < at);
        self.ended.extend(seen.map(|held| Held { to: Some(at), ..held }));
        for lease in state.leases() {
            if self.open.iter().any(|held| key(&held.lease) == key(lease)) {
                continue;
            }
            let track = (0..).find(|track| self.open.iter().all(|held| held.track != *track)).unwrap_or_default();
            self.open.push(Held { lease: *lease, from: at, to: None, track });
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
