//! Numbers, texts and codes that cannot be believed.

use std::thread;
use std::time::Duration;

use ambidex::link::monotonic_ns;
use ambidex::link::wire::{WireName, WirePulse, WireResponse, response_kind, state_kind};
use ambidex::model::{ControllerMessage, FromController, Loss, Rejection};

use super::peer::{Peer, name};
use super::scene::{Cup, Scene};

type Spoil = fn(&mut WireResponse);

/// What is wrong with a result, and under which word it is refused.
pub const RESULTS: &[(&str, Spoil, Rejection)] = &[
    ("an older version", |w| w.version = 2, Rejection::Version),
    ("a newer version", |w| w.version = 4, Rejection::Version),
    ("no version", |w| w.version = 0, Rejection::Version),
    ("NaN", |w| w.state.position[0] = f64::NAN, Rejection::NotFinite),
    ("infinity", |w| w.state.position[1] = f64::INFINITY, Rejection::NotFinite),
    ("minus infinity", |w| w.state.velocity[2] = f64::NEG_INFINITY, Rejection::NotFinite),
    ("a velocity that is NaN", |w| w.state.velocity[0] = -f64::NAN, Rejection::NotFinite),
    ("1e308", |w| w.state.position[2] = 1e308, Rejection::Malformed),
    ("-1e308 per second", |w| w.state.velocity[1] = -1e308, Rejection::Malformed),
    ("no kind of state", |w| w.state.kind = 0, Rejection::Malformed),
    ("an unknown kind of state", |w| w.state.kind = u32::MAX, Rejection::Malformed),
    ("the state of a base", |w| w.state.kind = state_kind::BASE, Rejection::Malformed),
    ("no end", |w| w.end = 0, Rejection::Malformed),
    ("an unknown end", |w| w.end = 5, Rejection::Malformed),
    ("inhibited by nothing", |w| w.end = 4, Rejection::Malformed),
    ("an end before the beginning", |w| w.ended_us = w.began_us - 1, Rejection::Malformed),
    ("an end in the future", |w| w.ended_us = u64::MAX, Rejection::Malformed),
    ("a beginning in the future", |w| (w.began_us, w.ended_us) = (u64::MAX, u64::MAX), Rejection::Malformed),
    ("a name beyond its room", |w| w.state.holds.len = 65, Rejection::Malformed),
    ("a name of 4 GB", |w| w.state.holds.len = u32::MAX, Rejection::Malformed),
    ("a name that is no UTF-8", |w| w.state.holds = WireName { len: 3, text: [0xff; 64] }, Rejection::Malformed),
];

type SpoilPulse = fn(&mut WirePulse);

/// What is wrong with a pulse.
const PULSES: &[(&str, SpoilPulse)] = &[
    ("an older version", |w| w.version = 2),
    ("a newer version", |w| w.version = 4),
    ("no process", |w| w.pid = 0),
    ("NaN", |w| w.state.position[0] = f64::NAN),
    ("1e308", |w| w.state.velocity[0] = 1e308),
    ("an unknown kind of state", |w| w.state.kind = 5),
    ("inhibited by nobody knows what", |w| w.inhibited = 4),
    ("a name beyond its room", |w| w.state.holds.len = u32::MAX),
    ("a stamp of the future", |w| w.sent_ns = monotonic_ns() + 3_600_000_000_000),
    ("a stamp of the end of time", |w| w.sent_ns = u64::MAX),
    ("a stamp of the past", |w| (w.sent_ns, w.inhibited) = (1, 1)),
    ("another life of the daemon", |w| (w.sent_ns, w.epoch) = (1, 1)),
];

/// What is wrong with the answer to a configuration.
const CONFIGURED: &[(Spoil, &str)] = &[
    (|w| w.version = 2, "it speaks another version of the wire"),
    (|w| w.state.position[0] = f64::NAN, "a number in it is not finite"),
    (|w| w.state.position[0] = 1e308, "a length or a code in it is out of bounds"),
    (|w| w.state.kind = state_kind::HEAD, "a length or a code in it is out of bounds"),
    (|w| w.state.holds = name("nothing of this mission"), "a name in it is not known"),
    (|w| w.id.generation += 1, "it is from an earlier life of the daemon or the controller"),
    (|w| w.kind = response_kind::RESULT, "it is about nothing that is under way"),
];

/// Each wrong result as the answer to a goal of its own.
pub fn results(mut peer: Peer) {
    for (_, spoil, _) in RESULTS {
        let goal = peer.goal();
        peer.accept(&goal);
        let mut result = peer.word(&goal, response_kind::RESULT);
        result.state.holds = goal.object;
        spoil(&mut result);
        peer.send(&goal, result);
        peer.keep(goal);
    }
    peer.behave();
}

/// All wrong states as feedback of one goal, which is then done.
pub fn feedback(mut peer: Peer) {
    let goal = peer.goal();
    peer.accept(&goal);
    for (_, spoil, _) in RESULTS {
        let mut feedback = peer.word(&goal, response_kind::FEEDBACK);
        spoil(&mut feedback);
        feedback.progress = f64::NAN;
        peer.send(&goal, feedback);
    }
    peer.finish(goal);
    peer.behave();
}

/// Wrong pulses before the first good one, and all the time.
pub fn pulses(mut peer: Peer) {
    let spoiled = |peer: &Peer| {
        for (_, spoil) in PULSES {
            let mut pulse = peer.pulse();
            spoil(&mut pulse);
            let _ = peer.pulses.send_copy(pulse);
            peer.ring();
            thread::sleep(Duration::from_millis(2));
        }
    };
    spoiled(&peer);
    peer.attach();
    loop {
        spoiled(&peer);
        let goal = peer.goal();
        spoiled(&peer);
        peer.obey(goal);
    }
}

/// Never a good one.
pub fn wrong_pulses(mut peer: Peer) -> ! {
    loop {
        let mut pulse = peer.pulse();
        pulse.state.velocity[2] = f64::INFINITY;
        peer.publish(pulse);
        peer.ring();
        thread::sleep(Duration::from_millis(50));
    }
}

/// Says that it lives for ever, and dies in all but name.
pub fn future(mut peer: Peer) {
    let goal = peer.goal();
    peer.accept(&goal);
    let pulse = peer.pulse();
    let _ = peer.pulses.send_copy(WirePulse { sent_ns: u64::MAX, ..pulse });
    peer.ring();
    loop {
        thread::park();
    }
}

/// Always the same wrong answer to a configuration.
pub fn configured(mut peer: Peer, row: usize) {
    loop {
        let request = peer.configuration();
        peer.id = request.id;
        let mut answer = peer.word(&request, response_kind::CONFIGURED);
        CONFIGURED[row].0(&mut answer);
        peer.id = Default::default();
        peer.send(&request, answer);
        peer.keep(request);
    }
}

#[test]
fn a_result_that_cannot_be_believed_fails_its_goal() {
    let ending = Scene::new("results", Cup::OfTheHostile { retries: RESULTS.len() }, &[]).ends(0);
    let refused: Vec<_> = ending.refused().filter(|(id, _)| id.is_some()).map(|(_, why)| why).collect();
    for (row, (what, _, why)) in RESULTS.iter().enumerate() {
        assert_eq!(refused.get(row), Some(why), "{what}: {refused:?}");
    }
    assert_eq!(refused.len(), RESULTS.len());
}

#[test]
fn one_who_behaves_is_heard() {
    let ending = Scene::new("good", Cup::OfBoth, &[]).ends(0);
    assert_eq!(ending.refused().count(), 0);
}

/// None of it is used, some of it is told of, and the goal is none the worse for it.
#[test]
fn feedback_that_cannot_be_believed_is_passed_over() {
    let ending = Scene::new("feedback", Cup::OfTheHostile { retries: 0 }, &[]).ends(0);
    let refused = ending.refused().count();
    assert!((1..=8).contains(&refused), "{refused}");
    let feedback = ending.heard().filter(|heard| match heard {
        ControllerMessage::Heard { message } => matches!(message, FromController::Feedback { .. }),
        _ => false,
    });
    assert_eq!(feedback.count(), 0);
}

#[test]
fn pulses_that_cannot_be_believed_are_no_signs_of_life_and_of_no_death() {
    let ending = Scene::new("pulses", Cup::OfTheHostile { retries: 0 }, &[]).ends(0);
    let whys: Vec<_> = ending.refused().map(|(_, why)| why).collect();
    assert!(whys.contains(&Rejection::Version) && whys.contains(&Rejection::Malformed), "{whys:?}");
    assert_eq!(ending.losses(), []);
}

#[test]
fn a_stamp_of_the_future_keeps_nobody_alive() {
    let ending = Scene::new("future", Cup::OfBoth, &[]).ends(0);
    assert_eq!(ending.losses(), [Loss::Silent]);
    assert_eq!(ending.refused().next(), Some((None, Rejection::Malformed)));
    ending.says("left_arm is unavailable: it showed no life for 1 s");
}

#[test]
fn an_answer_to_a_configuration_that_cannot_be_believed_attaches_nobody() {
    thread::scope(|scope| {
        for (row, (_, why)) in CONFIGURED.iter().enumerate() {
            scope.spawn(move || {
                let act = format!("configured {row}");
                let ending = Scene::new(&act, Cup::OfBoth, &["--attach-timeout", "2"]).ends(4);
                ending.says("not attached in time: left_arm");
                ending.says(&format!("what left_arm said was refused: {why}"));
            });
        }
    });
}

#[test]
fn who_is_known_by_wrong_pulses_alone_is_not_there() {
    let ending = Scene::new("wrong-pulses", Cup::OfBoth, &["--attach-timeout", "1", "--quiet"]).ends(4);
    ending.says("not attached in time: left_arm what left_arm said was refused: a number in it is not finite");
    assert!(ending.heard().all(|message| matches!(message, ControllerMessage::Refused { .. })));
}
