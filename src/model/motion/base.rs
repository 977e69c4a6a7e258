//! A base that drives in any direction: straight from way point to way point, turning on the way, at rest at each.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector3};

use super::device::Calling;
use super::profile::Limits;
use super::trajectory::{Leg, Mover};
use super::{Command, Controller, ControllerState, Progress};
use crate::{BaseSpec, ControllerKind, Mode, Pose, Rejection};

/// A simulated base.
#[derive(Debug, Clone)]
pub struct Base {
    spec: BaseSpec,
    mover: Mover<3>,
    calling: Calling,
}

impl Base {
    /// At rest in the origin of the map.
    pub fn new(spec: BaseSpec) -> Self {
        Self { spec, mover: Mover::at(Vector3::zeros()), calling: Calling::default() }
    }

    fn drive(&mut self, path: &[Pose], mode: Mode) -> Result<(), Rejection> {
        if mode == Mode::Maintain {
            return Err(Rejection::Unsupported);
        }
        if path.is_empty() {
            return Err(Rejection::Malformed);
        }
        let mut from = self.mover.position();
        let mut legs = Vec::with_capacity(path.len());
        for pose in path {
            let to = coordinates(pose);
            if !to.iter().all(|value| value.is_finite()) {
                return Err(Rejection::NotFinite);
            }
            let leg = self.leg(from, to);
            from = leg.to();
            legs.push(leg);
        }
        self.mover.follow(legs, mode)
    }

    fn leg(&self, mut from: Vector3<f64>, to: Vector3<f64>) -> Leg<3> {
        // The same direction under another number, so that the shorter turn ends at the very heading asked for.
        from.z = to.z - shorter_turn(to.z - from.z);
        let driving = Limits { speed: self.spec.speed, acceleration: self.spec.acceleration };
        let turning = Limits { speed: self.spec.turn_speed, acceleration: self.spec.turn_acceleration };
        Leg::wait(from, 0.0).with(0..2, to, driving).with(2..3, to, turning)
    }
}

impl Controller for Base {
    fn configure(&mut self, limits: &ControllerKind, start: ControllerState) -> ControllerState {
        if let ControllerKind::Base(spec) = limits {
            self.spec = *spec;
        }
        let at = match start {
            ControllerState::Base { pose, .. } => coordinates(&pose),
            ControllerState::Arm { .. } | ControllerState::Head { .. } | ControllerState::Device => {
                self.mover.position()
            }
        };
        (self.mover, self.calling) = (Mover::at(at), Calling::default());
        self.state()
    }

    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
        if self.mover.is_busy() || self.calling.is_busy() {
            return Err(Rejection::Busy);
        }
        match command {
            Command::Drive { path, .. } => self.drive(path, mode),
            Command::Stand => self.mover.follow(vec![Leg::wait(self.mover.position(), 0.0)], mode),
            Command::Call(call) => {
                self.calling.begin(call, mode);
                Ok(())
            }
            Command::Grasp { .. } | Command::Put { .. } | Command::Look { .. } => Err(Rejection::Unsupported),
        }
    }

    fn cancel(&mut self) {
        self.calling.cancel();
        self.mover.cancel();
    }

    fn step(&mut self) -> Progress {
        self.calling.step().unwrap_or_else(|| self.mover.step().progress)
    }

    fn state(&self) -> ControllerState {
        let at = self.mover.position();
        ControllerState::Base { pose: Pose::new(at.x, at.y, at.z), velocity: self.mover.velocity() }
    }
}

fn coordinates(pose: &Pose) -> Vector3<f64> {
    let Point2 { coords } = pose.at;
    Vector3::new(coords.x, coords.y, pose.heading)
}

/// The same turn, at most half a circle; radians.
fn shorter_turn(turn: f64) -> f64 {
    turn - TAU * (turn / TAU).round()
}
