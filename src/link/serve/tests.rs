//! A daemon's port against a controller's loop in another thread, over real shared memory.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use super::super::stop::Stopper;
use super::*;
use crate::{DaemonPort, Heard, Link};
use ambidex_model::motion::{self, Progress};
use ambidex_model::session::{ClockOrigin, Hearing, Presence};
use ambidex_model::{
    BaseSpec, Command, CommandId, ControllerKind, ControllerState, FromController, Inhibition, Labels, Mode, Name,
    Names, ObjectId, PartEnd, PlaceId, Pose, Refusal, Rejection, ToController,
};
use nalgebra::{Point3, Vector3};

const PATIENCE: Duration = Duration::from_secs(10);
const SPEED: f64 = 10.0;

/// Drives along x at 1 m/s for two seconds, and brakes for five steps when canceled.
pub(super) struct Cart {
    x: f64,
    steps_left: u32,
    brakes: bool,
    lasts: bool,
}

impl Cart {
    pub(super) fn new() -> Self {
        Self { x: 0.0, steps_left: 0, brakes: false, lasts: false }
    }
}

impl Controller for Cart {
    fn configure(&mut self, _limits: &ControllerKind, start: motion::ControllerState) -> motion::ControllerState {
        let motion::ControllerState::Base { pose, .. } = start else {
            unreachable!("a cart is a base");
        };
        self.x = pose.at.x;
        self.state()
    }

    fn start(&mut self, command: &motion::Command, mode: Mode) -> Result<(), Rejection> {
        if !matches!(command, motion::Command::Drive { .. } | motion::Command::Stand) {
            return Err(Rejection::Unsupported);
        }
        (self.steps_left, self.brakes) = (200, false);
        self.lasts = mode == Mode::Maintain;
        Ok(())
    }

    fn cancel(&mut self) {
        (self.steps_left, self.brakes) = (5, true);
    }

    fn step(&mut self) -> Progress {
        if self.lasts && !self.brakes {
            return Progress::Running(1.0);
        }
        self.steps_left -= 1;
        self.x += 0.01;
        match (self.steps_left, self.brakes) {
            (0, true) => Progress::Ended(PartEnd::Canceled),
            (0, false) => Progress::Ended(PartEnd::Succeeded),
            (left, _) => Progress::Running(1.0 - f64::from(left) / 200.0),
        }
    }

    fn state(&self) -> motion::ControllerState {
        let vx = if self.steps_left > 0 { 1.0 } else { 0.0 };
        motion::ControllerState::Base { pose: Pose::new(self.x, 0.0, 0.0), velocity: Vector3::new(vx, 0.0, 0.0) }
    }
}

pub(super) struct Daemon {
    pub(super) port: DaemonPort,
    presence: Presence,
    generation: u32,
}

impl Daemon {
    pub(super) fn new(instance: &Instance, epoch: u64) -> Self {
        Self::with(instance, epoch, Labels::default())
    }

    fn with(instance: &Instance, epoch: u64, labels: Labels) -> Self {
        let node = IpcNode::open(instance.lock_daemon().unwrap()).unwrap();
        let port = DaemonPort::open(&node, "cart", &Arc::new(labels), epoch, ClockOrigin(monotonic_ns())).unwrap();
        Self { port, presence: Presence::new(epoch), generation: 0 }
    }

    /// Beats and takes what has come and says anything.
    pub(super) fn hear(&mut self) -> Vec<Heard> {
        self.port.beat();
        let mut heard = self.port.drain();
        heard.retain(|heard| match heard {
            Heard::Pulse(pulse) => self.presence.hear(pulse, monotonic_ns()) == Hearing::Taken,
            Heard::Message(_) | Heard::Report(_) | Heard::Refused(_) | Heard::Closed(_) | Heard::Broken => true,
            Heard::PassedOver(_) => true,
        });
        heard
    }

    /// The controller's process while it shows that it lives.
    pub(super) fn pid(&self) -> Option<u32> {
        self.presence.pid(monotonic_ns())
    }

    /// Hears until `wanted` has come; panics when it does not.
    pub(super) fn until(&mut self, what: &str, wanted: impl Fn(&Heard) -> bool) -> Vec<Heard> {
        let begun = Instant::now();
        let mut heard = Vec::new();
        while begun.elapsed() < PATIENCE {
            heard.extend(self.hear());
            if heard.iter().any(&wanted) {
                return heard;
            }
            let mut fds = [PollFd::new(&self.port, PollFlags::IN)];
            let wait = Timespec::try_from(Duration::from_millis(50)).unwrap();
            poll(&mut fds, Some(&wait)).unwrap();
        }
        panic!("never heard {what}, but {:?}", heard.iter().rev().take(5).collect::<Vec<_>>());
    }

    pub(super) fn attach(&mut self) {
        self.until("a pulse", |heard| matches!(heard, Heard::Pulse(_)));
        self.configure();
    }

    fn configure(&mut self) {
        self.tell_configuration();
        let generation = self.generation;
        self.until("the configuration", |heard| {
            matches!(heard, Heard::Message(FromController::Configured { generation: g, .. }) if *g == generation)
        });
    }

    fn tell_configuration(&mut self) {
        self.generation += 1;
        let generation = self.generation;
        let start = ControllerState::Base { pose: Pose::new(4.0, 0.0, 0.0), velocity: Vector3::zeros() };
        let limits =
            ControllerKind::Base(BaseSpec { speed: 1.0, acceleration: 0.5, turn_speed: 1.0, turn_acceleration: 1.0 });
        self.send(&ToController::Configure { generation, speed: SPEED, limits, start });
    }

    pub(super) fn goal(&mut self, number: u32, mode: Mode, command: Command) -> CommandId {
        let id = CommandId { generation: self.generation, number };
        self.send(&ToController::Goal { id, mode, command });
        id
    }

    fn send(&mut self, message: &ToController) {
        self.port.send(message).unwrap();
    }

    pub(super) fn result(&mut self, id: CommandId) -> (PartEnd, Duration, Vec<Heard>) {
        let is_result =
            |heard: &Heard| matches!(heard, Heard::Message(FromController::Result { id: its, .. }) if *its == id);
        let heard = self.until("the result", is_result);
        let Some(Heard::Message(FromController::Result { end, began, ended, .. })) =
            heard.iter().find(|heard| is_result(heard))
        else {
            unreachable!("it was just found");
        };
        (*end, *ended - *began, heard)
    }
}

pub(super) fn drive() -> Command {
    Command::Drive { path: vec![Pose::new(6.0, 0.0, 0.0)], place: None }
}

fn cart(instance: &Instance, once: bool) -> (JoinHandle<Result<Exit, ServeError>>, Stopper) {
    let (stop, stopper) = Stop::by_hand().unwrap();
    let instance = instance.clone();
    let options = ServeOptions { once, stop: Some(stop), ..ServeOptions::default() };
    let handle = thread::spawn(move || serve(&instance, "cart", Cart::new(), options));
    (handle, stopper)
}

pub(super) fn leaves_nothing(instance: &Instance) {
    let again = instance.lock_daemon().unwrap();
    drop(again);
    assert!(!instance.has_left_anything());
}

#[test]
fn a_goal_is_accepted_followed_and_ends() {
    let instance = Instance::fresh();
    let (controller, stopper) = cart(&instance, false);
    let mut daemon = Daemon::new(&instance, 1);
    daemon.attach();
    assert_eq!(daemon.pid(), Some(std::process::id()));

    let id = daemon.goal(1, Mode::Achieve, drive());
    let (end, lasted, heard) = daemon.result(id);
    // Two seconds of robot time to the step, however the wall clock went.
    assert_eq!((end, lasted), (PartEnd::Succeeded, Duration::from_secs(2)));
    let messages: Vec<_> = heard
        .iter()
        .filter_map(|heard| match heard {
            Heard::Message(message) => Some(message),
            Heard::Pulse(_) | Heard::Report(_) | Heard::Refused(_) | Heard::Closed(_) | Heard::Broken => None,
            Heard::PassedOver(_) => None,
        })
        .collect();
    assert!(matches!(messages[0], FromController::Accepted { .. }));
    assert!(
        matches!(messages[messages.len() - 1], FromController::Result { state: ControllerState::Base { pose, .. }, .. } if (pose.at.x - 6.0).abs() < 1e-9)
    );

    let refused = daemon.goal(2, Mode::Achieve, Command::Look { at: Point3::origin(), place: None });
    daemon.until("a rejection", |heard| {
        *heard == Heard::Message(FromController::Rejected { id: refused, why: Rejection::Unsupported })
    });
    stopper.stop();
    assert_eq!(controller.join().unwrap().unwrap(), Exit::Stopped);
    drop(daemon);
    leaves_nothing(&instance);
}

/// Says that it has come to where nothing is.
struct Astray;

impl Controller for Astray {
    fn configure(&mut self, _limits: &ControllerKind, start: motion::ControllerState) -> motion::ControllerState {
        start
    }

    fn start(&mut self, _: &motion::Command, _: Mode) -> Result<(), Rejection> {
        Ok(())
    }

    fn cancel(&mut self) {}

    fn step(&mut self) -> Progress {
        Progress::Ended(PartEnd::Succeeded)
    }

    fn state(&self) -> motion::ControllerState {
        motion::ControllerState::Base { pose: Pose::new(f64::NAN, 0.0, 0.0), velocity: Vector3::zeros() }
    }
}

/// A result that cannot be believed is the last word on its command all the same.
#[test]
fn an_unbelievable_result_says_whose_it_is() {
    let instance = Instance::fresh();
    let (stop, stopper) = Stop::by_hand().unwrap();
    let place = instance.clone();
    let options = ServeOptions { stop: Some(stop), ..ServeOptions::default() };
    let controller = thread::spawn(move || serve(&place, "cart", Astray, options));
    let mut daemon = Daemon::new(&instance, 1);
    // Its pulses are refused too, so it shows no life; it is configured all the same.
    daemon.until("a refused pulse", |heard| {
        *heard == Heard::Refused(Refusal { id: None, why: Rejection::NotFinite, is_last: false })
    });
    daemon.configure();
    let id = daemon.goal(1, Mode::Achieve, drive());
    let refusal = Refusal { id: Some(id), why: Rejection::NotFinite, is_last: true };
    daemon.until("a refused result", |heard| *heard == Heard::Refused(refusal));
    stopper.stop();
    assert_eq!(controller.join().unwrap().unwrap(), Exit::Stopped);
    drop(daemon);
    leaves_nothing(&instance);
}

#[test]
fn a_cancel_brakes_and_the_result_follows() {
    let instance = Instance::fresh();
    let mut daemon = Daemon::new(&instance, 1);
    let (controller, _stopper) = cart(&instance, true);
    daemon.attach();
    let id = daemon.goal(1, Mode::Maintain, Command::Stand);
    let busy = daemon.goal(2, Mode::Achieve, drive());
    daemon.until("busy", |heard| *heard == Heard::Message(FromController::Rejected { id: busy, why: Rejection::Busy }));
    daemon.send(&ToController::Cancel { id });
    let (end, ..) = daemon.result(id);
    assert_eq!(end, PartEnd::Canceled);
    // The stale generation is not even sent.
    let stale = CommandId { generation: 0, number: 3 };
    assert!(daemon.port.send(&ToController::Cancel { id: stale }).is_err());
    drop(daemon);
    assert_eq!(controller.join().unwrap().unwrap(), Exit::DaemonLeft);
    leaves_nothing(&instance);
}

#[test]
fn a_second_controller_of_a_name_is_refused_and_the_first_serves_the_next_daemon() {
    let instance = Instance::fresh();
    let (controller, stopper) = cart(&instance, false);
    let mut daemon = Daemon::new(&instance, 1);
    daemon.attach();
    let (second, _other) = cart(&instance, false);
    assert!(matches!(second.join().unwrap(), Err(ServeError::Place(_))));

    let id = daemon.goal(1, Mode::Maintain, Command::Stand);
    daemon.until(
        "accepted",
        |heard| matches!(heard, Heard::Message(FromController::Accepted { id: its, .. }) if *its == id),
    );
    drop(daemon);
    let mut next = Daemon::new(&instance, 2);
    next.attach();
    let id = next.goal(1, Mode::Achieve, drive());
    assert_eq!(next.result(id).0, PartEnd::Succeeded);
    drop(next);
    stopper.stop();
    assert_eq!(controller.join().unwrap().unwrap(), Exit::Stopped);
    leaves_nothing(&instance);
}

#[test]
fn ports_can_move_between_threads() {
    fn check<T: Send>() {}
    check::<DaemonPort>();
    check::<ControllerPort>();
}

/// A gripper that knows what it holds, and notes what it is told.
struct Gripper {
    holds: Option<&'static str>,
    told: Arc<Mutex<Vec<motion::Command>>>,
}

impl Controller for Gripper {
    fn configure(&mut self, _: &ControllerKind, _: motion::ControllerState) -> motion::ControllerState {
        self.state()
    }

    fn start(&mut self, command: &motion::Command, _: Mode) -> Result<(), Rejection> {
        self.told.lock().unwrap().push(command.clone());
        Ok(())
    }

    fn cancel(&mut self) {}

    fn step(&mut self) -> Progress {
        Progress::Ended(PartEnd::Succeeded)
    }

    fn state(&self) -> motion::ControllerState {
        let holds = self.holds.map(|name| Name::from(name).unwrap());
        motion::ControllerState::Arm { gripper: Point3::origin(), velocity: Vector3::zeros(), holds }
    }
}

#[test]
fn things_have_names_on_the_wire_and_ids_in_the_daemon() {
    let names = Names { objects: vec!["pot".into(), "cup".into()], places: vec!["table".into()], ..Names::default() };
    for holds in ["cup", "key"] {
        let instance = Instance::fresh();
        let (stop, stopper) = Stop::by_hand().unwrap();
        let (place, told) = (instance.clone(), Arc::new(Mutex::new(Vec::new())));
        let body = Gripper { holds: Some(holds), told: Arc::clone(&told) };
        let options = ServeOptions { stop: Some(stop), ..ServeOptions::default() };
        let controller = thread::spawn(move || serve(&place, "cart", body, options));
        let mut daemon = Daemon::with(&instance, 1, Labels::new(&names));
        daemon.until("a pulse", |heard| matches!(heard, Heard::Pulse(_)));
        daemon.tell_configuration();
        if holds == "key" {
            // What the mission does not know is taken for nothing else: the controller is not attached.
            let refusal = Refusal { id: None, why: Rejection::NoSuchName, is_last: false };
            daemon.until("a refused state", |heard| *heard == Heard::Refused(refusal));
        } else {
            let is_held = |state: &ControllerState| state.holds() == Some(ObjectId(1));
            daemon.until(
                "what it holds",
                |heard| matches!(heard, Heard::Message(FromController::Configured { state, .. }) if is_held(state)),
            );
            let at = Point3::new(0.5, 0.0, 0.75);
            let put = Command::Put { object: ObjectId(1), at, place: Some(PlaceId(0)), holder: None };
            let id = daemon.goal(1, Mode::Achieve, put);
            assert_eq!(daemon.result(id).0, PartEnd::Succeeded);
            let named = |name| Name::from(name).unwrap();
            let put = motion::Command::Put { object: named("cup"), at, place: Some(named("table")), holder: None };
            assert_eq!(*told.lock().unwrap(), [put]);
        }
        stopper.stop();
        assert_eq!(controller.join().unwrap().unwrap(), Exit::Stopped);
        drop(daemon);
        leaves_nothing(&instance);
    }
}

/// A cart that something may keep from moving.
struct Stoppable(Cart, Arc<AtomicBool>);

impl Controller for Stoppable {
    fn configure(&mut self, limits: &ControllerKind, start: motion::ControllerState) -> motion::ControllerState {
        self.0.configure(limits, start)
    }

    fn start(&mut self, command: &motion::Command, mode: Mode) -> Result<(), Rejection> {
        self.0.start(command, mode)
    }

    fn cancel(&mut self) {
        self.0.cancel();
    }

    fn step(&mut self) -> Progress {
        self.0.step()
    }

    fn state(&self) -> motion::ControllerState {
        self.0.state()
    }

    fn inhibited(&self) -> Option<Inhibition> {
        self.1.load(Ordering::Relaxed).then_some(Inhibition::Fault)
    }
}

#[test]
fn who_is_inhibited_says_so_in_result_and_pulse_and_takes_nothing() {
    let instance = Instance::fresh();
    let is_broken = Arc::new(AtomicBool::new(false));
    let (stop, stopper) = Stop::by_hand().unwrap();
    let (place, body) = (instance.clone(), Stoppable(Cart::new(), Arc::clone(&is_broken)));
    // It stays with its daemon, though it is to serve one only.
    let options = ServeOptions { once: true, stop: Some(stop), ..ServeOptions::default() };
    let controller = thread::spawn(move || serve(&place, "cart", body, options));
    let mut daemon = Daemon::new(&instance, 1);
    daemon.attach();
    let id = daemon.goal(1, Mode::Maintain, Command::Stand);
    daemon.until("accepted", |heard| matches!(heard, Heard::Message(FromController::Accepted { .. })));
    is_broken.store(true, Ordering::Relaxed);
    let why = Inhibition::Fault;
    let is_inhibited = |heard: &Heard| matches!(heard, Heard::Pulse(pulse) if pulse.pulse.inhibited == Some(why));
    let heard = daemon.until("an inhibited pulse", is_inhibited);
    let is_result = |heard: &Heard| {
        let is_ended = |end: &PartEnd| *end == PartEnd::Inhibited(why);
        matches!(heard, Heard::Message(FromController::Result { id: its, end, .. }) if *its == id && is_ended(end))
    };
    // Two channels, in whichever order they are read.
    if !heard.iter().any(is_result) {
        daemon.until("its result", is_result);
    }
    let refused = daemon.goal(2, Mode::Achieve, drive());
    let rejected = FromController::Rejected { id: refused, why: Rejection::Inhibited(why) };
    daemon.until("a rejection", |heard| *heard == Heard::Message(rejected.clone()));
    is_broken.store(false, Ordering::Relaxed);
    daemon.until("a pulse", |heard| matches!(heard, Heard::Pulse(pulse) if pulse.pulse.inhibited.is_none()));
    daemon.configure();
    let id = daemon.goal(1, Mode::Achieve, drive());
    assert_eq!(daemon.result(id).0, PartEnd::Succeeded);
    stopper.stop();
    assert_eq!(controller.join().unwrap().unwrap(), Exit::Stopped);
    drop(daemon);
    leaves_nothing(&instance);
}
