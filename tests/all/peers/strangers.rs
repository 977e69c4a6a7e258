//! Who has no business there: a process under another's name or under none of the robot's, and services of another make.

use std::any::Any;
use std::fmt::Debug;
use std::fs;
use std::thread;
use std::time::{Duration, Instant};

use ambidex::link::Instance;
use ambidex::link::wire::{WIRE_VERSION, WireBeat, WirePulse, WireReport, WireRequest, WireResponse, state_kind};
use ambidex::link::{Lock, monotonic_ns};
use ambidex::model::Rejection;
use iceoryx2::prelude::*;

use super::peer::{Ipc, folder, goals, node, reports, samples, wake};
use super::scene::{Cup, HOSTILE, Scene, hostile, mission};
use crate::home::Home;

/// A structure of the contract under the name of another version, with another size, and with another alignment.
macro_rules! makes {
    ($module:ident, $of:ty, $name:literal, $older:literal) => {
        mod $module {
            use super::*;

            #[repr(C)]
            #[derive(Debug, Clone, Copy, ZeroCopySend)]
            #[type_name($older)]
            pub struct Older(pub $of);

            #[repr(C)]
            #[derive(Debug, Clone, Copy, ZeroCopySend)]
            #[type_name($name)]
            pub struct Longer(pub $of, pub u64);

            #[repr(C)]
            #[repr(align(64))]
            #[derive(Debug, Clone, Copy, ZeroCopySend)]
            #[type_name($name)]
            pub struct Aligned(pub $of);
        }
    };
}

makes!(request, WireRequest, "ambidex.ToController.v3", "ambidex.ToController.v2");
makes!(response, WireResponse, "ambidex.FromController.v3", "ambidex.FromController.v2");
makes!(pulse, WirePulse, "ambidex.Pulse.v3", "ambidex.Pulse.v2");
makes!(beat, WireBeat, "ambidex.Beat.v3", "ambidex.Beat.v2");
makes!(report, WireReport, "ambidex.Report.v3", "ambidex.Report.v2");

type Service = Result<Box<dyn Any>, String>;

fn service<S: 'static>(made: Result<S, impl Debug>) -> Service {
    made.map(|service| Box::new(service) as Box<dyn Any>).map_err(|error| format!("{error:?}"))
}

type Make = fn(&Node<Ipc>) -> Service;

/// A service, what is other about it, and how it comes to be.
const OTHERS: &[(&str, &str, Make)] = &[
    ("goals", "requests of version 2", |node| service(goals::<request::Older, WireResponse>(node, HOSTILE))),
    ("goals", "longer requests", |node| service(goals::<request::Longer, WireResponse>(node, HOSTILE))),
    ("goals", "aligned requests", |node| service(goals::<request::Aligned, WireResponse>(node, HOSTILE))),
    ("goals", "responses of version 2", |node| service(goals::<WireRequest, response::Older>(node, HOSTILE))),
    ("goals", "longer responses", |node| service(goals::<WireRequest, response::Longer>(node, HOSTILE))),
    ("goals", "aligned responses", |node| service(goals::<WireRequest, response::Aligned>(node, HOSTILE))),
    ("pulse", "of version 2", |node| service(samples::<pulse::Older>(node, HOSTILE, "pulse"))),
    ("pulse", "longer", |node| service(samples::<pulse::Longer>(node, HOSTILE, "pulse"))),
    ("pulse", "aligned", |node| service(samples::<pulse::Aligned>(node, HOSTILE, "pulse"))),
    ("beat", "of version 2", |node| service(samples::<beat::Older>(node, HOSTILE, "beat"))),
    ("beat", "longer", |node| service(samples::<beat::Longer>(node, HOSTILE, "beat"))),
    ("beat", "aligned", |node| service(samples::<beat::Aligned>(node, HOSTILE, "beat"))),
    ("reports", "of version 2", |node| service(reports::<report::Older>(node, HOSTILE))),
    ("reports", "longer", |node| service(reports::<report::Longer>(node, HOSTILE))),
    ("reports", "aligned", |node| service(reports::<report::Aligned>(node, HOSTILE))),
    ("wake-daemon", "too few listeners", |node| service(wake(node, HOSTILE, "wake-daemon", 1))),
    ("wake-controller", "too few listeners", |node| service(wake(node, HOSTILE, "wake-controller", 1))),
];

fn enter(instance: &Instance) -> (Lock, Node<Ipc>) {
    let lock = instance.lock_controller(HOSTILE).expect("the place is free");
    (lock, node(instance))
}

/// Makes a service before the daemon does, and keeps it.
pub fn occupy(instance: &Instance, row: usize) {
    let (_lock, node) = enter(instance);
    let _service = OTHERS[row].2(&node).expect("nobody has it yet");
    println!("occupied");
    loop {
        thread::park();
    }
}

/// Makes every service after the daemon has.
pub fn come_late(instance: &Instance) {
    let (_lock, node) = enter(instance);
    for (service, what, make) in OTHERS {
        // One that asks for less than there is gets what there is.
        let is_less = *what == "too few listeners";
        assert_eq!(make(&node).is_ok(), is_less, "{service}: {what}");
    }
    println!("all refused");
}

/// Pulses under the name of one who is attached: it cannot move, it says.
pub fn usurp(instance: &Instance) {
    // An instance in which nobody has a place is swept by whoever comes, and what is in it with it.
    let lock = folder(instance).join(format!("controller-{HOSTILE}.lock"));
    while fs::read_to_string(&lock).unwrap_or_default().is_empty() {
        thread::sleep(Duration::from_millis(5));
    }
    let node = node(instance);
    let pulses = samples::<WirePulse>(&node, HOSTILE, "pulse").expect("a service");
    let heard = pulses.subscriber_builder().create().expect("a port");
    let mut epoch = 0;
    while epoch == 0 {
        thread::sleep(Duration::from_millis(5));
        epoch = heard.receive().expect("a port").map_or(0, |pulse| pulse.epoch);
    }
    let goals = goals::<WireRequest, WireResponse>(&node, HOSTILE).expect("a service");
    assert!(goals.server_builder().create().is_err(), "the name has one server");
    assert!(instance.lock_controller(HOSTILE).is_err(), "the place is taken");
    let publisher = pulses.publisher_builder().create().expect("a port");
    let calls = wake(&node, HOSTILE, "wake-daemon", 6).expect("a service");
    let calls = calls.notifier_builder().create().expect("a port");
    for count in 0_u32.. {
        let pulse = WirePulse {
            version: WIRE_VERSION,
            pid: std::process::id(),
            epoch: if count.is_multiple_of(2) { 0 } else { epoch },
            inhibited: count % 4,
            sent_ns: monotonic_ns(),
            ..WirePulse::default()
        };
        let state = ambidex::link::wire::WireState { kind: state_kind::ARM, ..Default::default() };
        publisher.send_copy(WirePulse { state, ..pulse }).expect("it is sent");
        let _ = calls.notify();
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn who_is_attached_keeps_its_name() {
    let ending = Scene::beside("usurper", &[]).ends(0);
    assert_eq!(ending.losses(), []);
    let whys: Vec<_> = ending.refused().map(|(_, why)| why).collect();
    assert!(!whys.is_empty() && whys.iter().all(|why| *why == Rejection::Stale), "{whys:?}");
}

#[test]
fn a_name_that_the_robot_does_not_have_is_heard_by_nobody() {
    let ending = Scene::beside("nobody", &[]).ends(0);
    assert_eq!((ending.refused().count(), ending.losses().len()), (0, 0));
}

/// Waits until the hostile process has said a word on stdout.
fn says(process: &mut crate::home::Process, word: &str) {
    let by = Instant::now() + Duration::from_secs(20);
    while !process.stdout().contains(word) {
        assert!(!process.has_ended() && Instant::now() < by, "{}{}", process.stdout(), process.stderr());
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_service_of_another_make_keeps_the_daemon_from_starting_and_is_named() {
    for (row, (service, what, _)) in OTHERS.iter().enumerate() {
        let home = Home::new();
        let mut occupant = hostile(&home, &format!("settings {row}"));
        says(&mut occupant, "occupied");
        let refused = home.daemon(&mission(&home, Cup::OfBoth), &[]).ends(2).words();
        let said = format!("cannot open the service `ambidex/v3/{HOSTILE}/{service}`");
        assert!(refused.contains(&said), "{service}, {what}: {refused}");
        assert!(!refused.contains("panicked"), "{service}, {what}: {refused}");
        drop(occupant);
        ambidex::link::sweep().expect("it is swept");
        home.is_empty();
    }
}

#[test]
fn a_service_of_another_make_is_refused_by_one_that_is_there() {
    let home = Home::new();
    let mut daemon = home.daemon(&mission(&home, Cup::OfBoth), &[]);
    daemon.says("waiting for");
    let late = hostile(&home, "late").ends(0);
    assert!(late.stdout.contains("all refused"), "{late:?}");
    daemon.signal(rustix::process::Signal::INT);
    daemon.ends(130);
    home.is_empty();
}
