//! A controller's process: attach your own robot by handing a [`Controller`](ambidex_model::motion::Controller) to [`serve`].
//!
//! The runtime starts it or you do; it waits for a daemon, takes its commands one at a time, and outlives it.
//! Motion is asked for in steps of [`STEP`](ambidex_model::motion::STEP) of robot time. Other languages: `docs/wire.md`.
//!
//! # A head of your own
//! ```no_run
//! use ambidex_link::serve::{ServeOptions, Stop, serve};
//! use ambidex_link::Instance;
//! use ambidex_link::model::{Command, ControllerKind, ControllerState, Mode, PartEnd, Rejection};
//! use ambidex_link::model::motion::{Controller, Progress};
//!
//! /// Stands for your driver. `goal` is pan and tilt; `None` means idle.
//! struct MyHead { angles: [f64; 2], goal: Option<[f64; 2]>, mode: Mode }
//!
//! impl Controller for MyHead {
//!     fn configure(&mut self, _limits: &ControllerKind, _start: ControllerState) -> ControllerState {
//!         self.state() // a real robot knows better than the daemon where it is
//!     }
//!     fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
//!         let Command::Look { at } = command else { return Err(Rejection::Unsupported) };
//!         (self.goal, self.mode) = (Some([at.y.atan2(at.x), -at.z.atan2(at.x)]), mode);
//!         Ok(())
//!     }
//!     fn cancel(&mut self) {
//!         self.goal = None; // brake here
//!     }
//!     fn step(&mut self) -> Progress {
//!         let Some(goal) = self.goal else { return Progress::Ended(PartEnd::Canceled) };
//!         self.angles = goal; // ask the hardware here; this must not block
//!         if self.mode == Mode::Maintain { return Progress::Running(1.0) }
//!         self.goal = None;
//!         Progress::Ended(PartEnd::Succeeded)
//!     }
//!     fn state(&self) -> ControllerState {
//!         ControllerState::Head { angles: self.angles, velocity: [0.0; 2] }
//!     }
//! }
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let head = MyHead { angles: [0.0; 2], goal: None, mode: Mode::Achieve };
//!     let options = ServeOptions { stop: Some(Stop::on_signals()?), ..Default::default() };
//!     serve(&Instance::new("default")?, "head", head, options)?;
//!     Ok(())
//! }
//! ```

mod error;
mod server;
mod stop;

pub use error::ServeError;
pub use server::{Exit, ServeOptions, serve};
pub use stop::{Stop, Stopper};
