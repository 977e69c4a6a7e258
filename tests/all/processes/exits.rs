//! Exit codes and what is said with them; version and completions.

use crate::fixtures::{HANDS_FULL, experiment_file, mission, too_slow};
use crate::home::{Finished, Home};

use super::report;

fn ambidex(args: &[&str], code: i32) -> Finished {
    let home = Home::new();
    let finished = home.start(args).ends(code);
    home.is_empty();
    finished
}

#[test]
fn who_did_not_attach_in_time_is_named() {
    let home = Home::new();
    let head = home.controller("head", &["--once"]);
    let args = ["--attach-timeout", "0.5", "--json"];
    let finished = home.daemon(&experiment_file(1), &args).ends(4);
    let said = "× not attached in time: left_arm, right_arm, base";
    assert!(finished.stderr.contains(said), "{}", finished.stderr);
    head.ends(0);
    home.is_empty();
}

#[test]
fn wrong_usage_and_faulty_files_say_what_is_wrong() {
    let check = |args: &[&str], said: &str| {
        let finished = ambidex(args, 2);
        assert!(finished.words().contains(said), "{args:?}: {}", finished.stderr);
        assert_eq!(finished.stdout, "", "{args:?}");
    };
    let mission = "config/missions/experiment-1.yaml";
    check(&[], "Usage");
    check(&["dance"], "dance");
    check(&["run"], "<MISSION>");
    check(&["run", "no-such-file.yaml"], "no-such-file.yaml");
    check(&["daemon", "no-such-file.yaml"], "no-such-file.yaml");
    check(&["simulate", "no-such-file.yaml"], "no-such-file.yaml");
    check(&["run", mission, "--robot", "no-such-robot.yaml"], "no-such-robot.yaml");
    check(&["run", mission, "--speed", "0"], "0.01 to 1000");
    check(&["run", mission, "--speed", "inf"], "0.01 to 1000");
    check(&["run", mission, "--allocator", "best"], "greedy");
    check(&["run", mission, "--attach-timeout=-1"], "attach-timeout");
    check(&["run", mission, "--instance", "Not_A_Name"], "Not_A_Name");
    check(&["run", mission, "--log", "/proc/no/such.jsonl"], "/proc/no");
    check(&["controller", "tail"], "left_arm, right_arm, head, base");
    check(&["controller", "head", "--robot", "no-such-robot.yaml"], "no-such-robot.yaml");
    check(&["run", "Cargo.toml"], "Cargo.toml");
}

#[test]
fn a_stall_tells_the_reason_of_every_leaf() {
    let home = Home::new();
    let file = home.write("mission.yaml", &mission(HANDS_FULL));
    let file = file.to_str().expect("a path in UTF-8");
    for verb in [&["run", "--speed", "100"][..], &["simulate"]] {
        let finished = home.start(verb.iter().chain(&["--json", file])).ends(3);
        assert_eq!(report(&finished)["outcome"], "stalled");
        for said in ["pick 3", "every gripper is held or full"] {
            assert!(finished.stderr.contains(said), "{said}: {}", finished.stderr);
        }
    }
    home.is_empty();
}

#[test]
fn what_takes_too_long_fails_the_mission() {
    let home = Home::new();
    let mission = home.write("slow.yaml", &too_slow("pick: {object: 2}"));
    let finished = home.carry("run", &mission, &["--json", "--speed", "100"]).ends(1);
    assert_eq!(report(&finished)["outcome"], "failed");
    assert!(finished.words().contains("pick 2"), "{}", finished.stderr);
    home.is_empty();
}

#[test]
fn the_version_names_that_of_the_wire() {
    let said = ambidex(&["--version"], 0).stdout;
    let wire = format!("(wire version {})", ambidex::link::WIRE_VERSION);
    assert!(said.starts_with("ambidex ") && said.trim_end().ends_with(&wire), "{said}");
}

#[test]
fn help_states_exit_codes_and_grace() {
    let said = ambidex(&["--help"], 0).stdout;
    for word in ["Exit codes", "130", "within 3 s", "NO_COLOR"] {
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn shells_can_complete() {
    for shell in ["bash", "zsh", "fish"] {
        let script = ambidex(&["completions", shell], 0).stdout;
        for word in ["ambidex", "simulate", "attach-timeout"] {
            assert!(script.contains(word), "{shell} lacks {word}");
        }
    }
}
