//! One attachment of a controller: which command is under way, and what it answers.

use super::{Controller, Progress};
use crate::model::{CommandId, FromController, PartEnd, Rejection, Time, ToController};

/// A controller with the command that it works on; the same in a process and in a simulation.
#[derive(Debug)]
pub struct Session<C> {
    controller: C,
    generation: Option<u32>,
    active: Option<Active>,
}

#[derive(Debug)]
struct Active {
    id: CommandId,
    began: Time,
    progress: f64,
}

impl<C: Controller> Session<C> {
    /// A controller to which nobody is attached yet.
    pub fn new(controller: C) -> Self {
        Self {
            controller,
            generation: None,
            active: None,
        }
    }

    /// The controller itself.
    pub fn controller(&self) -> &C {
        &self.controller
    }

    /// Whether a command is under way.
    pub fn is_busy(&self) -> bool {
        self.active.is_some()
    }

    /// Takes a message and answers at once where an answer is due.
    pub fn told(&mut self, now: Time, message: &ToController) -> Option<FromController> {
        match message {
            ToController::Configure {
                generation, start, ..
            } => {
                self.generation = Some(*generation);
                self.active = None;
                let state = self.controller.configure(*start);
                Some(FromController::Configured {
                    generation: *generation,
                    state,
                })
            }
            ToController::Goal { id, mode, command } => Some(
                match self.begin(*id, now, |controller| controller.start(command, *mode)) {
                    Ok(()) => FromController::Accepted { id: *id, at: now },
                    Err(why) => FromController::Rejected { id: *id, why },
                },
            ),
            ToController::Cancel { id } => match &self.active {
                Some(active) if active.id == *id => {
                    self.controller.cancel();
                    None
                }
                Some(_) | None => Some(FromController::Rejected {
                    id: *id,
                    why: Rejection::Unknown,
                }),
            },
        }
    }

    /// Moves on by one step that ends at `now`; the result of the command if it ended in it.
    pub fn step(&mut self, now: Time) -> Option<FromController> {
        let progress = self.controller.step();
        let active = self.active.as_mut()?;
        let end = match progress {
            Progress::Running(progress) => {
                active.progress = progress;
                return None;
            }
            Progress::Ended(end) => end,
            Progress::Idle => PartEnd::Aborted,
        };
        let Active { id, began, .. } = self.active.take()?;
        Some(FromController::Result {
            id,
            end,
            began,
            ended: now,
            state: self.controller.state(),
        })
    }

    /// How far the command is.
    pub fn feedback(&self) -> Option<FromController> {
        let active = self.active.as_ref()?;
        let state = self.controller.state();
        Some(FromController::Feedback {
            id: active.id,
            progress: active.progress,
            state,
        })
    }

    /// Brakes whatever is under way; its result comes from the steps that follow.
    pub fn make_safe(&mut self) {
        if self.active.is_some() {
            self.controller.cancel();
        }
    }

    fn begin(
        &mut self,
        id: CommandId,
        now: Time,
        start: impl FnOnce(&mut C) -> Result<(), Rejection>,
    ) -> Result<(), Rejection> {
        match self.generation {
            None => return Err(Rejection::NotConfigured),
            Some(generation) if generation != id.generation => return Err(Rejection::Stale),
            Some(_) => {}
        }
        if self.active.is_some() {
            return Err(Rejection::Busy);
        }
        start(&mut self.controller)?;
        self.active = Some(Active {
            id,
            began: now,
            progress: 0.0,
        });
        Ok(())
    }
}

impl<C: Controller + ?Sized> Controller for Box<C> {
    fn configure(&mut self, start: crate::model::ControllerState) -> crate::model::ControllerState {
        (**self).configure(start)
    }

    fn start(
        &mut self,
        command: &crate::model::Command,
        mode: crate::model::Mode,
    ) -> Result<(), Rejection> {
        (**self).start(command, mode)
    }

    fn cancel(&mut self) {
        (**self).cancel();
    }

    fn step(&mut self) -> Progress {
        (**self).step()
    }

    fn state(&self) -> crate::model::ControllerState {
        (**self).state()
    }
}
