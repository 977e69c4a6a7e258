//! A controller that does as a number says: each command takes its time, is rejected, or fails.

use ambidex::model::{ControllerKind, Mode, PartEnd, Rejection};
use ambidex::motion::{Command, Controller, ControllerState, Progress};

use crate::driver::Rng;

/// Its commands are those of the seed, one after the other.
pub struct Scripted {
    seed: u64,
    index: u64,
    commands: u64,
    active: Option<Active>,
    state: Option<ControllerState>,
}

struct Active {
    command: Command,
    /// Steps until it ends; none for one that lasts until it is canceled.
    left: Option<u32>,
    end: PartEnd,
}

impl Scripted {
    pub fn new(seed: u64, index: u64) -> Self {
        Self { seed, index, commands: 0, active: None, state: None }
    }

    /// What is so after a command that came to its end.
    fn finish(&mut self, command: &Command) {
        match (self.state.as_mut().expect("it is configured"), command) {
            (ControllerState::Base { pose, .. }, Command::Drive { path, .. }) => *pose = path[path.len() - 1],
            (ControllerState::Arm { holds, .. }, Command::Grasp { object, .. }) => *holds = Some(*object),
            (ControllerState::Arm { holds, .. }, Command::Put { .. }) => *holds = None,
            (
                ControllerState::Base { .. }
                | ControllerState::Arm { .. }
                | ControllerState::Head { .. }
                | ControllerState::Device,
                _,
            ) => {}
        }
    }
}

impl Controller for Scripted {
    fn configure(&mut self, _limits: &ControllerKind, start: ControllerState) -> ControllerState {
        (self.active, self.state) = (None, Some(start));
        start
    }

    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
        self.commands += 1;
        let mut rng = Rng::of(&[self.seed, self.index, self.commands]);
        if rng.is(8) {
            return Err(Rejection::OutOfReach);
        }
        let (end, steps) = (if rng.is(12) { PartEnd::Aborted } else { PartEnd::Succeeded }, 1 + rng.below(900) as u32);
        // What lasts seldom ends by itself, and only by failing.
        let left = match mode {
            Mode::Achieve => Some(steps),
            Mode::Maintain => (end == PartEnd::Aborted && rng.is(30)).then_some(steps),
        };
        self.active = Some(Active { command: command.clone(), left, end });
        Ok(())
    }

    fn cancel(&mut self) {
        let mut rng = Rng::of(&[self.seed, self.index, self.commands, 1]);
        if let Some(active) = &mut self.active {
            (active.left, active.end) = (Some(1 + rng.below(20) as u32), PartEnd::Canceled);
        }
    }

    fn step(&mut self) -> Progress {
        let Some(Active { left, end, .. }) = &mut self.active else { return Progress::Idle };
        let Some(left) = left else { return Progress::Running(1.0) };
        *left -= 1;
        if *left > 0 {
            return Progress::Running(0.5);
        }
        let end = *end;
        let active = self.active.take().expect("it was just there");
        if end == PartEnd::Succeeded {
            self.finish(&active.command);
        }
        Progress::Ended(end)
    }

    fn state(&self) -> ControllerState {
        self.state.unwrap_or(ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] })
    }
}
