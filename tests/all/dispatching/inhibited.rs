//! A controller that lives and may not move: what ran there is interrupted, nothing is sent to it, and it is told once.

use std::time::Duration;

use ambidex::dispatch::{Dispatch, Effect, Input};
use ambidex::model::{
    Access, Call, ChannelId, Command, CommandId, End, FromController, Goal, Inhibition, Loss, Mode, NO_ARGUMENTS, Part,
    PartEnd, Rejection, ResourceId, Time,
};

use super::{ARM, LEAF, OTHER, arm, end, grasp, ready};
use crate::fixtures::{experiment_file, load};

const STOP: Inhibition = Inhibition::EmergencyStop;

fn lost() -> Input {
    Input::Lost(ARM, Loss::Inhibited(STOP))
}

fn said(end: PartEnd) -> Input {
    let id = CommandId { generation: 1, number: 1 };
    let (began, ended) = (Time::ZERO, Time(10));
    Input::Heard(ARM, FromController::Result { id, end, began, ended, state: arm(None) })
}

fn rejected() -> Input {
    let id = CommandId { generation: 1, number: 1 };
    Input::Heard(ARM, FromController::Rejected { id, why: Rejection::Inhibited(STOP) })
}

fn is_told(effects: &[Effect]) -> bool {
    effects.iter().any(|effect| matches!(effect, Effect::Tell(ARM, _)))
}

fn losses(effects: &[Effect]) -> usize {
    effects.iter().filter(|effect| **effect == Effect::Lost(ARM, Loss::Inhibited(STOP))).count()
}

#[test]
fn what_runs_is_interrupted_however_it_is_said() {
    let mission = load(&experiment_file(1));
    for (input, is_voided) in [(lost(), false), (said(PartEnd::Inhibited(STOP)), true), (rejected(), true)] {
        let mut dispatch = ready(&mission);
        dispatch.handle(Time::ZERO, Input::Start(grasp()));
        let effects = dispatch.handle(Time(20), input.clone());
        assert_eq!((end(&effects), losses(&effects)), (Some(End::Interrupted), 1), "{input:?}");
        assert!(!is_told(&effects), "{input:?}");
        // What was said outside of the pulse voids the attachment, also where the pulse does not come to say it.
        assert_eq!(effects.contains(&Effect::Reset(ARM)), is_voided, "{input:?}");
        assert_eq!(dispatch.handle(Time(30), lost()), [], "once");
        let effects = dispatch.handle(Time(40), Input::Start(grasp()));
        assert_eq!((end(&effects), is_told(&effects)), (Some(End::Interrupted), false), "granted meanwhile");
        let effects = dispatch.handle(Time(50), Input::Lost(ARM, Loss::Silent));
        assert!(effects.contains(&Effect::Lost(ARM, Loss::Silent)), "then it is worse");
    }
}

#[test]
fn once_it_may_move_it_is_configured_anew() {
    let mission = load(&experiment_file(1));
    let mut dispatch = ready(&mission);
    dispatch.handle(Time::ZERO, lost());
    let effects = dispatch.handle(Time(20), Input::Attached(ARM));
    assert!(is_told(&effects), "{effects:?}");
    let configured = FromController::Configured { generation: 2, state: arm(None) };
    let effects = dispatch.handle(Time(30), Input::Heard(ARM, configured));
    assert!(effects.iter().any(|effect| matches!(effect, Effect::Returned(ARM, _))), "{effects:?}");
    let effects = dispatch.handle(Time(40), Input::Start(grasp()));
    assert!(is_told(&effects) && end(&effects).is_none(), "{effects:?}");
}

fn calling(dispatch: &mut Dispatch, leaf: ambidex::model::NodeId, with: &str) -> Vec<Effect> {
    let call = Call { name: "hum".into(), with: with.into(), takes: Duration::ZERO };
    let access = Access::Shared(ChannelId(0));
    let part = Part { resource: ResourceId(0), access, mode: Mode::Maintain, command: Command::Call(call) };
    let goal = Goal { leaf, parts: vec![part], takes: Duration::from_secs(1), timeout: Duration::from_secs(60) };
    dispatch.handle(Time::ZERO, Input::Start(goal))
}

#[test]
fn only_the_same_call_is_shared() {
    let mission = load(&experiment_file(1));
    for (with, is_shared) in [(NO_ARGUMENTS, true), ("{\"tune\":2}", false)] {
        let mut dispatch = ready(&mission);
        assert!(is_told(&calling(&mut dispatch, LEAF, NO_ARGUMENTS)));
        let effects = calling(&mut dispatch, OTHER, with);
        let has_joined = effects.iter().any(|effect| match effect {
            Effect::Record(record) => format!("{record:?}").contains("Joined"),
            _ => false,
        });
        assert_eq!((is_told(&effects), has_joined), (false, is_shared), "{with}: a second call waits for the first");
    }
}
