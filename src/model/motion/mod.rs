//! Motion of arm, base and head as step functions of robot time: the same in a controller process and in a simulation.

mod arm;
mod base;
mod device;
mod executor;
mod head;
mod profile;
#[cfg(test)]
mod tests;
mod trajectory;

use std::time::Duration;

pub use arm::Arm;
pub use base::Base;
pub use device::Device;
pub use executor::Executor;
pub use head::Head;

pub use crate::Report;
use crate::{ControllerKind, Inhibition, Mode, Name, PartEnd, Rejection};

/// What a controller is told to do; objects, places and resources have their names.
pub type Command = crate::Command<Name, Name, Name>;
/// State of a controller, with the name of what it holds.
pub type ControllerState = crate::ControllerState<Name>;
/// What a controller is told.
pub type ToController = crate::ToController<Name, Name, Name>;
/// What a controller says.
pub type FromController = crate::FromController<Name>;

/// One step of robot time. Motion is computed in such steps at any speed, so that the path is always the same.
pub const STEP: Duration = Duration::from_millis(10);

/// A controller, as the runtime sees it: one command at a time, stepped in robot time.
///
/// Implement it to attach a robot of your own and hand it to `ambidex_link::serve`.
pub trait Controller {
    /// Takes the daemon's limits and its idea of the start state, and answers with the true state.
    ///
    /// A simulated controller goes where it is told; a real one ignores `start` and reports itself. Limits of another
    /// kind than its own are not for it.
    fn configure(&mut self, limits: &ControllerKind, start: ControllerState) -> ControllerState;

    /// Begins a command.
    ///
    /// # Errors
    /// Why it cannot: the runtime fails the behavior with it.
    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection>;

    /// Told to end the command: brakes within its limits, and ends with [`PartEnd::Canceled`].
    fn cancel(&mut self);

    /// Moves on by [`STEP`].
    fn step(&mut self) -> Progress;

    /// State at the end of the last step.
    fn state(&self) -> ControllerState;

    /// Why it may not move at present; none if it may. Asked in every step while a command is under way, else several times
    /// a second; it must not block.
    ///
    /// What is under way ends with that, and is not stepped any more: whoever is inhibited stands, or is brought to stand
    /// by what inhibits it. Once it may move again it is configured anew.
    fn inhibited(&self) -> Option<Inhibition> {
        None
    }

    /// All that it sees of the world beyond what it moves, as far as the robot file lets it report; nothing by default.
    /// Asked several times a second while it is attached; it must not block. What is new is told at once, the rest once
    /// more every second.
    fn reports(&self) -> Vec<Report> {
        Vec::new()
    }
}

/// What became of a command in one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress {
    /// Nothing is under way.
    Idle,
    /// Under way, from 0 to 1; a command that is maintained stays at 1.
    Running(f64),
    /// It ended in this step.
    Ended(PartEnd),
}

/// A simulated controller of that kind: pure, and the same at any speed.
pub fn simulated(kind: &ControllerKind) -> Box<dyn Controller + Send> {
    match *kind {
        ControllerKind::Arm(spec) => Box::new(Arm::new(spec)),
        ControllerKind::Base(spec) => Box::new(Base::new(spec)),
        ControllerKind::Head(spec) => Box::new(Head::new(spec)),
        ControllerKind::Device => Box::new(Device::new()),
    }
}
