//! What controllers tell of themselves: granted together they work together, and no state is beyond its limits.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use ambidex::model::{
    CommandId, ControllerId, ControllerKind, ControllerMessage, FromController, Header, Labels, MissionEnd,
    MissionSpec, Mode, NodeId, Record, Rejection, Time, ToController,
};
use ambidex::motion::{self, Command, Controller, ControllerState, Progress, STEP};
use ambidex::runtime::Ended;
use nalgebra::{Vector2, Vector3};

use crate::fixtures::{experiment_file, history, load};
use crate::live::{self, Live};

const ROUNDING: f64 = 1e-6;

/// A controller that keeps the state of every step.
struct Watched {
    body: live::Body,
    steps: Arc<Mutex<Vec<ControllerState>>>,
}

impl Controller for Watched {
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
        let progress = self.body.step();
        self.steps.lock().expect("no poison").push(self.state());
        progress
    }

    fn state(&self) -> ControllerState {
        self.body.state()
    }
}

/// Position and velocity of one axis that has limits of its own.
struct Axis {
    at: Vector3<f64>,
    velocity: Vector3<f64>,
    speed: f64,
    acceleration: f64,
}

/// The axes of a state with the limits of the robot file.
fn axes(kind: &ControllerKind, state: &ControllerState) -> Vec<Axis> {
    let along = |at: f64| Vector3::new(at, 0.0, 0.0);
    match (kind, state) {
        (ControllerKind::Base(spec), ControllerState::Base { pose, velocity }) => {
            let drive = Axis {
                at: Vector3::new(pose.at.x, pose.at.y, 0.0),
                velocity: Vector3::new(velocity.x, velocity.y, 0.0),
                speed: spec.speed,
                acceleration: spec.acceleration,
            };
            let turn = Axis {
                at: along(pose.heading),
                velocity: along(velocity.z),
                speed: spec.turn_speed,
                acceleration: spec.turn_acceleration,
            };
            vec![drive, turn]
        }
        (ControllerKind::Arm(spec), ControllerState::Arm { gripper, velocity, .. }) => {
            vec![Axis { at: gripper.coords, velocity: *velocity, speed: spec.speed, acceleration: spec.acceleration }]
        }
        (ControllerKind::Head(spec), ControllerState::Head { angles, velocity }) => {
            let axis = |(at, velocity): (f64, f64)| Axis {
                at: along(at),
                velocity: along(velocity),
                speed: spec.speed,
                acceleration: spec.acceleration,
            };
            std::iter::zip(*angles, *velocity).map(axis).collect()
        }
        (kind, state) => panic!("{kind:?} published {state:?}"),
    }
}

/// Asserts the limits over two states with that time between them.
fn check_pair(kind: &ControllerKind, pair: [&ControllerState; 2], seconds: f64) {
    let [before, after] = pair.map(|state| axes(kind, state));
    for (before, after) in before.into_iter().zip(after) {
        let speed = after.velocity.norm();
        assert!(speed <= after.speed + ROUNDING, "{speed} in {pair:?}");
        let gained = (after.velocity - before.velocity).norm();
        assert!(gained <= after.acceleration * seconds + ROUNDING, "{gained} in {seconds} s, {pair:?}");
        // The direction of a heading may come under another number; a step is never that long.
        let way = Vector2::new((after.at - before.at).norm(), 0.0).x;
        assert!(way <= after.speed * seconds + ROUNDING, "{way} in {seconds} s, {pair:?}");
    }
}

fn mission(number: u32) -> Arc<MissionSpec> {
    load(&experiment_file(number))
}

#[test]
fn no_state_is_beyond_a_limit() {
    let mission = mission(1);
    let steps: Vec<Arc<Mutex<Vec<ControllerState>>>> =
        mission.robot.controllers.iter().map(|_| Arc::default()).collect();
    let body = |index: usize| -> live::Body {
        let body = motion::simulated(&mission.robot.controllers[index].kind);
        Box::new(Watched { body, steps: Arc::clone(&steps[index]) })
    };
    let live = live::run(&mission, 20.0, body, |_| None);
    assert_eq!(live.ended, Ended::Mission(MissionEnd::Done));
    for (index, spec) in mission.robot.controllers.iter().enumerate() {
        let steps = steps[index].lock().expect("no poison");
        for pair in steps.windows(2) {
            check_pair(&spec.kind, [&pair[0], &pair[1]], STEP.as_secs_f64());
        }
        let published = &live.published[index];
        for pair in published.windows(2) {
            let [(from, before), (to, after)] = [pair[0], pair[1]];
            check_pair(&spec.kind, [&before, &after], (to - from).as_secs_f64());
        }
        println!("{}: {} steps, {} published", spec.name, steps.len(), published.len());
        assert!(steps.len() > 100 && published.len() > 10, "{}", spec.name);
    }
    let fed_back = check_feedback(&mission, &live);
    println!("{fed_back} states in feedback and results");
    assert!(fed_back > 10);
}

/// The states in the journal have no moments of their own, only speeds.
fn check_feedback(mission: &MissionSpec, live: &Live) -> usize {
    let labels = Labels::new(&mission.names);
    let mut count = 0;
    for record in &live.records {
        let Record::Controller { controller, message: ControllerMessage::Heard { message }, .. } = record else {
            continue;
        };
        let state = match message {
            FromController::Configured { state, .. }
            | FromController::Feedback { state, .. }
            | FromController::Result { state, .. } => state,
            FromController::Accepted { .. } | FromController::Rejected { .. } => continue,
        };
        let state = labels.named(*state);
        check_pair(&mission.robot.controllers[controller.index()].kind, [&state, &state], 0.0);
        count += 1;
    }
    count
}

/// What a behavior's command did, by the controller's own clock.
#[derive(Debug, Clone, Copy)]
struct Work {
    leaf: NodeId,
    mode: Mode,
    began: Time,
    ended: Time,
}

/// Every command that came to its end.
fn works(records: &[Record]) -> Vec<Work> {
    let mut told: BTreeMap<(ControllerId, CommandId), (NodeId, Mode)> = BTreeMap::new();
    let mut works = Vec::new();
    for record in records {
        let Record::Controller { controller, message, .. } = record else {
            continue;
        };
        match message {
            ControllerMessage::Told { leaf: Some(leaf), message: ToController::Goal { id, mode, .. } } => {
                told.insert((*controller, *id), (*leaf, *mode));
            }
            ControllerMessage::Heard { message: FromController::Result { id, began, ended, .. } } => {
                let (leaf, mode) = told[&(*controller, *id)];
                works.push(Work { leaf, mode, began: *began, ended: *ended });
            }
            _ => {}
        }
    }
    works
}

#[test]
fn granted_together_they_work_together() {
    let mut pairs = 0;
    for number in [1, 4] {
        let mission = mission(number);
        let body = |index: usize| motion::simulated(&mission.robot.controllers[index].kind);
        let live = live::run(&mission, 20.0, body, |_| None);
        let header = Record::Header(Box::new(Header::new(&mission, "greedy", false)));
        let history = history(&[vec![header], live.records.clone()].concat());
        let works = works(&live.records);
        let achieved = |leaf: &NodeId| {
            let is_it = |work: &&Work| work.leaf == *leaf && work.mode == Mode::Achieve;
            *works.iter().find(is_it).expect("every behavior achieves something")
        };
        for step in history.steps().iter().map(|step| &step.leaves).filter(|step| step.len() > 1) {
            let works: Vec<_> = step.iter().map(achieved).collect();
            let began = works.iter().map(|work| work.began).max();
            let ended = works.iter().map(|work| work.ended).min();
            assert!(began < ended, "{works:?}");
            pairs += 1;
        }
        check_maintained(&works, &mission);
    }
    assert_eq!(pairs, 5);
}

/// A pick or place that is not alone may share its companions' commands; somebody's lasted all the while.
fn check_maintained(works: &[Work], mission: &MissionSpec) {
    let handling = works.iter().filter(|work| {
        let name = mission.names.node(work.leaf);
        work.mode == Mode::Achieve && !name.starts_with("move")
    });
    for work in handling {
        let lasting = works
            .iter()
            .filter(|other| other.mode == Mode::Maintain && other.began < work.ended && work.began < other.ended);
        assert!(lasting.count() >= 2, "base and head for {}", mission.names.node(work.leaf));
    }
}
