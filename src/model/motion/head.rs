//! A head that pans and tilts towards a point, each axis as fast as it can.

use nalgebra::{Point3, Vector2};

use super::device::Calling;
use super::profile::Limits;
use super::trajectory::{Leg, Mover};
use super::{Command, Controller, ControllerState, Progress};
use crate::{ControllerKind, HeadSpec, Mode, Rejection};

/// A simulated head.
#[derive(Debug, Clone)]
pub struct Head {
    spec: HeadSpec,
    mover: Mover<2>,
    calling: Calling,
}

impl Head {
    /// Looking straight ahead.
    pub fn new(spec: HeadSpec) -> Self {
        Self { spec, mover: Mover::at(Vector2::zeros()), calling: Calling::default() }
    }

    fn look(&mut self, at: Point3<f64>, mode: Mode) -> Result<(), Rejection> {
        let to = angles(self.spec.neck, at);
        if !to.iter().all(|value| value.is_finite()) {
            return Err(Rejection::NotFinite);
        }
        let limits = Limits { speed: self.spec.speed, acceleration: self.spec.acceleration };
        let leg = Leg::wait(self.mover.position(), 0.0).with(0..1, to, limits).with(1..2, to, limits);
        self.mover.follow(vec![leg], mode)
    }
}

impl Controller for Head {
    fn configure(&mut self, limits: &ControllerKind, start: ControllerState) -> ControllerState {
        if let ControllerKind::Head(spec) = limits {
            self.spec = *spec;
        }
        let at = match start {
            ControllerState::Head { angles, .. } => Vector2::from(angles),
            ControllerState::Base { .. } | ControllerState::Arm { .. } | ControllerState::Device => {
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
            Command::Look { at, .. } => self.look(*at, mode),
            Command::Call(call) => {
                self.calling.begin(call, mode);
                Ok(())
            }
            Command::Stand => self.mover.follow(vec![Leg::wait(self.mover.position(), 0.0)], mode),
            Command::Drive { .. } | Command::Grasp { .. } | Command::Put { .. } => Err(Rejection::Unsupported),
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
        ControllerState::Head { angles: self.mover.position().into(), velocity: self.mover.velocity().into() }
    }
}

/// Pan to the left and tilt downwards, radians.
fn angles(neck: Point3<f64>, at: Point3<f64>) -> Vector2<f64> {
    let way = at - neck;
    Vector2::new(way.y.atan2(way.x), (-way.z).atan2(way.xy().norm()))
}
