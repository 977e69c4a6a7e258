//! An emergency stop for a simulated controller: SIGUSR1 presses it, SIGUSR2 releases it.

use std::cell::Cell;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ambidex::model::{ControllerKind, Inhibition, Mode, Rejection};
use ambidex::motion::{Command, Controller, ControllerState, Progress, Report};
use signal_hook::consts::{SIGUSR1, SIGUSR2};
use signal_hook::flag;

/// A controller with an emergency stop.
pub struct EmergencyStop<C> {
    body: C,
    is_pressed: Cell<bool>,
    pressed: Arc<AtomicBool>,
    released: Arc<AtomicBool>,
}

impl<C: Controller> EmergencyStop<C> {
    /// Not pressed, and obeying the signals from now on.
    ///
    /// # Errors
    /// When the handlers cannot be set.
    pub fn on_signals(body: C) -> io::Result<Self> {
        let stop = Self { body, is_pressed: Cell::new(false), pressed: Arc::default(), released: Arc::default() };
        flag::register(SIGUSR1, Arc::clone(&stop.pressed))?;
        flag::register(SIGUSR2, Arc::clone(&stop.released))?;
        Ok(stop)
    }
}

impl<C: Controller> Controller for EmergencyStop<C> {
    fn configure(&mut self, limits: &ControllerKind, start: ControllerState) -> ControllerState {
        self.body.configure(limits, start)
    }

    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
        self.body.start(command, mode)
    }

    fn cancel(&mut self) {
        self.body.cancel();
    }

    fn step(&mut self) -> Progress {
        self.body.step()
    }

    fn state(&self) -> ControllerState {
        self.body.state()
    }

    fn inhibited(&self) -> Option<Inhibition> {
        if self.pressed.swap(false, Ordering::Relaxed) {
            self.is_pressed.set(true);
        }
        if self.released.swap(false, Ordering::Relaxed) {
            self.is_pressed.set(false);
        }
        self.is_pressed.get().then_some(Inhibition::EmergencyStop)
    }

    fn reports(&self) -> Vec<Report> {
        self.body.reports()
    }
}
