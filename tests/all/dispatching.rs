//! The dispatch alone: sharing, and controllers that are lost, silent or incredible; losses simulated too.

mod dropping;
mod inhibited;
mod reporting;

use std::time::Duration;

use ambidex::dispatch::{Dispatch, Effect, Input, Limits, at_start};
use ambidex::model::{
    Access, ChannelId, Command, CommandId, ControllerId, ControllerMessage, ControllerState, End, Fault,
    FromController, Goal, Loss, MissionEnd, MissionSpec, Mode, NodeId, ObjectId, Part, PartEnd, Pose, Record, Refusal,
    Rejection, ResourceId, Service, Time, ToController,
};
use ambidex::sim::{self, Event};
use ambidex::tree::Settings;
use nalgebra::{Point3, Vector3};

use crate::fixtures::{experiment_file, load};

const ARM: ControllerId = ControllerId(0);
const LEAF: NodeId = NodeId(3);

/// What is away is granted to nobody, what can go on without it goes on, and the run ends.
#[test]
fn what_is_away_is_granted_to_nobody() {
    let mission = load(&experiment_file(1));
    let mut arms_done = 0;
    for (id, seconds) in (0..4).flat_map(|id| [0, 3, 8, 30].map(|seconds| (ControllerId(id), seconds))) {
        let at = Time::ZERO + Duration::from_secs(seconds);
        let (mut is_away, mut granted_after) = (false, 0);
        // Attached first, then lost, also where both happen at once.
        let attach = (0..4).map(|id| (Time::ZERO, Event::Attach(ControllerId(id))));
        let events = attach.chain([(at, Event::Lose(id))]).collect();
        let end = sim::simulate(&mission, &Settings::default(), events, &mut |record| {
            is_away |= matches!(record, Record::Served { service: Service::Unavailable { .. }, .. });
            if let Record::Decided { granted, round, .. } = record {
                let moved: Vec<_> = mission.robot.moved_by(id).collect();
                let uses = granted.iter().flat_map(|grant| &grant.bindings);
                let is_granted = uses.into_iter().any(|binding| moved.contains(&binding.resource));
                assert!(*round < 200 && !(is_away && is_granted), "{id:?} lost at {seconds} s");
                granted_after += if is_away { granted.len() } else { 0 };
            }
        });
        // One arm does it all, unless the other one is lost with what it holds.
        let name = mission.names.controller(id);
        let is_one_of_two = name.ends_with("arm") && (granted_after > 10 || end == MissionEnd::Done);
        assert_eq!(end == MissionEnd::Done, is_one_of_two, "{name} lost at {seconds} s: {end:?}");
        assert!(is_one_of_two || end == MissionEnd::ControllerLost(id), "{name} lost at {seconds} s: {end:?}");
        arms_done += u32::from(is_one_of_two);
    }
    assert_eq!(arms_done, 7, "of eight losses of an arm one is with an object in it");
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
    let mut dispatch = Dispatch::new(&std::sync::Arc::new(mission.clone()), at_start(mission), Limits::at_speed(1.0));
    for id in (0..4).map(ControllerId) {
        dispatch.handle(Time::ZERO, Input::Attached(id));
        let configured = FromController::Configured { generation: 1, state: state(mission, id) };
        dispatch.handle(Time::ZERO, Input::Heard(id, configured));
    }
    dispatch
}

fn grasp() -> Goal {
    let command = Command::Grasp { object: ObjectId(0), at: Point3::new(0.5, 0.2, 0.8), place: None, holder: None };
    let part = Part { resource: ResourceId(0), access: Access::Exclusive, mode: Mode::Achieve, command };
    Goal { leaf: LEAF, parts: vec![part], takes: Duration::ZERO, timeout: Duration::from_secs(60) }
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

/// What cannot be believed is recorded with its command; the last word on one ends its goal at once.
#[test]
fn an_unbelievable_last_word_fails_the_goal() {
    let mission = load(&experiment_file(1));
    for (is_last, knows_it) in [(true, true), (true, false), (false, true)] {
        let mut dispatch = ready(&mission);
        let told = dispatch.handle(Time::ZERO, Input::Start(grasp()));
        let id = told.iter().find_map(|effect| match effect {
            Effect::Tell(ARM, ToController::Goal { id, .. }) => Some(*id),
            _ => None,
        });
        let id = id.filter(|_| knows_it);
        let refusal = Refusal { id, why: Rejection::NotFinite, is_last };
        let effects = dispatch.handle(Time(20), Input::Refused(ARM, refusal));
        let message = ControllerMessage::Refused { id, why: Rejection::NotFinite };
        let record = Record::Controller { at: Time(20), controller: ARM, message };
        assert!(effects.contains(&Effect::Record(record)), "{effects:?}");
        let expected = End::Failed(Fault::Refused(ARM, Rejection::NotFinite));
        assert_eq!(end(&effects), (is_last && knows_it).then_some(expected), "{refusal:?}");
    }
}

/// Whatever the goal came to: what is in the gripper nobody knows.
#[test]
fn who_holds_what_is_unknown_is_not_used() {
    let mission = load(&experiment_file(1));
    let mut dispatch = ready(&mission);
    dispatch.handle(Time::ZERO, Input::Start(grasp()));
    let id = CommandId { generation: 1, number: 1 };
    let refusal = Refusal { id: Some(id), why: Rejection::NoSuchName, is_last: true };
    let effects = dispatch.handle(Time(20), Input::Refused(ARM, refusal));
    assert_eq!(end(&effects), Some(End::Failed(Fault::Refused(ARM, Rejection::NoSuchName))));
    assert!(effects.contains(&Effect::Lost(ARM, Loss::HoldsUnknown)) && effects.contains(&Effect::Reset(ARM)));
    // That it does not know a name itself is a refusal like any other.
    let mut dispatch = ready(&mission);
    dispatch.handle(Time::ZERO, Input::Start(grasp()));
    let rejected = FromController::Rejected { id, why: Rejection::NoSuchName };
    let effects = dispatch.handle(Time(20), Input::Heard(ARM, rejected));
    assert!(end(&effects).is_some() && !effects.contains(&Effect::Reset(ARM)), "{effects:?}");
}

#[test]
fn what_controllers_say_is_judged() {
    let mission = load(&experiment_file(1));
    let malformed = End::Failed(Fault::Refused(ARM, Rejection::Malformed));
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
    let mut dispatch = Dispatch::new(&mission, at_start(&mission), Limits::at_speed(1.0));
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
    assert!(effects.contains(&Effect::Missing(ARM)), "{effects:?}");
    assert_eq!(dispatch.deadline(), None);
}

const BASE: ControllerId = ControllerId(3);
const OTHER: NodeId = NodeId(4);

/// A goal that grasps with one arm while the base stands.
fn pick(leaf: NodeId, arm: u32) -> Goal {
    let mut goal = Goal { leaf, ..grasp() };
    goal.parts[0].resource = ResourceId(arm);
    let access = Access::Shared(ChannelId(0));
    goal.parts.push(Part { resource: ResourceId(3), access, mode: Mode::Maintain, command: Command::Stand });
    goal
}

/// What the base is told.
fn told(effects: &[Effect]) -> Vec<&ToController> {
    let to_base = effects.iter().filter_map(|effect| match effect {
        Effect::Tell(BASE, message) => Some(message),
        _ => None,
    });
    to_base.collect()
}

fn achieved(arm: u32, dispatch: &mut Dispatch) -> Vec<Effect> {
    let id = CommandId { generation: 1, number: 1 };
    let state = self::arm(Some(ObjectId(arm)));
    let message = FromController::Result { id, end: PartEnd::Succeeded, began: Time(1), ended: Time(9), state };
    dispatch.handle(Time(10), Input::Heard(ControllerId(arm), message))
}

fn stood(end: PartEnd, dispatch: &mut Dispatch) -> Vec<Effect> {
    let id = CommandId { generation: 1, number: 1 };
    let state = ControllerState::Base { pose: Pose::new(7.0, 3.5, 0.0), velocity: Vector3::zeros() };
    let message = FromController::Result { id, end, began: Time(1), ended: Time(11), state };
    dispatch.handle(Time(12), Input::Heard(BASE, message))
}

#[test]
fn what_lasts_is_begun_by_the_first_and_ended_by_the_last() {
    let mission = load(&experiment_file(1));
    let mut dispatch = ready(&mission);
    let begun = dispatch.handle(Time::ZERO, Input::Start(pick(LEAF, 0)));
    assert!(matches!(told(&begun)[..], [ToController::Goal { mode: Mode::Maintain, .. }]), "{begun:?}");
    let joined = dispatch.handle(Time::ZERO, Input::Start(pick(OTHER, 1)));
    assert!(told(&joined).is_empty(), "the second joins: {joined:?}");
    let first = achieved(0, &mut dispatch);
    assert_eq!((end(&first), told(&first).len()), (Some(End::Succeeded), 0), "the first leaves at once");
    let last = achieved(1, &mut dispatch);
    assert!(matches!(told(&last)[..], [ToController::Cancel { .. }]), "the last stops it: {last:?}");
    let at_rest = stood(PartEnd::Canceled, &mut dispatch);
    let is_over = |effect: &Effect| matches!(effect, Effect::Ended(OTHER, outcome) if outcome.end == End::Succeeded);
    assert!(at_rest.iter().any(is_over), "the last ends when the base is free: {at_rest:?}");
}

#[test]
fn what_should_last_and_ends_early_fails_all_who_hold_it() {
    let mission = load(&experiment_file(1));
    let mut dispatch = ready(&mission);
    dispatch.handle(Time::ZERO, Input::Start(pick(LEAF, 0)));
    dispatch.handle(Time::ZERO, Input::Start(pick(OTHER, 1)));
    stood(PartEnd::Aborted, &mut dispatch);
    for (arm, leaf) in [(0, LEAF), (1, OTHER)] {
        let id = CommandId { generation: 1, number: 1 };
        let state = self::arm(None);
        let canceled = FromController::Result { id, end: PartEnd::Canceled, began: Time(1), ended: Time(20), state };
        let effects = dispatch.handle(Time(21), Input::Heard(ControllerId(arm), canceled));
        let failed = End::Failed(Fault::NotMaintained(BASE));
        let is_over =
            |effect: &Effect| matches!(effect, Effect::Ended(of, outcome) if *of == leaf && outcome.end == failed);
        assert!(effects.iter().any(is_over), "{effects:?}");
    }
}

#[test]
fn what_takes_a_time_takes_it_and_what_is_maintained_lasts_as_long() {
    let mission = load(&experiment_file(1));
    let seconds = |seconds: u64| Time(seconds * 1_000_000);
    let (takes, timeout) = (Duration::from_secs(3), Duration::from_secs(60));
    let alone = Goal { leaf: LEAF, parts: Vec::new(), takes, timeout };
    let mut dispatch = ready(&mission);
    assert_eq!(end(&dispatch.handle(Time::ZERO, Input::Start(alone.clone()))), None);
    assert_eq!(dispatch.deadline(), Some(seconds(3)));
    assert_eq!(end(&dispatch.handle(seconds(2), Input::Woke)), None);
    assert_eq!(end(&dispatch.handle(seconds(3), Input::Woke)), Some(End::Succeeded));
    assert_eq!(dispatch.deadline(), None);
    // What ends sooner waits for its time, what ends later is not kept.
    for (ended, over) in [(seconds(1), seconds(3)), (seconds(5), seconds(5))] {
        let mut dispatch = ready(&mission);
        dispatch.handle(Time::ZERO, Input::Start(Goal { takes, ..grasp() }));
        let accepted = FromController::Accepted { id: CommandId { generation: 1, number: 1 }, at: Time::ZERO };
        dispatch.handle(Time::ZERO, Input::Heard(ARM, accepted));
        let first = end(&dispatch.handle(ended, result(arm(Some(ObjectId(0))))));
        assert_eq!(first, (ended == over).then_some(End::Succeeded));
        if ended < over {
            assert_eq!(dispatch.deadline(), Some(over));
            assert_eq!(end(&dispatch.handle(over, Input::Woke)), Some(End::Succeeded));
        }
    }
    let mut dispatch = ready(&mission);
    dispatch.handle(Time::ZERO, Input::Start(alone));
    assert_eq!(end(&dispatch.handle(seconds(1), Input::Stop(LEAF))), Some(End::Canceled));
}

#[test]
fn two_parts_for_one_resource_leave_nothing_behind() {
    let mission = load(&experiment_file(1));
    let mut dispatch = ready(&mission);
    let mut goal = grasp();
    let last = Part { mode: Mode::Maintain, ..goal.parts[0].clone() };
    goal.parts.push(last);
    dispatch.handle(Time::ZERO, Input::Start(goal));
    assert_eq!(end(&dispatch.handle(Time(20), result(arm(Some(ObjectId(0)))))), Some(End::Succeeded));
    let effects = dispatch.handle(Time(30), Input::Shutdown);
    assert!(effects.contains(&Effect::Safe), "{effects:?}");
}
