//! A device that moves nothing and reports what it sees.

use ambidex::model::{ControllerKind, Mode, Rejection};
use ambidex::motion::{Command, Controller, ControllerState, Progress, Report};

/// Reports what it is told to see.
pub struct Sensor<F>(pub F);

impl<F: Fn() -> Vec<Report> + Send> Controller for Sensor<F> {
    fn configure(&mut self, _limits: &ControllerKind, _start: ControllerState) -> ControllerState {
        self.state()
    }

    fn start(&mut self, _command: &Command, _mode: Mode) -> Result<(), Rejection> {
        Err(Rejection::Unsupported)
    }

    fn cancel(&mut self) {}

    fn step(&mut self) -> Progress {
        Progress::Idle
    }

    fn state(&self) -> ControllerState {
        ControllerState::Device
    }

    fn reports(&self) -> Vec<Report> {
        self.0()
    }
}
