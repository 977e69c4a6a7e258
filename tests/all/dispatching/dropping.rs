//! An object that is dropped on purpose: who holds it lets go first, and the behavior waits for that.

use std::sync::Arc;
use std::time::Duration;

use ambidex::dispatch::{Dispatch, Effect, Input, Script};
use ambidex::model::{
    Access, Change, ChannelId, Command, CommandId, ControllerState, End, Flaw, FlawKind, FromController, Goal,
    Location, Loss, MissionSpec, Mode, ObjectId, Part, PartEnd, PlaceId, ResourceId, Time, ToController,
};

use super::{ARM, LEAF, OTHER, arm, end, grasp, ready, told};
use crate::fixtures::{experiment_file, load};

const OBJECT: ObjectId = ObjectId(0);

fn stand() -> Goal {
    let access = Access::Shared(ChannelId(0));
    let part = Part { resource: ResourceId(3), access, mode: Mode::Achieve, command: Command::Stand };
    Goal { leaf: OTHER, parts: vec![part], takes: Duration::ZERO, timeout: Duration::from_secs(60) }
}

/// A dispatch whose arm holds the object, and what comes of a behavior that drops it.
fn dropping(mission: &Arc<MissionSpec>) -> (Dispatch, Vec<Effect>) {
    let mut dispatch = ready(mission);
    dispatch.follow(Script::new(vec![Flaw { leaf: OTHER, attempt: Some(1), kind: FlawKind::Drops(None) }]));
    dispatch.handle(Time::ZERO, Input::Start(grasp()));
    let id = CommandId { generation: 1, number: 1 };
    let state = arm(Some(OBJECT));
    let message = FromController::Result { id, end: PartEnd::Succeeded, began: Time::ZERO, ended: Time(9), state };
    let effects = dispatch.handle(Time(10), Input::Heard(ARM, message));
    assert_eq!(end(&effects), Some(End::Succeeded), "{LEAF:?}");
    let effects = dispatch.handle(Time(20), Input::Start(stand()));
    (dispatch, effects)
}

fn configured(state: ControllerState) -> Input {
    Input::Heard(ARM, FromController::Configured { generation: 2, state })
}

fn dropped(effects: &[Effect]) -> Vec<Change> {
    let changes = effects.iter().filter_map(|effect| match effect {
        Effect::Dropped(change) => Some(*change),
        _ => None,
    });
    changes.collect()
}

fn is_canceled(effects: &[Effect]) -> bool {
    let canceled = |effect: &Effect| matches!(effect, Effect::Ended(OTHER, outcome) if outcome.end == End::Canceled);
    effects.iter().any(canceled)
}

/// With what an arm is configured.
fn start(effects: &[Effect]) -> Option<(u32, ControllerState)> {
    effects.iter().find_map(|effect| match effect {
        Effect::Tell(ARM, ToController::Configure { generation, start, .. }) => Some((*generation, *start)),
        _ => None,
    })
}

#[test]
fn who_holds_it_lets_go_before_the_behavior_begins() {
    let mission = load(&experiment_file(1));
    for (state, expected) in [
        (arm(None), vec![Change::Object(OBJECT, Location::At(PlaceId(1)))]),
        // A real arm that is configured anew does not open its gripper for that.
        (arm(Some(OBJECT)), Vec::new()),
    ] {
        let (mut dispatch, effects) = dropping(&mission);
        assert_eq!(start(&effects), Some((2, arm(None))));
        assert!(told(&effects).is_empty(), "{effects:?}");
        let effects = dispatch.handle(Time(30), configured(state));
        assert_eq!(dropped(&effects), expected);
        assert_eq!(told(&effects).len(), 1, "it begins: {effects:?}");
    }
}

#[test]
fn what_waits_for_it_can_be_ended() {
    let mission = load(&experiment_file(1));
    let (mut dispatch, _) = dropping(&mission);
    assert!(is_canceled(&dispatch.handle(Time(25), Input::Stop(OTHER))));
    let effects = dispatch.handle(Time(30), configured(arm(None)));
    assert_eq!((dropped(&effects).len(), told(&effects).len()), (1, 0), "{effects:?}");
    let (mut dispatch, _) = dropping(&mission);
    let effects = dispatch.handle(Time(25), Input::Shutdown);
    assert!(is_canceled(&effects) && effects.contains(&Effect::Safe), "{effects:?}");
}

#[test]
fn nobody_waits_for_who_is_lost_or_silent() {
    let mission = load(&experiment_file(1));
    let (mut dispatch, _) = dropping(&mission);
    let effects = dispatch.handle(Time(25), Input::Lost(ARM, Loss::Ended));
    assert_eq!((dropped(&effects).len(), told(&effects).len()), (0, 1), "{effects:?}");
    let (mut dispatch, _) = dropping(&mission);
    for generation in [3, 4] {
        let due = dispatch.deadline().expect("an answer is due");
        assert_eq!(start(&dispatch.handle(due, Input::Woke)), Some((generation, arm(None))));
    }
    let due = dispatch.deadline().expect("an answer is due");
    assert_eq!(told(&dispatch.handle(due, Input::Woke)).len(), 1);
}
