//! What the random trees came to.

use std::collections::BTreeMap;
use std::fmt;

use ambidex::model::{Cause, Consequences, End, MissionEnd, MissionSpec, Origin, Reason, Record, Reopened, StopCause};

/// Sums over many trees.
#[derive(Debug, Default)]
pub struct Counts {
    trees: u64,
    ends: BTreeMap<&'static str, u64>,
    reasons: BTreeMap<String, u64>,
    rounds: u64,
    most_rounds: u64,
    grants: u64,
    side_by_side: u64,
    skips: u64,
    lapses: u64,
    went_back: u64,
    failures: u64,
    pub rechoices: u64,
    /// What happened beside rounds and ends, by name.
    others: BTreeMap<String, u64>,
}

/// Made elsewhere: a leaf whose turn has not come is not activated.
const NOT_OF_THE_CORE: [&str; 1] = ["NotItsTurn"];
const REASONS: [&str; 27] = [
    "Satisfied",
    "Held",
    "NoneFree",
    "OutOfReach",
    "NotHeld",
    "Taken",
    "Elsewhere",
    "NotAt",
    "Driving",
    "NoPath",
    "Fact",
    "NothingAvailable",
    "AlreadyDone",
    "Outbid",
    "SameObject",
    "Clash",
    "Alternative",
    "WholeRobot",
    "Ending",
    "OutOfTime",
    "BackingOff",
    "LessUrgent",
    "DoneOftener",
    "Reserved",
    "NotYet",
    "GivenUp",
    "TooEarly",
];
/// What happens beside rounds and ends.
const OTHERS: [&str; 25] = [
    "infeasible Missing",
    "timed out",
    "retry",
    "leave",
    "done by others",
    "unfit",
    "cancels",
    "finishes",
    "preempted",
    "broken",
    "interrupted",
    "yields",
    "urged",
    "repeats",
    "overdue",
    "leaves after cleanup",
    "cleanups begun",
    "cleanups done",
    "cleanups failed",
    "repeats without end",
    "repeats in a cleanup",
    "changed by an operator",
    "changed by a controller",
    "denied an operator",
    "denied a controller",
];

/// The name of a reason's variant.
pub fn variant(reason: &Reason) -> String {
    let text = format!("{reason:?}");
    text.split([' ', '{']).next().unwrap_or_default().to_owned()
}

impl Counts {
    pub fn of(mission: &MissionSpec, records: &[Record], end: Option<MissionEnd>) -> Self {
        let mut counts = Self { trees: 1, ..Self::default() };
        let end = match end {
            Some(MissionEnd::Done) => "done",
            Some(MissionEnd::Failed(_)) => "failed",
            Some(MissionEnd::Stalled) => "stalled",
            Some(MissionEnd::Canceled) => "canceled",
            Some(MissionEnd::ControllerLost(_) | MissionEnd::NotAttached) => "otherwise",
            Some(MissionEnd::NodeLost(_) | MissionEnd::TaskLost) | None => "otherwise",
        };
        counts.ends.insert(end, 1);
        for record in records {
            counts.count(record);
            counts.count_repeat(mission, record);
        }
        counts.most_rounds = counts.rounds;
        counts
    }

    fn count(&mut self, record: &Record) {
        match record {
            Record::Decided { .. } => self.count_decision(record),
            Record::Released { end, consequences, unfit, .. } => {
                self.count_other("interrupted", *end == End::Interrupted);
                let is_cleaned = consequences.cleaned.is_some();
                self.count_other("cleanups done", is_cleaned && *end == End::Succeeded);
                self.count_other("cleanups failed", is_cleaned && *end != End::Succeeded);
                self.failures += u64::from(consequences.failed.is_some());
                self.count_failing(consequences);
                self.count_other("unfit", !unfit.is_empty());
            }
            Record::Infeasible { reason, consequences, .. } => {
                self.count_failing(consequences);
                self.count_other(&format!("infeasible {}", variant(reason)), true);
            }
            Record::Added { .. } | Record::Removed { .. } | Record::Granting { .. } => {}
            Record::Canceled { .. } | Record::TaskEnded { .. } | Record::Stalled { .. } => {}
            Record::ObjectAdded { .. }
            | Record::ObjectRemoved { .. }
            | Record::Declined { .. }
            | Record::Checkpoint { .. } => {}
            Record::TimedOut { consequences, .. } => {
                self.count_failing(consequences);
                self.count_other("timed out", true);
            }
            Record::Reopened { reopened, .. } => {
                let what = match reopened.cause {
                    Cause::Retry { .. } => "retry",
                    Cause::Repeat { .. } => "repeats",
                    Cause::Yield => "yields",
                    Cause::Leave | Cause::Lapse { .. } | Cause::Redo { .. } => "leave",
                };
                self.count_other(what, true);
            }
            Record::Overtaken { .. } => self.count_other("done by others", true),
            Record::Told { .. } | Record::Observed { .. } | Record::Turn { .. } | Record::Began { .. } => {}
            Record::Stopped { leaves, cause, .. } => {
                let what = match cause {
                    StopCause::Ends => "told to end",
                    StopCause::Broken(_) => "broken",
                    StopCause::Preempted { .. } => "preempted",
                };
                leaves.iter().for_each(|_| self.count_other(what, true));
            }
            Record::Ending { .. } => self.count_other("told to finish", true),
            Record::Leaving { .. } => self.count_other("leaves after cleanup", true),
            Record::Cleaning { .. } => self.count_other("cleanups begun", true),
            Record::Cleaned { is_done, .. } => {
                self.count_other(if *is_done { "cleanups done" } else { "cleanups failed" }, true);
            }
            Record::World { origin, .. } => self.count_origin("changed by", *origin),
            Record::Denied { origin, .. } => self.count_origin("denied", *origin),
            Record::Header(_)
            | Record::Sent { .. }
            | Record::Resource { .. }
            | Record::Woke { .. }
            | Record::Served { .. }
            | Record::Awaited { .. } => {}
            Record::Controller { .. } | Record::Ended { .. } => {}
        }
    }

    fn count_decision(&mut self, record: &Record) {
        let Record::Decided { granted, refused, reopened, urged, overdue, .. } = record else { return };
        self.count_other("urged", urged.as_ref().is_some_and(|urged| !urged.is_empty()));
        self.count_other("overdue", overdue.as_ref().is_some_and(|overdue| !overdue.is_empty()));
        self.rounds += 1;
        self.grants += granted.len() as u64;
        self.side_by_side += u64::from(granted.len() > 1);
        self.skips += granted.iter().map(|grant| grant.request.skips.len() as u64).sum::<u64>();
        for blocked in refused {
            *self.reasons.entry(variant(&blocked.reason)).or_default() += 1;
        }
        if let Some(reopened) = reopened {
            self.lapses += u64::from(reopened.lapsed().is_some());
            self.went_back += u64::from(reopened.lapsed().is_none());
        }
    }

    fn count_repeat(&mut self, mission: &MissionSpec, record: &Record) {
        if let Record::Reopened { reopened: Reopened { node, cause: Cause::Repeat { .. }, .. }, .. } = *record {
            let is_endless = mission.tree.repeats[&node].times.is_none();
            let topology = &mission.tree.topology;
            self.count_other("repeats without end", is_endless);
            self.count_other("repeats in a cleanup", topology.is_cleanup(node) || topology.is_in_cleanup(node));
        }
    }

    fn count_origin(&mut self, what: &str, origin: Origin) {
        let who = match origin {
            Origin::Operator => "an operator",
            Origin::Controller(_) => "a controller",
            Origin::Script | Origin::Dropped | Origin::Resumed => "a file",
        };
        self.count_other(&format!("{what} {who}"), true);
    }

    fn count_failing(&mut self, consequences: &Consequences) {
        let failing = consequences.failing;
        self.count_other("cancels", failing.is_some_and(|failing| !failing.finishes));
        self.count_other("finishes", failing.is_some_and(|failing| failing.finishes));
    }

    fn count_other(&mut self, name: &str, is_so: bool) {
        *self.others.entry(name.to_owned()).or_default() += u64::from(is_so);
    }

    /// How many trees stalled.
    pub fn stalled(&self) -> u64 {
        self.ends.get("stalled").copied().unwrap_or_default()
    }

    /// How often a reason of this name was told.
    pub fn told(&self, reason: &str) -> u64 {
        self.reasons.get(reason).copied().unwrap_or_default()
    }

    pub fn plus(mut self, other: Self) -> Self {
        self.trees += other.trees;
        for (end, count) in other.ends {
            *self.ends.entry(end).or_default() += count;
        }
        for (reason, count) in other.reasons {
            *self.reasons.entry(reason).or_default() += count;
        }
        self.rounds += other.rounds;
        self.most_rounds = self.most_rounds.max(other.most_rounds);
        self.grants += other.grants;
        self.side_by_side += other.side_by_side;
        self.skips += other.skips;
        self.lapses += other.lapses;
        self.went_back += other.went_back;
        self.failures += other.failures;
        self.rechoices += other.rechoices;
        for (name, count) in other.others {
            *self.others.entry(name).or_default() += count;
        }
        self
    }

    /// The trees are worth running: two in five at least are done, and everything that can happen does.
    pub fn check_spread(&self) {
        let done = self.ends.get("done").copied().unwrap_or_default();
        let canceled = self.ends.get("canceled").copied().unwrap_or_default();
        assert!(done * 5 >= (self.trees - canceled) * 2, "only {done} of {} are done", self.trees);
        for reason in REASONS {
            assert!(self.reasons.contains_key(reason), "{reason} never occurs");
        }
        for other in OTHERS {
            assert!(self.others.get(other).is_some_and(|count| *count > 0), "{other} never occurs");
        }
        for reason in NOT_OF_THE_CORE {
            assert!(!self.reasons.contains_key(reason), "{reason} occurs");
        }
        let [lapses, back, skips, again] = [self.lapses, self.went_back, self.skips, self.rechoices];
        assert!(lapses > 0 && back > 0 && skips > 0 && again > 0, "{self}");
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { trees, ends, reasons, rounds, most_rounds, grants, .. } = self;
        writeln!(f, "{trees} trees, ends {ends:?}")?;
        writeln!(
            f,
            "  {rounds} rounds (at most {most_rounds} in a tree), {grants} grants, {} rounds with several",
            self.side_by_side
        )?;
        let Self { skips, lapses, went_back, rechoices, failures, .. } = self;
        writeln!(
            f,
            "  skips {skips}, lapses {lapses}, go-backs {went_back}, OR re-choices {rechoices}, failures {failures}"
        )?;
        writeln!(f, "  beside that {:?}", self.others)?;
        write!(f, "  reasons {reasons:?}")
    }
}
