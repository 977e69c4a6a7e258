//! What became of one leaf.

use ambidex_model::{End, Fault, NodeId, Reason, Reopened, StopCause, Time};
use serde::{Deserialize, Serialize};

/// What a node of the task is at a moment.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Serialize,
    Deserialize,
    strum::IntoStaticStr,
    strum::VariantArray,
)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "lowercase")]
pub enum LeafState {
    /// It has not run, or is to run again.
    Waiting,
    /// It runs.
    Active,
    /// It ran and is done.
    Done,
    /// It is done without having run.
    Skipped,
    /// It failed and is not tried again.
    Failed,
    /// It was told to end.
    Canceled,
    /// It is not to run any more: a node above it failed.
    #[strum(serialize = "not asked")]
    NotAsked,
    /// It is not to run any more: a node above it is done without it.
    #[strum(serialize = "not needed")]
    NotNeeded,
}

impl LeafState {
    /// What a person calls it.
    pub fn word(self) -> &'static str {
        self.into()
    }

    /// Whether nothing at or below it needs to run any more, since its goal is met.
    pub fn is_done(self) -> bool {
        matches!(self, Self::Done | Self::Skipped)
    }

    /// Whether it is neither done nor runs.
    pub fn is_open(self) -> bool {
        !self.is_done() && self != Self::Active
    }
}

/// What a leaf is from some moment on, and how it came to be so.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Phase {
    /// It has not run.
    #[default]
    Waiting,
    /// It runs.
    Active,
    /// It ran and is done.
    Done,
    /// It is done without having run.
    Skipped,
    /// It failed, for now or for good.
    Failed {
        /// What went wrong.
        fault: Fault,
        /// Whether it is not asked again.
        is_final: bool,
    },
    /// It can never run, and has failed for that.
    Infeasible,
    /// Others did what it was to do.
    Overtaken,
    /// An OR above left its way.
    Left,
    /// It was told to end.
    Canceled,
    /// It was done and is not any more, or it was interrupted when its runtime was gone.
    Reopened,
    /// It was interrupted for a more urgent behavior.
    Preempted {
        /// That one.
        by: NodeId,
    },
    /// It was interrupted since something is not so any more that is to last.
    Broken,
    /// A node above it is done once more.
    Again,
    /// A node above it failed.
    NotAsked,
    /// A node above it is done without it.
    NotNeeded,
}

impl Phase {
    /// The state without its past.
    pub fn state(self) -> LeafState {
        match self {
            Self::Waiting | Self::Reopened | Self::Left | Self::Failed { is_final: false, .. } => LeafState::Waiting,
            Self::Preempted { .. } | Self::Broken | Self::Again => LeafState::Waiting,
            Self::Active => LeafState::Active,
            Self::Done => LeafState::Done,
            Self::Skipped | Self::Overtaken => LeafState::Skipped,
            Self::Failed { is_final: true, .. } | Self::Infeasible => LeafState::Failed,
            Self::Canceled => LeafState::Canceled,
            Self::NotAsked => LeafState::NotAsked,
            Self::NotNeeded => LeafState::NotNeeded,
        }
    }

    /// What the end of a run leads to.
    pub(super) fn ended(end: End, is_final: bool, cause: Option<&StopCause>) -> Self {
        match (end, cause) {
            (End::Interrupted, Some(StopCause::Preempted { by })) => return Self::Preempted { by: *by },
            (End::Interrupted, Some(StopCause::Broken(_))) => return Self::Broken,
            (End::Interrupted, Some(StopCause::Ends) | None) => {}
            (End::Succeeded | End::Failed(_) | End::Canceled, _) => {}
        }
        match end {
            End::Succeeded => Self::Done,
            End::Failed(fault) => Self::Failed { fault, is_final },
            End::Canceled => Self::Canceled,
            End::Interrupted => Self::Reopened,
        }
    }
}

/// How often a leaf failed, and at what it did last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Failures {
    /// How many of its runs failed.
    pub times: u32,
    /// When the last one did.
    pub at: Time,
    /// What went wrong then.
    pub fault: Fault,
}

/// What became of one leaf.
#[derive(Debug, Clone, Default)]
pub struct LeafHistory {
    pub(super) phase: Phase,
    pub(super) since: Time,
    /// The place of its phase among those of all leaves.
    pub(super) order: u64,
    pub(super) reason: Option<Reason>,
    pub(super) last_end: Option<End>,
    pub(super) failures: Option<Failures>,
    pub(super) reopened: Option<Reopened>,
    pub(super) phases: Vec<(Time, Phase)>,
}

impl LeafHistory {
    /// What it is now.
    pub fn state(&self) -> LeafState {
        self.phase.state()
    }

    /// Whether it ever ran.
    pub fn has_run(&self) -> bool {
        self.phase == Phase::Active || self.last_end.is_some()
    }

    /// Since when it is so.
    pub fn since(&self) -> Time {
        self.since
    }

    /// Why it was not granted when it was asked last; none since it was granted.
    pub fn reason(&self) -> Option<&Reason> {
        self.reason.as_ref()
    }

    /// How its last run ended, if that has ended.
    pub fn last_end(&self) -> Option<End> {
        self.last_end
    }

    /// Its failures, if it ever failed.
    pub fn failures(&self) -> Option<Failures> {
        self.failures
    }

    /// What it counts as done no more for, until it runs or is skipped.
    pub fn reopened(&self) -> Option<&Reopened> {
        self.reopened.as_ref()
    }

    /// From when on it was what, behind waiting from the beginning; empty where the past is not kept.
    pub fn phases(&self) -> &[(Time, Phase)] {
        &self.phases
    }

    pub(super) fn enter(&mut self, at: Time, phase: Phase, order: u64, keeps_past: bool) {
        (self.phase, self.since, self.order) = (phase, at, order);
        if phase != Phase::Reopened {
            self.reopened = None;
        }
        if keeps_past {
            self.phases.push((at, phase));
        }
    }

    pub(super) fn fail(&mut self, at: Time, fault: Fault) {
        let times = self.failures.map_or(0, |failures| failures.times) + 1;
        self.failures = Some(Failures { times, at, fault });
    }

    /// Nothing is tried again after the mission.
    pub(super) fn give_up(&mut self) {
        if let Phase::Failed { is_final, .. } = &mut self.phase {
            *is_final = true;
        }
        if let Some((_, Phase::Failed { is_final, .. })) = self.phases.last_mut() {
            *is_final = true;
        }
    }
}
