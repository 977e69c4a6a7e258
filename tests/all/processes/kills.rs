//! `kill -9` of the runtime at any moment, and the run goes on in its log. `AMBIDEX_KILLS=100` sets how many kills,
//! `AMBIDEX_SEED=7` which ones.

use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use ambidex::model::{MissionEnd, Record};
use ambidex::record::Reader;
use rustix::process::Signal;

use crate::driver::Rng;
use crate::fixtures::{experiment_file, load, simulate};
use crate::home::{Home, Process};
use crate::resuming::state;

use super::CONTROLLERS;

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// Starts the mission, or goes on with it where there is a log.
fn go(home: &Home, verb: &str, log: &PathBuf) -> Process {
    let mission = experiment_file(1);
    let has_log = fs::read(log).is_ok_and(|log| log.contains(&b'\n'));
    let args: Vec<&OsStr> = match has_log {
        true => vec!["--resume".as_ref(), log.as_os_str()],
        false => vec![mission.as_os_str(), "--log".as_ref(), log.as_os_str()],
    };
    let common = [verb, "--quiet", "--speed", "20", "--instance", home.instance()].map(OsStr::new);
    home.start(common.into_iter().chain(args))
}

/// The log of a run as its records; nothing in it contradicts itself, and nothing is done twice.
fn check_log(home: &Home, log: &PathBuf) {
    let mission = load(&experiment_file(1));
    let records: Vec<Record> = Reader::open(log).expect("a log").map(|record| record.expect("a record")).collect();
    let undisturbed = simulate(&mission, &Default::default(), Vec::new()).0;
    let (came_to, expected) = (state(&mission, &records), state(&mission, &undisturbed));
    assert_eq!(came_to.world().objects, expected.world().objects);
    assert!(records.iter().any(|record| matches!(record, Record::Ended { end: MissionEnd::Done, .. })));
    let verified = home.start(["verify".as_ref(), log.as_os_str()]).ends(0);
    assert!(verified.stdout.starts_with("same: "), "{}", verified.stdout);
}

/// Kills the runtime up to three times in one mission, which is done in the end; how many kills that were.
fn killed(seed: u64, verb: &str) -> u64 {
    let home = Home::new();
    let log = home.path("run.jsonl");
    let controllers: Vec<Process> = match verb {
        "daemon" => CONTROLLERS.iter().map(|name| home.controller(name, &[])).collect(),
        _ => Vec::new(),
    };
    let mut rng = Rng::of(&[seed]);
    let mut kills = 0;
    for _ in 0..1 + rng.below(3) {
        let mut process = go(&home, verb, &log);
        let at = Instant::now() + Duration::from_millis(rng.below(3_000) as u64);
        while Instant::now() < at && !process.has_ended() {
            std::thread::sleep(Duration::from_millis(1));
        }
        kills += u64::from(!process.has_ended());
        process.signal(Signal::KILL);
        process.wait();
    }
    go(&home, verb, &log).ends(0);
    for mut controller in controllers {
        assert!(!controller.has_ended(), "a controller has not lived on");
        controller.signal(Signal::TERM);
        controller.ends(0);
    }
    check_log(&home, &log);
    home.is_empty();
    kills
}

#[test]
fn a_killed_runtime_goes_on_in_its_log() {
    let wanted = number("AMBIDEX_KILLS").unwrap_or(4);
    let seeds = number("AMBIDEX_SEED").unwrap_or_default()..;
    let mut kills = 0;
    for seed in seeds {
        let verb = if seed % 2 == 0 { "run" } else { "daemon" };
        kills += killed(seed, verb);
        if kills >= wanted {
            break;
        }
    }
    println!("{kills} kills");
}

#[test]
fn only_the_mission_of_the_log_goes_on_in_it() {
    let home = Home::new();
    let log = home.path("run.jsonl");
    let text = fs::read_to_string(experiment_file(1)).expect("a mission");
    let robot = crate::fixtures::file("config/robots/pr2.yaml");
    let text = text.replace("../robots/pr2.yaml", robot.to_str().expect("a path"));
    let mission = home.write("mine.yaml", &text);
    let other = home.write("other.yaml", &text.replace("mission: experiment-1", "mission: experiment-one"));
    let args = ["run".as_ref(), "--speed".as_ref(), "20".as_ref(), "--log".as_ref(), log.as_os_str()];
    let mut process = home.start(args.into_iter().chain([mission.as_os_str()]));
    process.says("step 1");
    process.signal(Signal::KILL);
    process.wait();
    let resume = |mission: &PathBuf| {
        let args = ["run".as_ref(), "--speed".as_ref(), "20".as_ref(), "--resume".as_ref(), log.as_os_str()];
        home.start(args.into_iter().chain([mission.as_os_str()]))
    };
    let refused = resume(&other).ends(2);
    let said =
        "is not the mission of the log: other.yaml:5 was `mission: experiment-1` and is `mission: experiment-one`";
    assert!(refused.words().contains(said), "{}", refused.words());
    // A line that is half-written, as by a writer that was killed, is removed.
    let mut torn = fs::OpenOptions::new().append(true).open(&log).expect("a log");
    std::io::Write::write_all(&mut torn, b"{\"record\":\"turn\",\"a").expect("it is written");
    drop(torn);
    let finished = resume(&mission).ends(0);
    assert!(finished.words().contains("the log was cut off in its last line"), "{}", finished.words());
    check_log(&home, &log);
    // What has ended does not go on.
    let again = resume(&mission).ends(0);
    assert!(again.words().contains("had ended"), "{}", again.words());
    home.is_empty();
}

#[test]
fn a_run_that_goes_on_can_be_ended_before_its_controllers_come() {
    let home = Home::new();
    let log = home.path("run.jsonl");
    let process = go(&home, "run", &log);
    crate::home::within(Duration::from_secs(20), "something runs", || {
        fs::read_to_string(&log).is_ok_and(|log| log.contains("\"granted\":[{"))
    });
    process.signal(Signal::KILL);
    process.wait();
    let mut daemon = go(&home, "daemon", &log);
    crate::home::within(Duration::from_secs(20), "it goes on", || {
        fs::read_to_string(&log).is_ok_and(|log| log.contains("resumed"))
    });
    assert!(!daemon.has_ended());
    daemon.signal(Signal::INT);
    daemon.ends(130);
    let text = fs::read_to_string(&log).expect("a log");
    assert!(text.contains("\"end\":\"interrupted\"") && text.contains("\"end\":\"canceled\""), "{text}");
    home.start(["verify".as_ref(), log.as_os_str()]).ends(0);
    for more in [&["--set", "object=mug"][..], &["--on-stall", "wait"]] {
        let args = ["run".as_ref(), "--resume".as_ref(), log.as_os_str()];
        home.start(args.into_iter().chain(more.iter().map(AsRef::as_ref))).ends(2);
    }
    home.is_empty();
}
