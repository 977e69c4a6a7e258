//! As much of anything as a process can send.

use std::fs;
use std::thread;
use std::time::{Duration, Instant};

use ambidex::link::wire::{WIRE_VERSION, WirePulse, WireReport, WireResponse, report_kind, response_kind};

use super::peer::{Peer, Request, name};
use super::scene::{Cup, Ending, HOSTILE, Scene};

/// How long a goal's stream is flooded.
const FLOOD: Duration = Duration::from_secs(2);
/// Records of the hostile controller in a run of few seconds: refusals, feedback and its goals, at the documented pace.
const RECORDS_MAX: usize = 300;
/// Those of all, rounds and messages between nodes with them.
const ALL_RECORDS_MAX: usize = 2_000;
/// What the daemon may grow by, kibibytes.
const GROWTH_MAX_KB: u64 = 16 * 1024;

type Throw = fn(&Peer, u64);

/// What is thrown while the peer behaves.
const FLOODS: &[(&str, Throw)] = &[
    ("pulses", |peer, _| peer.throw(peer.pulse())),
    ("pulses that are wrong", |peer, _| peer.throw(WirePulse { version: 9, ..peer.pulse() })),
    ("pulses that are wrong, each with a call", |peer, _| {
        peer.throw(WirePulse { version: 9, ..peer.pulse() });
        peer.ring();
    }),
    ("calls", |peer, _| peer.ring()),
    ("reports that are not allowed", |peer, count| report(peer, "door open", count)),
    ("reports that are allowed", |peer, count| report(peer, "lamp on", count)),
    ("reports that are wrong", |peer, _| {
        let _ = peer.reports.send_copy(WireReport { version: 0, ..WireReport::default() });
        peer.ring();
    }),
];

/// The fact holds every other time.
fn report(peer: &Peer, fact: &str, count: u64) {
    let report = WireReport { version: WIRE_VERSION, kind: report_kind::FACT, id: peer.id, ..WireReport::default() };
    let _ = peer.reports.send_copy(WireReport { holds: (count % 2) as u32, name: name(fact), ..report });
    peer.ring();
}

type Say = fn(&Peer, &Request) -> WireResponse;

/// What is sent on the stream of a goal before its result.
const STREAMS: &[(&str, Say)] = &[
    ("feedback", |peer, goal| peer.word(goal, response_kind::FEEDBACK)),
    ("accepted", |peer, goal| peer.word(goal, response_kind::ACCEPTED)),
    ("results of another goal", |peer, goal| {
        let mut result = peer.word(goal, response_kind::RESULT);
        result.id.number += 1;
        result
    }),
    ("feedback that is wrong", |peer, goal| WireResponse {
        progress: f64::NAN,
        ..peer.word(goal, response_kind::FEEDBACK)
    }),
];

pub fn flood(mut peer: Peer, row: usize) {
    peer.attach();
    let throw = FLOODS[row].1;
    let mut thrown = 0;
    loop {
        // In turns with what it should do: a hundred at once, which no honest peer has in a second.
        for _ in 0..100 {
            throw(&peer, thrown);
            thrown += 1;
        }
        peer.live();
        if let Some(request) = peer.server.receive().expect("a port") {
            peer.do_at_once(request);
        }
    }
}

pub fn flood_stream(mut peer: Peer, row: usize) {
    loop {
        let goal = peer.goal();
        peer.accept(&goal);
        let until = Instant::now() + FLOOD;
        while Instant::now() < until {
            peer.live();
            for _ in 0..100 {
                peer.send(&goal, STREAMS[row].1(&peer, &goal));
            }
        }
        // There is room once the daemon has read what lies there.
        peer.hold(&goal);
        while !peer.send(&goal, peer.word(&goal, response_kind::RESULT)) {
            peer.live();
            thread::sleep(Duration::from_millis(1));
        }
    }
}

/// The most memory that a process has had, kibibytes.
fn peak_kb(pid: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches("kB").trim().parse().ok()
}

fn check(act: &str, what: &str) -> Ending {
    let mut scene = Scene::new(act, Cup::OfTheHostile { retries: 0 }, &[]);
    scene.daemon.says(&format!("attached {HOSTILE}"));
    let pid = scene.daemon.pid();
    let (before, mut after) = (peak_kb(pid).expect("it lives"), 0);
    while !scene.daemon.has_ended() {
        after = peak_kb(pid).unwrap_or(after);
        thread::sleep(Duration::from_millis(20));
    }
    let ending = scene.ends(0);
    let (records, lines) = (ending.heard().count(), ending.finished.stderr.lines().count());
    let all = ending.records.len();
    assert!(all < ALL_RECORDS_MAX, "{what}: {all} records");
    println!("{what}: {records} records, {lines} lines, {before} to {after} kB");
    assert!(after < before + GROWTH_MAX_KB, "{what}: from {before} to {after} kB");
    assert!(records < RECORDS_MAX && lines < RECORDS_MAX, "{what}: {records} records, {lines} lines");
    // Nobody is lost, the others least of all.
    assert!(!ending.finished.stderr.contains("unavailable"), "{what}: {}", ending.finished.stderr);
    ending
}

#[test]
fn a_flood_is_bounded_and_starves_nobody() {
    for (row, (what, _)) in FLOODS.iter().enumerate() {
        check(&format!("flood {row}"), what);
    }
}

#[test]
fn a_flooded_stream_is_bounded_and_its_result_arrives() {
    for (row, (what, _)) in STREAMS.iter().enumerate() {
        check(&format!("flood-stream {row}"), what);
    }
}
