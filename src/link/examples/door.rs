//! A sensor of your own: says whether a door is open, and moves nothing. It takes part in missions as `door`.
use std::path::PathBuf;

use ambidex_link::model::motion::{Command, Controller, ControllerState, Progress, Report};
use ambidex_link::model::{ControllerKind, Mode, Rejection};
use ambidex_link::{Instance, ServeOptions, Stop, serve};

/// Stands for your driver: the door is open while there is a file.
struct MyDoor {
    is_open: PathBuf,
}
impl Controller for MyDoor {
    fn configure(&mut self, _limits: &ControllerKind, _start: ControllerState) -> ControllerState {
        self.state()
    }
    fn start(&mut self, _command: &Command, _mode: Mode) -> Result<(), Rejection> {
        Err(Rejection::Unsupported) // a sensor does nothing
    }
    fn cancel(&mut self) {}
    fn step(&mut self) -> Progress {
        Progress::Idle
    }
    fn state(&self) -> ControllerState {
        ControllerState::Device
    }
    fn reports(&self) -> Vec<Report> {
        vec![Report::fact("door open", self.is_open.exists())] // all that it sees; this must not block
    }
}
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let is_open = arguments.next().unwrap_or("door-open".into()).into();
    let instance = arguments.next().unwrap_or("default".into());
    let options = ServeOptions { stop: Some(Stop::on_signals()?), ..Default::default() };
    serve(&Instance::new(&instance)?, "door", MyDoor { is_open }, options)?;
    Ok(())
}
