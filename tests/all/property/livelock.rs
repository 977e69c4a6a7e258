//! No livelock: everything that can come again comes at most once for its cause and progress, and so a run in a finite
//! world ends within a number of rounds that follows from its tree.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use ambidex::model::{Cause, MissionSpec, NodeId, NodeKind, Record, Reopened, ResourceId, Retention, StopCause};

use super::generator::Case;

/// Follows a run and panics at what comes once too often.
pub struct Livelock<'a> {
    mission: &'a MissionSpec,
    bounds: Bounds,
    seen: usize,
    rounds: u64,
    /// Behaviors that were told to end so that others go on.
    interruptions: u64,
    /// Rounds in a row in which nothing was granted and nothing happened but that somebody came to be more urgent,
    /// overdue, or not to ask.
    quiet: u64,
    progress: u64,
    completed: BTreeSet<NodeId>,
    lapsed: BTreeMap<(NodeId, ResourceId), u64>,
    redone: BTreeMap<NodeId, u64>,
    left: BTreeMap<NodeId, u64>,
    preempted: BTreeSet<(NodeId, NodeId, u64)>,
    tried: BTreeMap<NodeId, u32>,
    iterated: BTreeMap<NodeId, u32>,
}

impl<'a> Livelock<'a> {
    pub fn new(case: &'a Case) -> Self {
        Self {
            mission: &case.mission,
            bounds: Bounds::of(case),
            seen: 0,
            rounds: 0,
            interruptions: 0,
            quiet: 0,
            progress: 0,
            completed: BTreeSet::new(),
            lapsed: BTreeMap::new(),
            redone: BTreeMap::new(),
            left: BTreeMap::new(),
            preempted: BTreeSet::new(),
            tried: BTreeMap::new(),
            iterated: BTreeMap::new(),
        }
    }

    /// Takes what a run has recorded since.
    pub fn check(&mut self, records: &[Record]) {
        for record in &records[self.seen..] {
            self.take(record);
        }
        self.seen = records.len();
        let most = self.bounds.rounds(self.interruptions);
        assert!(self.rounds <= most, "a livelock: {} rounds, {most} at most", self.rounds);
        assert!(self.quiet <= self.bounds.quiet, "a livelock: {} rounds in a row come to nothing", self.quiet);
    }

    fn take(&mut self, record: &Record) {
        let is_quiet = |record: &Record| match record {
            Record::Decided { granted, reopened, .. } => granted.is_empty() && reopened.is_none(),
            Record::Turn { .. } | Record::Resource { .. } | Record::Sent { .. } => true,
            _ => false,
        };
        if !is_quiet(record) {
            self.quiet = 0;
        }
        match record {
            Record::Decided { granted, reopened, .. } => {
                self.rounds += 1;
                self.quiet += 1;
                for leaf in granted.iter().map(|grant| grant.leaf()) {
                    self.preempted.retain(|(_, wish, _)| *wish != leaf);
                }
                reopened.iter().for_each(|reopened| self.reopen(reopened));
            }
            Record::Reopened { reopened, .. } => self.reopen(reopened),
            Record::World { .. } => self.progress += 1,
            Record::Released { leaf, consequences, .. } => {
                let counts = consequences.completed.is_some() && !self.mission.tree.topology.is_in_cleanup(*leaf);
                self.progress += u64::from(counts && self.completed.insert(*leaf));
                consequences.cleaned.iter().for_each(|node| self.forget_cleanup(*node));
            }
            Record::Cleaned { node, .. } => self.forget_cleanup(*node),
            Record::Stopped { leaves, cause: StopCause::Preempted { by }, .. } => {
                self.interruptions += leaves.len() as u64;
                for &leaf in leaves {
                    let is_new = self.preempted.insert((leaf, *by, self.progress));
                    assert!(is_new, "a livelock: {leaf:?} is preempted twice for {by:?} in one progress");
                }
            }
            Record::Stopped { leaves, cause: StopCause::Broken(_), .. } => self.interruptions += leaves.len() as u64,
            _ => {}
        }
    }

    fn reopen(&mut self, reopened: &Reopened) {
        let Reopened { node, cause, reset, .. } = reopened;
        let (node, now) = (*node, self.progress);
        match cause {
            Cause::Lapse { resource, .. } => {
                let before = self.lapsed.insert((node, *resource), now);
                assert!(before != Some(now), "a livelock: {node:?} lapses twice in one progress");
            }
            Cause::Redo { .. } => {
                let before = self.redone.insert(node, now);
                assert!(before != Some(now), "a livelock: {node:?} is sent back twice in one progress");
                // It asks again, and what it keeps may lapse again.
                self.lapsed.retain(|(leaf, _), _| *leaf != node);
            }
            Cause::Leave => {
                let before = self.left.insert(node, now);
                assert!(before != Some(now), "a livelock: {node:?} is left twice in one progress");
            }
            Cause::Retry { .. } => {
                let tried = self.tried.get(&node).copied().unwrap_or(0) + 1;
                let most = self.mission.tree.limits(node).retries;
                assert!(tried <= most, "a livelock: {node:?} is tried again for the {tried}. time of {most}");
                self.begin_anew(reset, false);
                self.tried.insert(node, tried);
            }
            Cause::Repeat { .. } => {
                let times = self.iterated.get(&node).copied().unwrap_or(0) + 1;
                let repeat = self.mission.tree.repeats[&node];
                assert!(repeat.goes_on(times), "a livelock: {node:?} begins again after {times} times");
                self.begin_anew(reset, true);
                self.iterated.insert(node, times);
            }
            Cause::Yield => {}
        }
    }

    fn begin_anew(&mut self, reset: &[NodeId], is_iteration: bool) {
        for node in reset {
            self.tried.remove(node);
            self.lapsed.retain(|(leaf, _), _| leaf != node);
            self.iterated.remove(node);
            if is_iteration {
                self.redone.remove(node);
                self.left.remove(node);
                self.completed.remove(node);
            }
        }
    }

    fn forget_cleanup(&mut self, node: NodeId) {
        let topology = &self.mission.tree.topology;
        let cleanup = topology.children(node).last().expect("it has a cleanup");
        let below: Vec<NodeId> = topology.nodes_below(cleanup).collect();
        self.begin_anew(&below, true);
    }
}

/// What a tree allows.
struct Bounds {
    /// Grants that no reopening explains: every iteration and attempt of every behavior.
    grants: u64,
    /// How often nodes lapse, are sent back, left or begin anew.
    reopenings: u64,
    /// What comes from outside, and moments that come.
    told: u64,
    leaves: u64,
    quiet: u64,
}

impl Bounds {
    fn of(case: &Case) -> Self {
        let mission = &*case.mission;
        let leaves: Vec<NodeId> = mission.tree.leaves().collect();
        let times = |node: NodeId| Self::times(case, node);
        let retries = |leaf: NodeId| u64::from(mission.tree.behavior(leaf).expect("a leaf").retries) + 1;
        let kept = |leaf: NodeId| {
            let claims = mission.tree.behavior(leaf).expect("a leaf").claims.iter();
            claims.filter(|claim| matches!(claim.keep, Retention::Intention(_))).count() as u64
        };
        let nodes = || (1..mission.tree.nodes.len()).map(NodeId::from);
        let count = leaves.len() as u64;
        let ways =
            nodes().filter(|node| mission.tree.nodes[mission.tree.topology.parent(*node).index()] == NodeKind::Or);
        // Every time a node begins anew counts as progress for what is below it.
        let anew: u64 = nodes().map(times).sum();
        let outside = (case.plan.changes.len() + case.plan.services.len() + 1) as u64;
        let progress = outside + leaves.iter().map(|leaf| times(*leaf)).sum::<u64>() + anew + 1;
        let once = leaves.iter().map(|leaf| 2 * kept(*leaf) + 1).sum::<u64>() + ways.count() as u64;
        let keepers = leaves.iter().filter(|leaf| kept(**leaf) > 0).count() as u64;
        // Who is sent back may take along who kept something for an intention.
        let reopenings = progress * once * (1 + keepers) + anew;
        // A cleanup is done for every attempt and every way that is left.
        let cleanups = mission.tree.topology.cleanups().len() as u64;
        let grants: u64 =
            leaves.iter().map(|leaf| times(*leaf) * retries(*leaf)).sum::<u64>() + cleanups * count * progress;
        // Each attempt may wait, take too long, and be awaited.
        let told = 2 * outside + 3 * (grants + anew);
        let mut levels: Vec<i32> = nodes().map(|node| mission.tree.priority(node)).collect();
        levels.sort_unstable();
        levels.dedup();
        let urged = (levels.len() * mission.tree.nodes.len()) as u64;
        let quiet = (urged + 3) * (count + 1);
        Self { grants, reopenings, told, leaves: count, quiet }
    }

    /// How often a node begins: the iterations and attempts of all that is above it, and its own.
    fn times(case: &Case, node: NodeId) -> u64 {
        let tree = &case.mission.tree;
        let until = case.plan.cancel.map_or(Duration::ZERO, |at| Duration::from_micros(at.0)) + Duration::from_secs(10);
        let product = tree.topology.path(node).take_while(|above| above.0 > 0).map(|above| {
            let iterations = tree.repeats.get(&above).map_or(1, |repeat| match (repeat.times, repeat.every) {
                (Some(times), _) => u64::from(times),
                (None, every) => (until.as_millis() / every.expect("it rests").as_millis()) as u64 + 2,
            });
            iterations * u64::from(tree.limits(above).retries + 1)
        });
        product.product()
    }

    /// Most rounds: each follows on something that came, was granted, ended, or began anew, or is a quiet one behind it.
    fn rounds(&self, interruptions: u64) -> u64 {
        let grants = self.grants + self.reopenings + interruptions;
        (1 + self.quiet) * (1 + self.told + 2 * grants + self.reopenings + self.leaves)
    }
}
