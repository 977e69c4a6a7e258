//! Words that come when none is due, of goals that were not given, and of things that are not held.

use std::time::Duration;

use ambidex::link::wire::{WireId, WirePulse, WireResponse, response_kind};
use ambidex::model::{ControllerMessage, FromController, Loss, Rejection};

use super::peer::{Peer, name};
use super::scene::{Cup, Scene};

type SpoilId = fn(&mut WireId);

/// Ids that are not its goal's, and under which word they are refused.
const FOREIGN: &[(&str, SpoilId, Rejection)] = &[
    ("an earlier life of the daemon", |id| id.epoch -= 1, Rejection::Stale),
    ("a later life of the daemon", |id| id.epoch += 1, Rejection::Stale),
    ("no daemon", |id| id.epoch = 0, Rejection::Stale),
    ("an earlier attachment", |id| id.generation -= 1, Rejection::Stale),
    ("a later attachment", |id| id.generation = u32::MAX, Rejection::Stale),
    ("a goal never given", |id| id.number += 1000, Rejection::Unknown),
    ("the configuration", |id| id.number = 0, Rejection::Unknown),
];

pub fn after_the_end(mut peer: Peer) {
    loop {
        let goal = peer.goal();
        peer.hold(&goal);
        let word = |kind| peer.word(&goal, kind);
        use response_kind::{ACCEPTED, CONFIGURED, FEEDBACK, REJECTED, RESULT};
        let rejected = WireResponse { why: 9, ..word(REJECTED) };
        let words = [ACCEPTED, ACCEPTED, CONFIGURED, RESULT, RESULT, ACCEPTED, FEEDBACK].map(word);
        for response in words.into_iter().chain([rejected]) {
            let _ = goal.send_copy(response);
        }
        peer.ring();
        peer.keep(goal);
    }
}

pub fn foreign(mut peer: Peer) {
    let goal = peer.goal();
    peer.accept(&goal);
    for (_, spoil, _) in FOREIGN {
        let mut result = peer.word(&goal, response_kind::RESULT);
        spoil(&mut result.id);
        peer.send(&goal, result);
    }
    peer.finish(goal);
    peer.behave();
}

/// Feedback and result with an object that the mission does not have; later its gripper is empty.
pub fn holds_nothing_known(mut peer: Peer) {
    let goal = peer.goal();
    peer.accept(&goal);
    peer.state.holds = name("spoon");
    peer.send(&goal, peer.word(&goal, response_kind::FEEDBACK));
    peer.send(&goal, peer.word(&goal, response_kind::RESULT));
    for _ in 0..2 {
        let configuration = peer.configuration();
        peer.configure(&configuration);
    }
    peer.state.holds = name("");
    peer.behave();
}

/// Has grasped what lies elsewhere.
pub fn holds_another(mut peer: Peer) {
    let goal = peer.goal();
    peer.accept(&goal);
    peer.state.holds = name("mug");
    peer.send(&goal, peer.word(&goal, response_kind::RESULT));
    peer.keep(goal);
    peer.behave();
}

/// Leaves the grasp to the other arm, then comes anew and says to hold the same.
pub fn holds_what_the_other_holds(mut peer: Peer) {
    let goal = peer.goal();
    let rejected = WireResponse { why: 7, ..peer.word(&goal, response_kind::REJECTED) };
    peer.send(&goal, rejected);
    peer.idle(Duration::from_millis(600));
    let away = WirePulse { epoch: 0, generation: 0, ..peer.pulse() };
    peer.id = WireId::default();
    peer.publish(away);
    peer.ring();
    peer.state.holds = name("cup");
    peer.behave();
}

#[test]
fn the_last_word_ends_a_goal_and_nothing_comes_after_it() {
    let ending = Scene::new("after-the-end", Cup::OfTheHostile { retries: 0 }, &[]).ends(0);
    let count = |is_meant: fn(&FromController) -> bool| {
        let heard = ending.heard().filter(|heard| match heard {
            ControllerMessage::Heard { message } => is_meant(message),
            _ => false,
        });
        heard.count()
    };
    assert_eq!(count(|message| matches!(message, FromController::Accepted { .. })), 2, "pick and place");
    assert_eq!(count(|message| matches!(message, FromController::Result { .. })), 2);
    assert_eq!(count(|message| matches!(message, FromController::Rejected { .. })), 0);
    let whys: Vec<_> = ending.refused().map(|(_, why)| why).collect();
    assert!(whys.len() >= 4 && whys.iter().all(|why| *why == Rejection::Unknown), "{whys:?}");
    assert_eq!(ending.losses(), []);
}

#[test]
fn results_of_goals_that_were_not_given_are_refused() {
    let ending = Scene::new("foreign", Cup::OfTheHostile { retries: 0 }, &[]).ends(0);
    let expected: Vec<_> = FOREIGN.iter().map(|(.., why)| (None, *why)).collect();
    assert_eq!(ending.refused().collect::<Vec<_>>(), expected);
}

#[test]
fn a_gripper_with_something_unknown_in_it_is_not_used() {
    let ending = Scene::new("holds-nothing-known", Cup::OfTheHostile { retries: 3 }, &[]).ends(0);
    assert_eq!(ending.losses(), [Loss::HoldsUnknown]);
    assert!(ending.refused().all(|(_, why)| why == Rejection::NoSuchName));
    ending.says("left_arm is unavailable: it says to hold what the mission does not have");
}

#[test]
fn what_lies_elsewhere_and_is_held_is_not_what_was_asked_for() {
    let ending = Scene::new("holds-another", Cup::OfBoth, &[]).ends(0);
    ending.says("failed pick cup: left_gripper does not hold what it should");
}

#[test]
fn two_grippers_may_say_to_hold_the_same() {
    let ending = Scene::new("holds-what-the-other-holds", Cup::OfBoth, &[]).ends(0);
    ending.says("left_arm would not take its goal");
}
