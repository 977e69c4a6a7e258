//! The session alone, with time handed in.

use std::cell::Cell;

use nalgebra::Point3;

use super::*;
use crate::motion::Progress;
use crate::{BaseSpec, PartEnd};

const MS: u64 = 1_000_000;
const EPOCH: u64 = 5;

/// Ends after `length` steps, or two after a cancel.
struct Steps {
    length: u32,
    done: u32,
    is_canceled: bool,
}

impl Controller for Steps {
    fn configure(&mut self, _limits: &ControllerKind, start: ControllerState) -> ControllerState {
        start
    }
    fn start(&mut self, command: &Command, _mode: Mode) -> Result<(), Rejection> {
        (self.done, self.is_canceled) = (0, false);
        match command {
            Command::Stand => Ok(()),
            Command::Drive { .. }
            | Command::Grasp { .. }
            | Command::Put { .. }
            | Command::Look { .. }
            | Command::Call(_) => Err(Rejection::Unsupported),
        }
    }
    fn cancel(&mut self) {
        assert!(!self.is_canceled, "told once");
        self.is_canceled = true;
        self.length = self.done + 2;
    }
    fn step(&mut self) -> Progress {
        self.done += 1;
        match (self.done >= self.length, self.is_canceled) {
            (false, _) => Progress::Running(f64::from(self.done) / f64::from(self.length)),
            (true, false) => Progress::Ended(PartEnd::Succeeded),
            (true, true) => Progress::Ended(PartEnd::Canceled),
        }
    }
    fn state(&self) -> ControllerState {
        state(f64::from(self.done))
    }
}

fn state(pan: f64) -> ControllerState {
    ControllerState::Head { angles: [pan, 0.0], velocity: [0.0; 2] }
}

fn id(number: u32) -> CommandId {
    CommandId { generation: 1, number }
}

fn beat(session: &mut Session<Steps>, epoch: u64, now_ns: u64) {
    session.hear_beat(Beat { pid: 1, epoch, sent_ns: now_ns });
}

fn take(session: &mut Session<Steps>, epoch: u64, message: ToController, now_ns: u64) {
    let origin = ClockOrigin(0);
    session.take(Received { message, epoch, origin }, now_ns);
}

fn configure(generation: u32, speed: f64) -> ToController {
    let limits =
        ControllerKind::Base(BaseSpec { speed: 1.0, acceleration: 0.5, turn_speed: 1.0, turn_acceleration: 1.0 });
    ToController::Configure { generation, speed, limits, start: state(0.0) }
}

fn goal(number: u32) -> ToController {
    ToController::Goal { id: id(number), mode: Mode::Achieve, command: Command::Stand }
}

fn attached(length: u32, speed: f64) -> Session<Steps> {
    let mut session = Session::new(Steps { length, done: 0, is_canceled: false });
    beat(&mut session, EPOCH, 0);
    take(&mut session, EPOCH, configure(1, speed), 0);
    session.tick(0);
    let replies = session.replies();
    assert!(matches!(replies[..], [Reply { message: FromController::Configured { generation: 1, .. }, .. }]));
    session
}

fn rejected(session: &mut Session<Steps>) -> Option<Rejection> {
    let replies = session.replies();
    replies.iter().find_map(|reply| match reply.message {
        FromController::Rejected { why, .. } => Some(why),
        FromController::Configured { .. }
        | FromController::Accepted { .. }
        | FromController::Feedback { .. }
        | FromController::Result { .. } => None,
    })
}

fn result(session: &mut Session<Steps>) -> Option<(PartEnd, Time, Time)> {
    let replies = session.replies();
    replies.iter().find_map(|reply| match reply.message {
        FromController::Result { end, began, ended, .. } => Some((end, began, ended)),
        FromController::Configured { .. }
        | FromController::Accepted { .. }
        | FromController::Rejected { .. }
        | FromController::Feedback { .. } => None,
    })
}

#[test]
fn steps_lie_on_one_grid_at_any_speed_and_any_wake() {
    for speed in [0.5, 1.0, 20.0, 1000.0] {
        let at = |robot_ms: f64| (robot_ms / speed * MS as f64) as u64 + 1;
        let mut session = attached(30, speed);
        take(&mut session, EPOCH, goal(1), at(37.0));
        for robot_ms in [38.0, 41.0, 95.0, 96.0, 300.0, 400.0] {
            beat(&mut session, EPOCH, at(robot_ms));
            session.tick(at(robot_ms));
        }
        // Began at 30 ms, the step before; ended thirty steps on.
        let ended = (PartEnd::Succeeded, Time(30_000), Time(330_000));
        assert_eq!(result(&mut session), Some(ended), "speed {speed}");
    }
}

#[test]
fn what_cannot_be_done_is_rejected() {
    let mut session = Session::new(Steps { length: 5, done: 0, is_canceled: false });
    beat(&mut session, EPOCH, 0);
    take(&mut session, EPOCH, goal(1), 0);
    assert_eq!(rejected(&mut session), Some(Rejection::NotConfigured));
    take(&mut session, EPOCH + 1, configure(1, 1.0), 0);
    assert_eq!(rejected(&mut session), Some(Rejection::Stale), "no such daemon");

    let mut session = attached(5, 1.0);
    take(&mut session, EPOCH, configure(1, 1.0), 0);
    assert_eq!(rejected(&mut session), Some(Rejection::Stale), "the same generation");
    take(&mut session, EPOCH + 1, goal(1), 0);
    assert_eq!(rejected(&mut session), Some(Rejection::Stale), "another epoch");
    take(&mut session, EPOCH, goal(2), 0);
    assert_eq!(rejected(&mut session), None);
    take(&mut session, EPOCH, goal(2), 0);
    assert_eq!(rejected(&mut session), Some(Rejection::Stale), "the number again");
    take(&mut session, EPOCH, goal(3), 0);
    assert_eq!(rejected(&mut session), Some(Rejection::Busy));
    take(&mut session, EPOCH, ToController::Cancel { id: id(9) }, 0);
    session.tick(50 * MS);
    assert_eq!(result(&mut session).unwrap().0, PartEnd::Succeeded);
    let look = ToController::Goal {
        id: id(4),
        mode: Mode::Achieve,
        command: Command::Look { at: Point3::origin(), place: None },
    };
    take(&mut session, EPOCH, look, 50 * MS);
    assert_eq!(rejected(&mut session), Some(Rejection::Unsupported));
}

#[test]
fn silence_stops_motion_and_ends_the_attachment() {
    let mut session = attached(u32::MAX, 1.0);
    take(&mut session, EPOCH, goal(1), 0);
    session.tick(900 * MS);
    assert_eq!(result(&mut session), None);
    session.tick(1010 * MS);
    session.tick(1040 * MS);
    assert_eq!(result(&mut session).unwrap().0, PartEnd::Canceled);
    assert!(!session.is_attached());
    // The daemon is back, and must configure again.
    beat(&mut session, EPOCH, 1050 * MS);
    take(&mut session, EPOCH, goal(2), 1050 * MS);
    assert_eq!(rejected(&mut session), Some(Rejection::NotConfigured));
    take(&mut session, EPOCH, configure(2, 1.0), 1050 * MS);
    session.tick(1060 * MS);
    assert!(session.is_attached());
}

#[test]
fn the_next_daemon_waits_until_motion_has_ended() {
    let mut session = attached(u32::MAX, 1.0);
    take(&mut session, EPOCH, goal(1), 0);
    session.tick(100 * MS);
    session.hear_end();
    beat(&mut session, EPOCH + 1, 110 * MS);
    take(&mut session, EPOCH + 1, configure(1, 1.0), 110 * MS);
    session.tick(111 * MS);
    assert_eq!(session.pulse().epoch, EPOCH);
    session.tick(140 * MS);
    assert_eq!(result(&mut session).unwrap().0, PartEnd::Canceled);
    assert_eq!(session.pulse().epoch, EPOCH + 1);
}

#[test]
fn a_sleeper_does_not_leap() {
    let mut session = attached(u32::MAX, 1.0);
    take(&mut session, EPOCH, goal(1), 0);
    session.tick(20 * MS);
    beat(&mut session, EPOCH, 5000 * MS);
    session.tick(5000 * MS);
    assert_eq!(session.pulse().state, state(2.0));
    session.tick(5030 * MS);
    assert_eq!(result(&mut session).unwrap().0, PartEnd::Canceled);
    assert!(session.is_attached());
}

#[test]
fn told_to_stop_it_brakes_and_takes_nothing_more() {
    let mut session = attached(u32::MAX, 1.0);
    take(&mut session, EPOCH, goal(1), 0);
    session.stop();
    assert!(!session.is_at_rest());
    session.tick(30 * MS);
    assert!(session.is_at_rest());
    session.replies();
    take(&mut session, EPOCH, goal(2), 30 * MS);
    assert_eq!(rejected(&mut session), Some(Rejection::Busy));
}

#[test]
fn inhibited_it_ends_at_once_and_is_configured_anew() {
    let why = Inhibition::EmergencyStop;
    let mut session = attached(u32::MAX, 1.0);
    take(&mut session, EPOCH, goal(1), 0);
    session.tick(50 * MS);
    session.inhibit(Some(why));
    session.tick(60 * MS);
    assert_eq!(result(&mut session), Some((PartEnd::Inhibited(why), Time(0), Time(60_000))));
    assert_eq!((session.pulse().inhibited, session.pulse().generation), (Some(why), 0));
    assert!(session.is_at_rest() && session.is_attached(), "its daemon is there all the same");
    take(&mut session, EPOCH, goal(2), 70 * MS);
    assert_eq!(rejected(&mut session), Some(Rejection::Inhibited(why)));
    take(&mut session, EPOCH, configure(2, 1.0), 70 * MS);
    assert_eq!(rejected(&mut session), Some(Rejection::Inhibited(why)));
    session.inhibit(None);
    session.tick(80 * MS);
    assert_eq!(session.pulse().inhibited, None);
    take(&mut session, EPOCH, goal(3), 80 * MS);
    assert_eq!(rejected(&mut session), Some(Rejection::NotConfigured));
    take(&mut session, EPOCH, configure(2, 1.0), 80 * MS);
    session.tick(90 * MS);
    assert_eq!(session.pulse().generation, 2);
}

#[test]
fn at_hardly_any_speed_it_still_gives_signs_of_life() {
    for speed in [1e-30, f64::MIN_POSITIVE, 5e-324] {
        let mut session = attached(u32::MAX, speed);
        take(&mut session, EPOCH, goal(1), 0);
        assert!(!session.is_at_rest(), "it moves");
        assert_eq!(session.rest(50 * MS), PULSE_EVERY);
    }
}

/// A body that says something else each time it is asked.
struct Fickle(Cell<bool>);

impl Controller for Fickle {
    fn configure(&mut self, _: &ControllerKind, start: ControllerState) -> ControllerState {
        start
    }

    fn start(&mut self, _: &Command, _: Mode) -> Result<(), Rejection> {
        Ok(())
    }

    fn cancel(&mut self) {}

    fn step(&mut self) -> Progress {
        Progress::Running(0.0)
    }

    fn state(&self) -> ControllerState {
        state(0.0)
    }

    fn inhibited(&self) -> Option<Inhibition> {
        let is_inhibited = self.0.replace(!self.0.get());
        is_inhibited.then_some(Inhibition::Fault)
    }
}

#[test]
fn all_that_is_told_in_a_turn_goes_by_one_answer_of_the_body() {
    let mut session = Session::new(Fickle(Cell::new(false)));
    for turn in 0..4 {
        session.tick(turn * MS);
        let told = session.inhibited();
        assert_eq!((session.inhibited(), session.pulse().inhibited), (told, told), "turn {turn}");
    }
}
