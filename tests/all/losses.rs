//! Controllers that are lost, silent or incredible: simulated, and to the dispatch alone.

use std::time::Duration;

use ambidex::dispatch::{Dispatch, Effect, Input, Limits};
use ambidex::model::{
    Access, Command, CommandId, ControllerId, ControllerState, End, Fault, FromController, Goal, MissionEnd,
    MissionSpec, Mode, NodeId, ObjectId, Part, PartEnd, Pose, Record, Rejection, ResourceId, Time, ToController,
};
use ambidex::sim::{self, Event};
use ambidex::tree::Settings;
use nalgebra::{Point3, Vector3};

use crate::fixtures::{experiment_file, load};

const ARM: ControllerId = ControllerId(0);
const LEAF: NodeId = NodeId(3);

#[test]
fn a_simulated_loss_ends_the_mission_and_grants_nothing_more() {
    let mission = load(&experiment_file(1));
    for (id, seconds) in (0..4).flat_map(|id| [0, 3, 8, 30].map(|seconds| (ControllerId(id), seconds))) {
        let at = Time::ZERO + Duration::from_secs(seconds);
        let (mut is_lost, mut rounds) = (false, 0);
        // Attached first, then lost, also where both happen at once.
        let attach = (0..4).map(|id| (Time::ZERO, Event::Attach(ControllerId(id))));
        let events = attach.chain([(at, Event::Lose(id))]).collect();
        let end = sim::simulate(&mission, &Settings::default(), events, &mut |record| {
            is_lost |= matches!(record, Record::Ended { .. });
            if let Record::Decided { granted, round, .. } = record {
                rounds = *round;
                assert!(rounds < 100 && (granted.is_empty() || !is_lost), "{id:?} lost at {seconds} s");
            }
        });
        assert_eq!(end, MissionEnd::ControllerLost(id), "lost at {seconds} s");
    }
}

fn state(mission: &MissionSpec, id: ControllerId) -> ControllerState {
    match mission.names.controller(id) {
        "base" => ControllerState::Base { pose: mission.start.base, velocity: Vector3::zeros() },
        "head" => ControllerState::Head { angles: [0.0; 2], velocity: [0.0; 2] },
        _ => arm(None),
    }
}

fn arm(holds: Option<ObjectId>) -> ControllerState {
    ControllerState::Arm { gripper: Point3::new(0.3, 0.2, 0.9), velocity: Vector3::zeros(), holds }
}

/// A dispatch whose four controllers are configured.
fn ready(mission: &MissionSpec) -> Dispatch {
    let mut dispatch = Dispatch::new(mission, Limits::at_speed(1.0));
    for id in (0..4).map(ControllerId) {
        dispatch.handle(Time::ZERO, Input::Attached(id));
        let configured = FromController::Configured { generation: 1, state: state(mission, id) };
        dispatch.handle(Time::ZERO, Input::Heard(id, configured));
    }
    dispatch
}

fn grasp() -> Goal {
    let command = Command::Grasp { object: ObjectId(0), at: Point3::new(0.5, 0.2, 0.8) };
    let part = Part { resource: ResourceId(0), access: Access::Exclusive, mode: Mode::Achieve, command };
    Goal { leaf: LEAF, parts: vec![part], timeout: Duration::from_secs(60) }
}

fn result(state: ControllerState) -> Input {
    let id = CommandId { generation: 1, number: 1 };
    let (began, ended) = (Time::ZERO, Time(10));
    Input::Heard(ARM, FromController::Result { id, end: PartEnd::Succeeded, began, ended, state })
}

/// How the goal of the leaf ended.
fn end(effects: &[Effect]) -> Option<End> {
    effects.iter().find_map(|effect| match effect {
        Effect::Ended(LEAF, outcome) => Some(outcome.end),
        _ => None,
    })
}

#[test]
fn what_controllers_say_is_judged() {
    let mission = load(&experiment_file(1));
    let malformed = End::Failed(Fault::Rejected(ARM, Rejection::Malformed));
    let base = ControllerState::Base { pose: Pose::new(0.0, 0.0, 0.0), velocity: Vector3::zeros() };
    let rows = [
        ("an object that there is", arm(Some(ObjectId(0))), End::Succeeded),
        ("an object that there is not", arm(Some(ObjectId(77))), malformed),
        ("a state of another kind", base, malformed),
    ];
    for (what, state, expected) in rows {
        let mut dispatch = ready(&mission);
        dispatch.handle(Time::ZERO, Input::Start(grasp()));
        let effects = dispatch.handle(Time(20), result(state));
        assert_eq!(end(&effects), Some(expected), "{what}");
    }
}

#[test]
fn who_does_not_answer_in_time_fails_its_goal() {
    let mission = load(&experiment_file(1));
    let mut dispatch = ready(&mission);
    dispatch.handle(Time::ZERO, Input::Start(grasp()));
    let due = dispatch.deadline().expect("an answer is due");
    let effects = dispatch.handle(due, Input::Woke);
    assert_eq!(end(&effects), Some(End::Failed(Fault::Unanswered(ARM))));
    let late = dispatch.handle(due, result(arm(None)));
    assert_eq!(end(&late), None, "what comes late is stale");
}

#[test]
fn a_configuration_is_repeated_and_then_given_up() {
    let mission = load(&experiment_file(1));
    let mut dispatch = Dispatch::new(&mission, Limits::at_speed(1.0));
    let mut effects = dispatch.handle(Time::ZERO, Input::Attached(ARM));
    for generation in 1..=3 {
        let told = effects.iter().find_map(|effect| match effect {
            Effect::Tell(ARM, ToController::Configure { generation, .. }) => Some(*generation),
            _ => None,
        });
        assert_eq!(told, Some(generation));
        let due = dispatch.deadline().expect("an answer is due");
        effects = dispatch.handle(due, Input::Woke);
    }
    assert!(effects.contains(&Effect::Lost(ARM)), "{effects:?}");
    assert_eq!(dispatch.deadline(), None);
}
