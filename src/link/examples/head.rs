//! A head of your own: hand your driver to `serve`, and it takes part in missions as `head`.
use ambidex_link::model::motion::{Command, Controller, ControllerState, Progress};
use ambidex_link::model::{ControllerKind, Mode, PartEnd, Rejection};
use ambidex_link::{Instance, ServeOptions, Stop, serve};

/// Stands for your driver: where it looks and where it is to look, pan and tilt in radians.
struct MyHead {
    angles: [f64; 2],
    goal: Option<([f64; 2], Mode)>,
}
impl Controller for MyHead {
    fn configure(&mut self, _limits: &ControllerKind, _start: ControllerState) -> ControllerState {
        self.state() // a real robot knows better than the daemon where it is
    }
    fn start(&mut self, command: &Command, mode: Mode) -> Result<(), Rejection> {
        let Command::Look { at, .. } = command else { return Err(Rejection::Unsupported) };
        self.goal = Some(([at.y.atan2(at.x), -at.z.atan2(at.x)], mode));
        Ok(())
    }
    fn cancel(&mut self) {
        self.goal = None; // brake here
    }
    fn step(&mut self) -> Progress {
        let Some((goal, mode)) = self.goal else { return Progress::Ended(PartEnd::Canceled) };
        self.angles = goal; // ask the hardware here; this must not block
        if mode == Mode::Maintain {
            return Progress::Running(1.0); // keeps looking until it is canceled
        }
        self.goal = None;
        Progress::Ended(PartEnd::Succeeded)
    }
    fn state(&self) -> ControllerState {
        ControllerState::Head { angles: self.angles, velocity: [0.0; 2] }
    }
}
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = ServeOptions { stop: Some(Stop::on_signals()?), ..Default::default() };
    serve(&Instance::new("default")?, "head", MyHead { angles: [0.0; 2], goal: None }, options)?;
    Ok(())
}
