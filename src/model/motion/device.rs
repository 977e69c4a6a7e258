//! A device that does what its robot file says that it offers: each call takes its time. Arms, bases and heads do theirs
//! with the same clockwork.

use std::time::Duration;

use super::{Command, Controller, ControllerState, Progress, STEP};
use crate::{Call, ControllerKind, Mode, PartEnd, Rejection};

/// A call that is under way, or none.
#[derive(Debug, Clone, Default)]
pub(super) struct Calling(Option<Active>);

#[derive(Debug, Clone)]
struct Active {
    takes: Duration,
    passed: Duration,
    mode: Mode,
    is_canceled: bool,
}

impl Calling {
    /// Begins a call, which lasts for its time or until it is canceled.
    pub(super) fn begin(&mut self, call: &Call, mode: Mode) {
        self.0 = Some(Active { takes: call.takes, passed: Duration::ZERO, mode, is_canceled: false });
    }

    pub(super) fn is_busy(&self) -> bool {
        self.0.is_some()
    }

    pub(super) fn cancel(&mut self) {
        if let Some(active) = &mut self.0 {
            active.is_canceled = true;
        }
    }

    /// Moves on by a step; none without a call.
    pub(super) fn step(&mut self) -> Option<Progress> {
        let active = self.0.as_mut()?;
        active.passed += STEP;
        let end = match (active.is_canceled, active.mode) {
            (true, _) => PartEnd::Canceled,
            (false, Mode::Maintain) => return Some(Progress::Running(1.0)),
            (false, Mode::Achieve) if active.passed >= active.takes => PartEnd::Succeeded,
            (false, Mode::Achieve) => {
                return Some(Progress::Running(active.passed.as_secs_f64() / active.takes.as_secs_f64()));
            }
        };
        self.0 = None;
        Some(Progress::Ended(end))
    }
}

/// A simulated device.
#[derive(Debug, Clone, Default)]
pub struct Device {
    calling: Calling,
}

impl Device {
    /// With nothing to do.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Controller for Device {
    fn configure(&mut self, _limits: &ControllerKind, _start: ControllerState) -> ControllerState {
        self.calling = Calling::default();
        self.state()
    }

    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
        if self.calling.is_busy() {
            return Err(Rejection::Busy);
        }
        match command {
            Command::Call(call) => {
                self.calling.begin(call, mode);
                Ok(())
            }
            Command::Drive { .. }
            | Command::Stand
            | Command::Grasp { .. }
            | Command::Put { .. }
            | Command::Look { .. } => Err(Rejection::Unsupported),
        }
    }

    fn cancel(&mut self) {
        self.calling.cancel();
    }

    fn step(&mut self) -> Progress {
        self.calling.step().unwrap_or(Progress::Idle)
    }

    fn state(&self) -> ControllerState {
        ControllerState::Device
    }
}
