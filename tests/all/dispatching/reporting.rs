//! What controllers report: bounded however often they say it, and what was said last always is passed on.

use std::sync::Arc;
use std::time::Duration;

use ambidex::dispatch::{Dispatch, Effect, Input, Limits, at_start};
use ambidex::model::{
    Change, ControllerId, ControllerMessage, ControllerState, FactId, FromController, Loss, MissionSpec, Record, Time,
};
use ambidex::motion::Report;
use nalgebra::{Point3, Vector3};

use crate::fixtures::{file, load};

const DOOR: ControllerId = ControllerId(2);
const NOTHING: [bool; 0] = [];

fn state(id: u32) -> ControllerState {
    match id {
        0 => ControllerState::Base { pose: ambidex::model::Pose::new(0.0, 0.0, 0.0), velocity: Vector3::zeros() },
        1 => ControllerState::Arm { gripper: Point3::new(0.3, 0.0, 1.0), velocity: Vector3::zeros(), holds: None },
        _ => ControllerState::Device,
    }
}

fn attach(dispatch: &mut Dispatch, id: u32, generation: u32, now: Time) -> Vec<Effect> {
    dispatch.handle(now, Input::Attached(ControllerId(id)));
    let configured = FromController::Configured { generation, state: state(id) };
    dispatch.handle(now, Input::Heard(ControllerId(id), configured))
}

fn ready(mission: &Arc<MissionSpec>, speed: f64) -> Dispatch {
    let mut dispatch = Dispatch::new(mission, at_start(mission), Limits::at_speed(speed));
    (0..3).for_each(|id| drop(attach(&mut dispatch, id, 1, Time::ZERO)));
    dispatch
}

fn passed_on(effects: &[Effect]) -> Vec<bool> {
    let holds = effects.iter().filter_map(|effect| match effect {
        Effect::Reported(DOOR, Change::Fact(FactId(0), holds)) => Some(*holds),
        _ => None,
    });
    holds.collect()
}

fn ms(ms: u64) -> Time {
    Time::ZERO + Duration::from_millis(ms)
}

fn say(dispatch: &mut Dispatch, at: Time, holds: bool) -> Vec<bool> {
    passed_on(&dispatch.handle(at, Input::Reported(DOOR, Report::fact("door open", holds))))
}

#[test]
fn what_was_said_last_is_passed_on_ten_times_a_second_at_most() {
    let mission = load(&file("config/missions/door.yaml"));
    for speed in [1, 20] {
        let mut dispatch = ready(&mission, speed as f64);
        let at = |wall_ms: u64| ms(wall_ms * speed);
        assert_eq!(say(&mut dispatch, at(10), true), [true], "what is new at once");
        assert_eq!(say(&mut dispatch, at(20), true), NOTHING, "what is known is no news");
        assert_eq!(say(&mut dispatch, at(30), false), NOTHING);
        assert_eq!(say(&mut dispatch, at(40), true), NOTHING, "it flaps");
        assert_eq!(dispatch.deadline(), None, "and is what it was");
        assert_eq!(say(&mut dispatch, at(50), false), NOTHING);
        assert_eq!(dispatch.deadline(), Some(at(110)));
        assert_eq!(passed_on(&dispatch.handle(at(110), Input::Woke)), [false], "the last word is never lost");
        assert_eq!(say(&mut dispatch, at(1_000), false), NOTHING);
        assert_eq!(say(&mut dispatch, at(1_110), false), [false], "once more every second");
        let flapping = (1_200..11_200).map(|wall_ms| say(&mut dispatch, at(wall_ms), wall_ms % 2 == 0).len());
        let count: usize = flapping.sum();
        assert!((90..=101).contains(&count), "{count} in ten seconds");
    }
}

#[test]
fn what_is_said_before_the_mission_begins_is_passed_on_when_it_does() {
    let mission = load(&file("config/missions/door.yaml"));
    let mut dispatch = Dispatch::new(&mission, at_start(&mission), Limits::at_speed(1.0));
    attach(&mut dispatch, 2, 1, Time::ZERO);
    assert_eq!(say(&mut dispatch, ms(10), true), NOTHING);
    attach(&mut dispatch, 0, 1, ms(20));
    let effects = attach(&mut dispatch, 1, 1, ms(30));
    let ready = effects.iter().position(|effect| matches!(effect, Effect::Ready(_)));
    let said = effects.iter().position(|effect| matches!(effect, Effect::Reported(..)));
    assert!(ready.is_some() && ready < said, "{effects:?}");
}

#[test]
fn one_that_was_lost_says_all_of_it_anew() {
    let mission = load(&file("config/missions/door.yaml"));
    let mut dispatch = ready(&mission, 1.0);
    assert_eq!(say(&mut dispatch, ms(10), true), [true]);
    dispatch.handle(ms(20), Input::Lost(DOOR, Loss::Ended));
    assert_eq!(say(&mut dispatch, ms(30), false), NOTHING, "who is gone says nothing");
    attach(&mut dispatch, 2, 2, ms(40));
    assert_eq!(say(&mut dispatch, ms(50), true), [true]);
}

#[test]
fn what_is_not_heard_is_told_once_a_second() {
    let mission = load(&file("config/missions/door.yaml"));
    let mut dispatch = ready(&mission, 1.0);
    let mut told = 0;
    for now in (0..5_000).map(ms) {
        let effects = dispatch.handle(now, Input::Reported(DOOR, Report::fact("door shut", now.0 % 2_000 == 0)));
        told += effects
            .iter()
            .filter(|effect| {
                let message = ControllerMessage::Misreported {
                    report: Report::fact("door shut", now.0 % 2_000 == 0),
                    why: ambidex::model::Misreport::NotAllowed,
                };
                **effect == Effect::Record(Record::Controller { at: now, controller: DOOR, message })
            })
            .count();
    }
    assert_eq!(told, 5);
}
