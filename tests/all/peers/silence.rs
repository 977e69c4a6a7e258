//! Peers that say nothing where they should, or die where they should not.

use std::thread;
use std::time::Duration;

use ambidex::model::Loss;
use rustix::process::Signal;

use super::peer::Peer;
use super::scene::{Cup, Scene};

type Act = fn(Peer);

/// What it does not do, what becomes of it, and what the daemon says of that.
const SILENCES: &[(&str, Act, &[Loss], &str)] = &[
    (
        "attaches and shows no life",
        |mut peer| {
            peer.attach();
            wait();
        },
        &[Loss::Silent],
        "left_arm is unavailable: it showed no life for 1 s",
    ),
    (
        "lives and takes no goal",
        |mut peer| {
            peer.attach();
            peer.idle(Duration::MAX);
        },
        &[Loss::Hung],
        "failed pick cup: left_arm did not answer",
    ),
    (
        "takes a goal and answers nothing",
        |mut peer| {
            let goal = peer.goal();
            peer.keep(goal);
            peer.idle(Duration::MAX);
        },
        &[Loss::Hung],
        "failed pick cup: left_arm did not answer",
    ),
    (
        "accepts, never ends, and hears no cancel",
        |mut peer| {
            let goal = peer.goal();
            peer.accept(&goal);
            peer.keep(goal);
            peer.idle(Duration::MAX);
        },
        &[Loss::Hung],
        "left_arm is unavailable: it did not end what it was told to end",
    ),
    (
        "closes a goal without a result",
        |mut peer| {
            let goal = peer.goal();
            peer.accept(&goal);
            drop(goal);
            peer.ring();
            peer.behave();
        },
        &[],
        "failed pick cup: left_arm gave up",
    ),
    (
        "dies in the midst of sending",
        |mut peer| {
            let goal = peer.goal();
            peer.accept(&goal);
            let _half = goal.loan_uninit();
            rustix::process::kill_process(rustix::process::getpid(), Signal::KILL).expect("its own end");
            wait();
        },
        &[Loss::Ended],
        "left_arm is unavailable: its process ended",
    ),
    (
        "is stopped",
        |mut peer| {
            let goal = peer.goal();
            peer.accept(&goal);
            rustix::process::kill_process(rustix::process::getpid(), Signal::STOP).expect("its own rest");
            // Another of its threads may be stopped first.
            wait();
        },
        &[Loss::Silent],
        "left_arm is unavailable: it showed no life for 1 s",
    ),
];

pub fn be_silent(peer: Peer, row: usize) {
    SILENCES[row].1(peer);
}

fn wait() -> ! {
    loop {
        thread::park();
    }
}

#[test]
fn the_other_arm_does_what_a_silent_one_does_not() {
    thread::scope(|scope| {
        for (row, (what, _, losses, said)) in SILENCES.iter().enumerate() {
            scope.spawn(move || {
                let ending = Scene::new(&format!("silence {row}"), Cup::OfBoth, &[]).ends(0);
                let lost = ending.losses();
                assert!(lost.starts_with(losses), "{what}: {lost:?}\n{}", ending.finished.stderr);
                assert!(losses.is_empty() == lost.is_empty(), "{what}: {lost:?}");
                ending.says(said);
            });
        }
    });
}
