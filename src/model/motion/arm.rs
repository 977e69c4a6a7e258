//! An arm with a gripper: reach, grip, lift and tuck, in straight lines of the gripper.

use nalgebra::{Point3, SVector, Vector3};

use super::device::Calling;
use super::profile::Limits;
use super::trajectory::{Leg, Mover};
use super::{Command, Controller, ControllerState, Progress};
use crate::{ArmSpec, ControllerKind, Mode, Name, Rejection};

/// The leg at the end of which the gripper has closed or opened.
const GRIP_LEG: usize = 1;

/// A simulated arm.
#[derive(Debug, Clone)]
pub struct Arm {
    spec: ArmSpec,
    mover: Mover<3>,
    holds: Option<Name>,
    will_hold: Option<Name>,
    calling: Calling,
}

impl Arm {
    /// Tucked, with nothing in the gripper.
    pub fn new(spec: ArmSpec) -> Self {
        Self { mover: Mover::at(spec.tuck.coords), spec, holds: None, will_hold: None, calling: Calling::default() }
    }

    fn work_at(&mut self, at: Point3<f64>, mode: Mode, will_hold: Option<Name>) -> Result<(), Rejection> {
        if mode == Mode::Maintain {
            return Err(Rejection::Unsupported);
        }
        if !at.coords.iter().all(|value| value.is_finite()) {
            return Err(Rejection::NotFinite);
        }
        // Asked this way round, so that a distance that is not a number is out of reach too.
        let within = (at - self.spec.shoulder).norm() <= self.spec.reach_m;
        if !within {
            return Err(Rejection::OutOfReach);
        }
        let above = Point3::new(at.x, at.y, at.z + self.lift_m(at));
        let reach = self.straight(self.mover.position(), at.coords);
        let grip = Leg::wait(at.coords, self.spec.grip_s);
        let lift = self.straight(at.coords, above.coords);
        let tuck = self.straight(above.coords, self.spec.tuck.coords);
        self.mover.follow(vec![reach, grip, lift, tuck], mode)?;
        self.will_hold = will_hold;
        Ok(())
    }

    /// How far it can lift from there without leaving its reach, meters.
    fn lift_m(&self, at: Point3<f64>) -> f64 {
        let from_shoulder = at - self.spec.shoulder;
        let aside = from_shoulder.xy().norm_squared();
        let top = (self.spec.reach_m * self.spec.reach_m - aside).max(0.0).sqrt();
        (top - from_shoulder.z).clamp(0.0, self.spec.lift_m.max(0.0))
    }

    fn straight(&self, from: SVector<f64, 3>, to: SVector<f64, 3>) -> Leg<3> {
        let limits = Limits { speed: self.spec.speed, acceleration: self.spec.acceleration };
        Leg::wait(from, 0.0).with(0..3, to, limits)
    }
}

impl Controller for Arm {
    fn configure(&mut self, limits: &ControllerKind, start: ControllerState) -> ControllerState {
        if let ControllerKind::Arm(spec) = limits {
            self.spec = *spec;
        }
        let (at, holds) = match start {
            ControllerState::Arm { gripper, holds, .. } => (gripper.coords, holds),
            ControllerState::Base { .. } | ControllerState::Head { .. } | ControllerState::Device => {
                (self.mover.position(), self.holds)
            }
        };
        self.mover = Mover::at(at);
        (self.holds, self.calling) = (holds, Calling::default());
        self.state()
    }

    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
        if self.mover.is_busy() || self.calling.is_busy() {
            return Err(Rejection::Busy);
        }
        match command {
            Command::Grasp { object, at, .. } => match self.holds {
                Some(_) => Err(Rejection::Busy),
                None => self.work_at(*at, mode, Some(*object)),
            },
            Command::Put { object, at, .. } if self.holds == Some(*object) => self.work_at(*at, mode, None),
            Command::Call(call) => {
                self.calling.begin(call, mode);
                Ok(())
            }
            Command::Stand => self.mover.follow(vec![Leg::wait(self.mover.position(), 0.0)], mode),
            Command::Put { .. } | Command::Drive { .. } | Command::Look { .. } => Err(Rejection::Unsupported),
        }
    }

    fn cancel(&mut self) {
        self.calling.cancel();
        self.mover.cancel();
    }

    fn step(&mut self) -> Progress {
        if let Some(progress) = self.calling.step() {
            return progress;
        }
        let stepped = self.mover.step();
        if stepped.passed == Some(GRIP_LEG) {
            self.holds = self.will_hold;
        }
        stepped.progress
    }

    fn state(&self) -> ControllerState {
        let velocity: Vector3<f64> = self.mover.velocity();
        ControllerState::Arm { gripper: Point3::from(self.mover.position()), velocity, holds: self.holds }
    }
}
