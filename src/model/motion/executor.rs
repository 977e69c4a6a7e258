//! A controller with the command that it works on: the same in a process and in a simulation.

use super::{Command, Controller, ControllerState, FromController, Progress, Report};
use crate::{CommandId, ControllerKind, Inhibition, Mode, PartEnd, Rejection, Time};

/// Carries out one command at a time and tells of it.
#[derive(Debug)]
pub struct Executor<C> {
    controller: C,
    active: Option<Active>,
}

#[derive(Debug)]
struct Active {
    id: CommandId,
    began: Time,
    progress: f64,
    is_canceled: bool,
}

impl<C: Controller> Executor<C> {
    /// A controller with nothing to do.
    pub fn new(controller: C) -> Self {
        Self { controller, active: None }
    }

    /// Takes limits and start state of a new attachment and gives the true state.
    pub fn configure(&mut self, limits: &ControllerKind, start: ControllerState) -> ControllerState {
        self.active = None;
        self.controller.configure(limits, start)
    }

    /// State at the end of the last step.
    pub fn state(&self) -> ControllerState {
        self.controller.state()
    }

    /// Whether a command is under way.
    pub fn is_busy(&self) -> bool {
        self.active.is_some()
    }

    /// Whether this command is under way.
    pub fn is_doing(&self, id: CommandId) -> bool {
        self.active.as_ref().is_some_and(|active| active.id == id)
    }

    /// Begins a command.
    ///
    /// # Errors
    /// [`Rejection::Busy`] while another is under way, or why the controller cannot.
    pub fn begin(&mut self, id: CommandId, mode: Mode, command: &Command, now: Time) -> Result<(), Rejection> {
        if self.is_busy() {
            return Err(Rejection::Busy);
        }
        self.controller.start(command, mode)?;
        self.active = Some(Active { id, began: now, progress: 0.0, is_canceled: false });
        Ok(())
    }

    /// Brakes what is under way; its result comes from the steps that follow.
    pub fn cancel(&mut self) {
        if let Some(active) = &mut self.active
            && !active.is_canceled
        {
            active.is_canceled = true;
            self.controller.cancel();
        }
    }

    /// Why the controller says that it may not move.
    pub fn inhibited(&self) -> Option<Inhibition> {
        self.controller.inhibited()
    }

    /// What the controller sees of the world.
    pub fn reports(&self) -> Vec<Report> {
        self.controller.reports()
    }

    /// Ends what is under way at once: the controller came to be inhibited.
    pub fn halt(&mut self, now: Time, why: Inhibition) -> Option<FromController> {
        self.cancel();
        let Active { id, began, .. } = self.active.take()?;
        Some(FromController::Result { id, end: PartEnd::Inhibited(why), began, ended: now, state: self.state() })
    }

    /// Forgets what is under way, as a process that is started anew.
    pub fn forget(&mut self) {
        self.active = None;
    }

    /// Moves on by one step that ends at `now`; the result of the command if it ended in it.
    pub fn step(&mut self, now: Time) -> Option<FromController> {
        let active = self.active.as_mut()?;
        let end = match self.controller.step() {
            Progress::Running(progress) => {
                active.progress = progress.clamp(0.0, 1.0);
                return None;
            }
            Progress::Ended(end) => end,
            // It forgot its command.
            Progress::Idle => PartEnd::Aborted,
        };
        let Active { id, began, .. } = self.active.take()?;
        Some(FromController::Result { id, end, began, ended: now, state: self.state() })
    }

    /// How far the command is.
    pub fn feedback(&self) -> Option<FromController> {
        let active = self.active.as_ref()?;
        let state = self.state();
        Some(FromController::Feedback { id: active.id, progress: active.progress, state })
    }
}

impl<C: Controller + ?Sized> Controller for Box<C> {
    fn configure(&mut self, limits: &ControllerKind, start: ControllerState) -> ControllerState {
        (**self).configure(limits, start)
    }

    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
        (**self).start(command, mode)
    }

    fn cancel(&mut self) {
        (**self).cancel();
    }

    fn step(&mut self) -> Progress {
        (**self).step()
    }

    fn state(&self) -> ControllerState {
        (**self).state()
    }

    fn inhibited(&self) -> Option<Inhibition> {
        (**self).inhibited()
    }

    fn reports(&self) -> Vec<Report> {
        (**self).reports()
    }
}
