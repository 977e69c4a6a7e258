//! What arm, base and head share: a point of N coordinates that goes along legs, from rest to rest, one command at a time.

use std::ops::Range;

use nalgebra::SVector;

use super::profile::{Limits, Profile};
use super::{Progress, STEP};
use crate::{Mode, PartEnd, Rejection};

/// More than a leg of any sane goal takes: two years of robot time.
const MAX_LEG_TICKS: f64 = 6e9;

/// One coordinate of a leg: `share` of the length that `profile` has come.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Axis {
    profile: Profile,
    share: f64,
}

/// A straight motion of all coordinates that begins and ends at rest, or a wait.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Leg<const N: usize> {
    from: SVector<f64, N>,
    to: SVector<f64, N>,
    axes: [Axis; N],
    duration_s: f64,
}

impl<const N: usize> Leg<N> {
    /// Stays for a time.
    pub(super) fn wait(at: SVector<f64, N>, duration_s: f64) -> Self {
        let axis = Axis { profile: Profile::STILL, share: 0.0 };
        Self { from: at, to: at, axes: [axis; N], duration_s }
    }

    /// Lets a group of coordinates go straight to where `to` has them, together under one limit.
    pub(super) fn with(mut self, group: Range<usize>, to: SVector<f64, N>, limits: Limits) -> Self {
        let way = to - self.from;
        let square: f64 = group.clone().map(|axis| way[axis] * way[axis]).sum();
        let length = square.sqrt();
        let profile = Profile::over(length, limits);
        self.duration_s = self.duration_s.max(profile.duration_s());
        for axis in group {
            self.to[axis] = to[axis];
            let share = if length > 0.0 { way[axis] / length } else { 0.0 };
            self.axes[axis] = Axis { profile, share };
        }
        self
    }

    /// Where it ends.
    pub(super) fn to(&self) -> SVector<f64, N> {
        self.to
    }

    /// Steps that it takes; at least one, so that every leg is seen to end.
    fn ticks(&self) -> Result<u64, Rejection> {
        let ticks = (self.duration_s / STEP.as_secs_f64()).ceil().max(1.0);
        if ticks <= MAX_LEG_TICKS { Ok(ticks as u64) } else { Err(Rejection::Malformed) }
    }

    fn at(&self, time_s: f64) -> (SVector<f64, N>, SVector<f64, N>) {
        let mut position = self.from;
        let mut velocity = SVector::zeros();
        for (index, axis) in self.axes.iter().enumerate() {
            let (come, speed) = axis.profile.at(time_s);
            position[index] += axis.share * come;
            velocity[index] = axis.share * speed;
        }
        (position, velocity)
    }

    fn braked_at(&self, time_s: f64) -> Self {
        let from = self.at(time_s).0;
        let mut brake = Self::wait(from, 0.0);
        for (index, axis) in self.axes.iter().enumerate() {
            let profile = axis.profile.braked_at(time_s);
            brake.duration_s = brake.duration_s.max(profile.duration_s());
            brake.to[index] += axis.share * profile.length();
            brake.axes[index] = Axis { profile, ..*axis };
        }
        brake
    }
}

/// A command under way.
#[derive(Debug, Clone, PartialEq)]
struct Trajectory<const N: usize> {
    legs: Vec<(Leg<N>, u64)>,
    leg: usize,
    tick: u64,
    past_ticks: u64,
    all_ticks: u64,
    end: Finish,
}

/// What comes behind the last leg.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Finish {
    Succeed,
    Maintain,
    Cancel,
}

/// A point that follows legs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mover<const N: usize> {
    position: SVector<f64, N>,
    velocity: SVector<f64, N>,
    trajectory: Option<Trajectory<N>>,
}

/// What one step brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stepped {
    /// How the command stands.
    pub(super) progress: Progress,
    /// The leg that was completed, counted from 0.
    pub(super) passed: Option<usize>,
}

impl<const N: usize> Mover<N> {
    /// At rest.
    pub(super) fn at(position: SVector<f64, N>) -> Self {
        Self { position, velocity: SVector::zeros(), trajectory: None }
    }

    /// Where it is.
    pub(super) fn position(&self) -> SVector<f64, N> {
        self.position
    }

    /// How fast it is.
    pub(super) fn velocity(&self) -> SVector<f64, N> {
        self.velocity
    }

    /// Whether a command is under way.
    pub(super) fn is_busy(&self) -> bool {
        self.trajectory.is_some()
    }

    /// Begins to follow legs; the first begins where the point is.
    pub(super) fn follow(&mut self, legs: Vec<Leg<N>>, mode: Mode) -> Result<(), Rejection> {
        if self.is_busy() {
            return Err(Rejection::Busy);
        }
        let legs = legs.into_iter().map(|leg| leg.ticks().map(|ticks| (leg, ticks))).collect::<Result<Vec<_>, _>>()?;
        self.trajectory = Some(Trajectory {
            leg: 0,
            tick: 0,
            past_ticks: 0,
            all_ticks: legs.iter().map(|(_, ticks)| ticks).sum(),
            legs,
            end: match mode {
                Mode::Achieve => Finish::Succeed,
                Mode::Maintain => Finish::Maintain,
            },
        });
        Ok(())
    }

    /// Brakes from now on; nothing when no command is under way.
    pub(super) fn cancel(&mut self) {
        let Some(trajectory) = &mut self.trajectory else {
            return;
        };
        if trajectory.end == Finish::Cancel {
            return;
        }
        trajectory.end = Finish::Cancel;
        let brake = match trajectory.legs.get(trajectory.leg) {
            Some((leg, _)) => leg.braked_at(seconds(trajectory.tick)),
            None => Leg::wait(self.position, 0.0),
        };
        let ticks = brake.ticks().unwrap_or(1);
        trajectory.past_ticks += trajectory.tick;
        trajectory.all_ticks = trajectory.all_ticks.max(trajectory.past_ticks + ticks);
        trajectory.legs.truncate(trajectory.leg);
        trajectory.legs.push((brake, ticks));
        trajectory.tick = 0;
    }

    /// Moves on by one step.
    pub(super) fn step(&mut self) -> Stepped {
        let Some(trajectory) = &mut self.trajectory else {
            return Stepped { progress: Progress::Idle, passed: None };
        };
        let (sample, passed) = trajectory.step();
        if let Some((position, velocity)) = sample {
            (self.position, self.velocity) = (position, velocity);
        }
        let progress = trajectory.progress();
        if let Progress::Ended(_) = progress {
            self.trajectory = None;
        }
        Stepped { progress, passed }
    }
}

type Sample<const N: usize> = (SVector<f64, N>, SVector<f64, N>);

impl<const N: usize> Trajectory<N> {
    fn step(&mut self) -> (Option<Sample<N>>, Option<usize>) {
        let Some((leg, ticks)) = self.legs.get(self.leg) else {
            return (None, None);
        };
        self.tick += 1;
        if self.tick < *ticks {
            return (Some(leg.at(seconds(self.tick))), None);
        }
        let arrived = (leg.to, SVector::zeros());
        let passed = (self.end != Finish::Cancel).then_some(self.leg);
        self.past_ticks += ticks;
        self.leg += 1;
        self.tick = 0;
        (Some(arrived), passed)
    }

    fn progress(&self) -> Progress {
        let left = self.leg < self.legs.len();
        let done = (self.past_ticks + self.tick) as f64 / self.all_ticks.max(1) as f64;
        match (left, self.end) {
            (true, Finish::Succeed | Finish::Maintain | Finish::Cancel) => Progress::Running(done),
            (false, Finish::Succeed) => Progress::Ended(PartEnd::Succeeded),
            (false, Finish::Maintain) => Progress::Running(1.0),
            (false, Finish::Cancel) => Progress::Ended(PartEnd::Canceled),
        }
    }
}

fn seconds(ticks: u64) -> f64 {
    ticks as f64 * STEP.as_secs_f64()
}
