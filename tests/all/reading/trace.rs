//! `ambidex trace`: filters, JSON, a reader that leaves, and a log that is still being written.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::Duration;

use rustix::process::Signal;
use serde_json::Value;

use super::{printed, refused, simulated};
use crate::fixtures::experiment_file;
use crate::home::{Home, within};

#[test]
fn every_record_is_one_line_and_filters_combine() {
    let (home, log) = simulated(1);
    let records = fs::read_to_string(&log).expect("a log").lines().count();
    let log = log.to_str().expect("a path");
    let lines =
        |more: &[&str]| -> Vec<String> { printed(&home, "trace", log, more).lines().map(str::to_owned).collect() };
    assert_eq!(lines(&["--feedback"]).len(), records);
    let quiet = lines(&[]);
    assert!(quiet.len() < records / 2 && quiet.iter().all(|line| !line.ends_with(" %")), "{}", quiet.len());
    let decisions = lines(&["--kind", "decided"]);
    assert_eq!(decisions.len(), 23);
    let third = lines(&["--kind", "decided", "--round", "3"]);
    assert_eq!(third, [decisions[2].clone()]);
    assert!(third[0].contains("grants pick 1 right_gripper alone, base and head for \"at shelf\""), "{third:?}");
    assert_eq!(lines(&["--kind", "decided", "--round", "3..5"]), decisions[2..5]);
    let goals = lines(&["--controller", "left_arm", "--kind", "goal", "--kind", "result"]);
    assert_eq!(goals.len(), 8);
    assert!(goals[0].contains("pick 2 → left_arm") && goals[0].contains("grasp object 2"), "{goals:?}");
    assert!(goals[1].contains("left_arm → pick 2") && goals[1].contains("succeeded after"), "{goals:?}");
    let of_pick = lines(&["--node", "pick 1", "--kind", "feedback"]);
    assert!(!of_pick.is_empty() && of_pick.iter().all(|line| line.contains("pick 1")), "{of_pick:?}");
    let picks = lines(&["--node", "pick [12]", "--kind", "released"]);
    assert_eq!(picks.len(), 2);
    let base = lines(&["--resource", "base", "--kind", "resource", "--to", "0"]);
    assert!(base.len() == 1 && base[0].ends_with("is in use by move 2-1, alone"), "{base:?}");
    let late = lines(&["--from", "58"]);
    assert!(late.len() > 2 && late.last().is_some_and(|line| line.contains("the mission is over: done")), "{late:?}");
}

#[test]
fn nothing_that_is_asked_for_is_said_to_be_nothing() {
    let (home, log) = simulated(1);
    let log = log.to_str().expect("a path");
    for none in [["--round", "99"], ["--from", "9000"]] {
        let finished = home.start(["trace", log].iter().chain(&none)).ends(0);
        assert_eq!(
            (finished.stdout.as_str(), finished.words().as_str()),
            ("", "the log has no record that is asked for")
        );
    }
    let said = refused(&home, "trace", log, &["--from", "9", "--to", "3"]);
    assert!(said.contains("nothing lies between --from 9.00 s and --to 3.00 s"), "{said}");
}

#[test]
fn json_lines_have_names() {
    let (home, log) = simulated(1);
    let records = fs::read_to_string(&log).expect("a log").lines().count();
    let text = printed(&home, "trace", log.to_str().expect("a path"), &["--json", "--feedback"]);
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(lines.len(), records);
    let decided: Vec<&Value> = lines.iter().filter(|line| line["record"] == "decided").collect();
    assert_eq!(decided[0]["granted"][0]["leaf"], "move 2-1");
    assert_eq!(decided[0]["refused"][0]["reason"]["outbid"]["by"], "move 2-1");
    assert_eq!(decided[2]["granted"][0]["skips"], serde_json::json!([["move 1-1"]]));
    let heard = lines.iter().find(|line| line["message"]["kind"] == "heard").expect("a controller says something");
    assert_eq!(heard["controller"], "left_arm");
}

#[test]
fn unknown_names_are_told_with_what_there_is() {
    let (home, log) = simulated(1);
    let log = log.to_str().expect("a path");
    let check = |more: &[&str], words: &[&str]| {
        let said = refused(&home, "trace", log, more);
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    };
    check(&["--node", "pik*"], &["there is no node `pik*`", "allowed: `root`"]);
    check(&["--resource", "heat"], &["there is no resource `heat`", "did you mean `head`?", "`left_gripper`"]);
    check(&["--controller", "arm"], &["there is no controller `arm`", "`left_arm`, `right_arm`"]);
    check(&["--kind", "decision"], &["invalid value 'decision'", "decided"]);
    check(&["--round", "5..3"], &["rounds A..B"]);
    check(&["--from", "soon"], &["seconds of robot time"]);
}

#[test]
fn a_reader_may_leave_before_the_end() {
    let (home, log) = simulated(1);
    let mut child = Command::new(env!("CARGO_BIN_EXE_ambidex"))
        .arg("trace")
        .arg(&log)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut first = String::new();
    BufReader::new(child.stdout.take().expect("its output")).read_line(&mut first).expect("a line");
    assert!(first.starts_with("experiment-1 on pr2"), "{first}");
    let finished = child.wait_with_output().expect("it ends");
    assert_eq!((finished.status.code(), finished.stderr), (Some(0), Vec::new()));
    home.is_empty();
}

#[test]
fn a_live_log_is_followed_to_the_end_of_its_mission() {
    let home = Home::new();
    let log = home.path("live.jsonl");
    let log = log.to_str().expect("a path");
    let mut follower = home.start(["trace", "--follow", "--json", log]);
    follower.says("waiting for");
    let run = home.carry("run", &experiment_file(1), &["--speed", "100", "--quiet", "--log", log]);
    run.ends(0);
    let followed = follower.ends(0);
    assert_eq!(followed.stdout, printed(&home, "trace", log, &["--json"]));
    assert!(followed.stdout.contains("\"record\":\"ended\""), "{}", followed.stdout);
    home.is_empty();
}

#[test]
fn a_line_is_told_once_it_is_whole_and_a_new_run_is_noticed() {
    let (home, whole) = simulated(1);
    let text = fs::read_to_string(&whole).expect("a log");
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let live = home.path("live.jsonl");
    let mut file = fs::File::create(&live).expect("a file");
    file.write_all(lines[..20].concat().as_bytes()).expect("written");
    file.write_all(&lines[20].as_bytes()[..9]).expect("written");
    let mut follower = home.start(["trace", "--feedback", "--follow", live.to_str().expect("a path")]);
    let told = |number: usize| fs::read_to_string(home.path("1.out")).is_ok_and(|out| out.lines().count() == number);
    within(Duration::from_secs(20), "what is whole is told", || told(20));
    file.write_all(&lines[20].as_bytes()[9..]).expect("written");
    within(Duration::from_secs(20), "the line is told", || told(21));
    fs::remove_file(&live).expect("removed");
    fs::copy(&whole, &live).expect("another run");
    follower.says("a new run began in");
    let followed = follower.ends(0);
    assert_eq!(followed.stdout.lines().count(), 21 + lines.len());
}

#[test]
fn following_ends_on_a_signal() {
    let (home, log) = simulated(1);
    let text = fs::read_to_string(&log).expect("a log");
    let unfinished: String = text.lines().take(50).map(|line| format!("{line}\n")).collect();
    let live = home.write("live.jsonl", &unfinished);
    let follower = home.start(["trace", "--feedback", "--follow", live.to_str().expect("a path")]);
    let out = home.path("1.out");
    let told = || fs::read_to_string(&out).is_ok_and(|out| out.lines().count() == 50);
    within(Duration::from_secs(20), "all is told", told);
    follower.signal(Signal::INT);
    assert_eq!(follower.ends(0).stdout.lines().count(), 50);
}
