//! `run --fail`: what goes wrong on purpose goes wrong with real processes, and nothing of it is left.

use std::fs;
use std::path::Path;

use crate::fixtures::{experiment_file, file};
use crate::home::{Finished, Home};

fn run(home: &Home, mission: &Path, failures: &str, more: &[&str]) -> (Finished, String) {
    let failures = home.write("failures.yaml", &format!("failures:\n{failures}"));
    let log = home.path("run.jsonl");
    let args = ["run".as_ref(), mission.as_os_str(), "--fail".as_ref(), failures.as_os_str(), "--log".as_ref()];
    let more = ["--speed", "5"].iter().chain(more).map(AsRef::as_ref);
    let finished = home.start(args.into_iter().chain([log.as_os_str()]).chain(more)).wait();
    let verified = home.start(["verify".as_ref(), log.as_os_str()]).ends(0);
    assert!(verified.stdout.starts_with("same: "), "{}", verified.stdout);
    home.is_empty();
    let log = fs::read_to_string(log).expect("a log");
    (finished, log)
}

fn says(finished: &Finished, words: &[&str]) {
    for words in words {
        assert!(finished.stderr.contains(words), "\"{words}\" is not in\n{}", finished.stderr);
    }
}

#[test]
fn a_killed_controller_is_started_again() {
    let home = Home::new();
    let failures = "  - {at: 2 s, lose: left_arm}\n  - {at: 2500 ms, return: left_arm}\n";
    let (finished, log) = run(&home, &experiment_file(1), failures, &[]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    says(&finished, &["on purpose: left_arm is killed", "left_arm is unavailable: its process ended"]);
    says(&finished, &["on purpose: left_arm is started again", "left_arm is back"]);
    assert!(log.contains("\"lost\""), "the log tells it");
}

#[test]
fn a_stopped_controller_goes_on() {
    let home = Home::new();
    let failures = "  - {at: 2 s, hang: base}\n  - {at: 4 s, return: base}\n";
    let (finished, _) = run(&home, &experiment_file(1), failures, &[]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    says(&finished, &["on purpose: base is stopped", "on purpose: base goes on"]);
}

#[test]
fn one_that_was_stopped_for_long_is_lost_and_comes_back() {
    let home = Home::new();
    let failures = "  - {at: 2 s, hang: base}\n  - {at: 10 s, return: base}\n";
    let (finished, _) = run(&home, &experiment_file(1), failures, &[]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    says(&finished, &["base is unavailable: it showed no life for 1 s", "on purpose: base goes on", "base is back"]);
}

#[test]
fn a_controller_that_stays_stopped_holds_up_no_end() {
    let home = Home::new();
    let (finished, log) = run(&home, &experiment_file(1), "  - {at: 2 s, hang: base}\n", &["--reattach-timeout", "1"]);
    assert_eq!(finished.code, Some(4), "{}", finished.stderr);
    says(&finished, &["on purpose: base is stopped", "base is unavailable: it showed no life for 1 s"]);
    assert!(log.contains("\"lost\""), "the log tells it");
}

#[test]
fn an_emergency_stop_stops_one_arm_only() {
    let home = Home::new();
    let failures = "  - {at: 1 s, inhibit: left_arm}\n  - {at: 6 s, return: left_arm}\n";
    let (finished, log) = run(&home, &file("config/missions/scan.yaml"), failures, &[]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    says(
        &finished,
        &["on purpose: the emergency stop of left_arm is pressed", "left_arm is inhibited: emergency stop"],
    );
    says(&finished, &["interrupted fetch blood", "on purpose: the emergency stop of left_arm is released"]);
    let at = |words: &str| finished.stderr.rfind(words).unwrap_or_else(|| panic!("{words}\n{}", finished.stderr));
    assert!(at("done shake water") < at("left_arm is back"), "the other arm carries on\n{}", finished.stderr);
    assert!(at("fetch blood (left_gripper)") > at("left_arm is back"), "it is used again\n{}", finished.stderr);
    assert!(log.contains("\"inhibited\":\"emergency_stop\"") && log.contains("\"generation\":2"), "the log tells it");
    assert!(!finished.stderr.contains("failed"), "{}", finished.stderr);
}

#[test]
fn who_is_inhibited_is_awaited_without_limit() {
    let home = Home::new();
    let failures = "  - {at: 2 s, inhibit: scanner}\n  - {at: 25 s, return: scanner}\n";
    let (finished, _) = run(&home, &file("config/missions/scan.yaml"), failures, &["--reattach-timeout", "1"]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    says(&finished, &["scanner is inhibited: emergency stop", "which is awaited for as long as it is inhibited"]);
    says(&finished, &["scanner is back", "done scan blood", "done scan water"]);
}

#[test]
fn calls_are_carried_out_by_processes() {
    let home = Home::new();
    let failures = "  - {behavior: scan water, fails: aborted}\n";
    let (finished, log) = run(&home, &file("config/missions/scan.yaml"), failures, &[]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    says(&finished, &["attached scanner", "failed scan water: scanner gave up", "done scan water", "done spin"]);
    let called = r#"{"call":{"name":"scan","with":"{\"object\":\"blood\",\"resolution\":600.0}","takes":"#;
    assert!(log.contains(called), "the log tells it");
}

#[test]
fn behaviors_fail_and_hang_and_the_world_changes() {
    let home = Home::new();
    let text = fs::read_to_string(file("config/missions/desk.yaml")).expect("a mission");
    let robot = file("config/robots/desk.yaml");
    let text = text.replace("../robots/desk.yaml", robot.to_str().expect("a path in UTF-8"));
    let mission = home.write("desk.yaml", &text.replace("takes: 3 s", "takes: 3 s\n    timeout: 5 s"));
    let failures = "  - {behavior: inspect tray, fails: aborted}\n  - {behavior: inspect tray, attempt: 2, hangs: true}\n  \
                    - {at: 1 s, set: seen pad}\n";
    let (finished, _) = run(&home, &mission, failures, &[]);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    says(&finished, &["on purpose: inspect tray gives up in the end, attempt 1", "failed inspect tray: head gave up"]);
    says(
        &finished,
        &["on purpose: inspect tray does not end by itself, attempt 2", "failed inspect tray: it took too long"],
    );
    says(&finished, &["on purpose: somebody sets seen pad"]);
}

#[test]
fn a_gripper_lets_go() {
    let home = Home::new();
    let (finished, log) = run(&home, &experiment_file(1), "  - {behavior: move 1-2, drops: 1}\n", &[]);
    assert_eq!(finished.code, Some(0), "it is picked again: {}", finished.stderr);
    says(&finished, &["on purpose: move 1-2 drops object 1", "object 1 is at shelf now", "done move 1-2"]);
    assert!(log.contains("\"generation\":2"), "the arm was configured anew");
}
