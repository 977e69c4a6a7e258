//! Ctrl-C and SIGTERM at any moment: the mission is canceled, the log is whole, nobody is left.

use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use rustix::process::Signal;
use serde_json::Value;

use crate::fixtures::experiment_file;
use crate::home::{Home, Process};

use super::report;

const SEED: &str = "AMBIDEX_TEST_SEED";
const MOMENTS: u32 = 6;
fn run(home: &Home, speed: &str) -> Process {
    let mission = experiment_file(1);
    let args = ["run", "--json", "--speed", speed].map(AsRef::as_ref);
    home.start(args.into_iter().chain([mission.as_os_str()]))
}

/// Numbers that look random, from a seed (splitmix64).
fn random(seed: &mut u64) -> u64 {
    *seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut mixed = *seed;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

fn seed() -> u64 {
    let now = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |now| now.as_secs());
    let seed = std::env::var(SEED).ok().map_or_else(now, |seed| seed.parse().expect("a number"));
    println!("{SEED}={seed}");
    seed
}

/// A run that is told to end after so long.
fn check(moment: Duration, with: Signal) {
    let home = Home::new();
    let mut run = run(&home, "20");
    // Before it says so it has begun nothing.
    run.says("waiting for");
    thread::sleep(moment);
    println!("{with:?} after {moment:?}");
    run.signal(with);
    let finished = run.ends(130);
    assert_eq!(report(&finished)["outcome"], "canceled");
    home.is_empty();
    let log = home.log();
    assert!(log.ends_with('\n'), "the log is whole");
    let records = log.lines().map(|line| serde_json::from_str(line).expect("a record"));
    let records: Vec<Value> = records.collect();
    let ends: Vec<_> = records.iter().filter(|record| record["record"] == "ended").collect();
    assert_eq!(ends.len(), 1, "{ends:?}");
    assert_eq!(ends[0]["end"], "canceled");
    assert_at_rest(&records);
}

#[test]
fn a_signal_cancels_the_mission_at_any_moment() {
    let mut seed = seed();
    thread::scope(|scope| {
        for count in 0..MOMENTS {
            // The first while controllers attach, the others anywhere.
            let until_ms = if count == 0 { 150 } else { 2500 };
            let moment = Duration::from_millis(random(&mut seed) % until_ms);
            let with = if count % 2 == 0 { Signal::INT } else { Signal::TERM };
            scope.spawn(move || check(moment, with));
        }
    });
}

/// Every command that a controller took has come to its result.
fn assert_at_rest(records: &[Value]) {
    let mut open = Vec::new();
    for record in records {
        let message = &record["message"]["message"];
        let key = |id: &Value| format!("{} {id}", record["controller"]);
        if message["accepted"].is_object() {
            open.push(key(&message["accepted"]["id"]));
        } else if message["result"].is_object() {
            let ended = key(&message["result"]["id"]);
            open.retain(|id| *id != ended);
        }
    }
    assert!(open.is_empty(), "under way in the end: {open:?}");
}

#[test]
fn a_second_signal_ends_it_at_once() {
    let home = Home::new();
    let mut run = run(&home, "0.05");
    run.says("step 1");
    thread::sleep(Duration::from_millis(800));
    run.signal(Signal::INT);
    thread::sleep(Duration::from_millis(200));
    assert!(!run.has_ended(), "it waits for the base to come to rest");
    run.signal(Signal::INT);
    let told = Instant::now();
    run.ends(130);
    assert!(told.elapsed() < Duration::from_secs(1), "{:?}", told.elapsed());
    crate::home::within(Duration::from_secs(2), "no process is left", || home.processes().is_empty());
}

#[test]
fn a_daemon_told_to_end_leaves_its_controllers() {
    let home = Home::new();
    let mut controllers: Vec<_> = super::CONTROLLERS.iter().map(|name| home.controller(name, &[])).collect();
    let mut daemon = home.daemon(&experiment_file(1), &["--json", "--speed", "20"]);
    daemon.says("step 3");
    daemon.signal(Signal::TERM);
    assert_eq!(report(&daemon.ends(130))["outcome"], "canceled");
    assert!(controllers.iter_mut().all(|controller| !controller.has_ended()));
    for controller in controllers {
        controller.signal(Signal::INT);
        controller.ends(0);
    }
    home.is_empty();
}
