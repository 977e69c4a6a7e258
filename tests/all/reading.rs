//! Logs read back by the program: as a conversation, and explained.

mod explain;
mod trace;

use std::fs;
use std::path::{Path, PathBuf};

use crate::fixtures::experiment_file;
use crate::home::Home;

/// A home with the log of a simulated experiment.
fn simulated(number: u32) -> (Home, PathBuf) {
    let home = Home::new();
    let log = home.path("log.jsonl");
    let args = ["simulate", "--quiet", "--log"].map(AsRef::as_ref);
    home.start(args.into_iter().chain([log.as_os_str(), experiment_file(number).as_os_str()])).ends(0);
    (home, log)
}

/// What the program prints of a log.
fn printed(home: &Home, verb: &str, log: &str, more: &[&str]) -> String {
    let finished = home.start([verb, log].iter().chain(more)).ends(0);
    assert_eq!(finished.stderr, "", "{verb} {more:?}");
    finished.stdout
}

/// What the program says of a log that it cannot serve.
fn refused(home: &Home, verb: &str, log: &str, more: &[&str]) -> String {
    let finished = home.start([verb, log].iter().chain(more)).ends(2);
    assert_eq!(finished.stdout, "", "{verb} {more:?}");
    finished.words()
}

#[test]
fn a_log_that_was_cut_off_is_read_to_the_cut() {
    let (home, log) = simulated(1);
    let whole = fs::read(&log).expect("a log");
    let lines = whole.iter().filter(|byte| **byte == b'\n').count();
    fs::write(&log, &whole[..whole.len() - 10]).expect("a file");
    let log = log.to_str().expect("a path");
    let said = format!("the log was cut off in its last line; {} records read", lines - 1);
    let trace = home.start(["trace", "--feedback", log]).ends(0);
    assert_eq!(trace.words(), said);
    assert_eq!(trace.stdout.lines().count(), lines - 1);
    let story = home.start(["explain", log]).ends(0);
    assert_eq!(story.words(), said);
    assert!(story.stdout.contains("the log ends before the mission did"), "{}", story.stdout);
    assert_eq!(home.start(["explain", log, "pick 1"]).ends(0).words(), said);
}

#[test]
fn what_is_no_log_is_refused_with_the_reason() {
    let (home, log) = simulated(1);
    let text = fs::read_to_string(&log).expect("a log");
    let other = home.write("other.jsonl", &text.replacen("\"version\":", "\"version\":90", 1));
    let other = other.to_str().expect("a path");
    let none = home.write("none.jsonl", "mission: tea\n");
    let none = none.to_str().expect("a path");
    for verb in ["trace", "explain"] {
        let said = refused(&home, verb, other, &[]);
        assert!(said.contains("has version 90") && said.contains("this program reads version"), "{said}");
        assert!(refused(&home, verb, none, &[]).contains("is no journal"));
        let said = refused(&home, verb, "elsewhere", &[]);
        assert!(said.contains("there is no log `elsewhere`") && said.contains("elsewhere/journal.jsonl"), "{said}");
        assert!(refused(&home, verb, "no/such.jsonl", &[]).contains("there is no log `no/such.jsonl`"));
    }
    let broken = home.write("broken.jsonl", &text.replacen("{\"record\":\"decided\"", "{\"record\":\"dreamt\"", 1));
    let finished = home.start(["trace", broken.to_str().expect("a path")]).ends(2);
    assert!(finished.words().contains("is not a record"), "{finished:?}");
}

#[test]
fn a_log_is_found_by_its_instance_and_the_newest_by_nothing() {
    let home = Home::new();
    let args = ["simulate", "--quiet"].map(AsRef::as_ref);
    home.start(args.into_iter().chain([experiment_file(2).as_os_str()])).ends(0);
    assert!(printed(&home, "explain", "simulate", &[]).starts_with("experiment-2 on pr2"));
    assert!(printed(&home, "trace", "simulate", &["--kind", "ended"]).contains("the mission is over: done"));
    let newest = home.start(["explain"]).ends(0);
    assert!(newest.stdout.starts_with("experiment-2 on pr2") && newest.words().ends_with("journal.jsonl"));
    let told = "log: experiment-2, written just now: ";
    assert!(newest.words().starts_with(told), "whose log it is, since a later attempt may have left none: {newest:?}");
    let nothing = Home::new().start(["trace"]).ends(2);
    assert!(nothing.words().contains("no run has left a log"), "{nothing:?}");
}

/// Letters at which a terminal does something.
fn speaks(text: &str) -> bool {
    text.chars().any(|letter| letter.is_control() && letter != '\n')
}

#[test]
fn no_name_and_no_path_speaks_to_the_terminal() {
    let (home, log) = simulated(1);
    let mut text = fs::read_to_string(&log).expect("a log");
    for name in ["experiment-1", "pr2", "greedy", "move 1-1", "pick 1", "all", "base", "left_arm", "left_gripper"] {
        text = text.replacen(&format!("\"{name}\""), &format!("\"\\u001b[2J\\u0007{name}\""), 1);
    }
    for list in ["objects", "places", "channels", "types"] {
        text = text.replacen(&format!("\"{list}\":[\""), &format!("\"{list}\":[\"\\u001b]0;\\u0007"), 1);
    }
    let cut = home.write("cut.jsonl", &text[..text.len() * 2 / 3]);
    let odd = home.write("odd\u{1b}[2J\u{7}.jsonl", &text);
    let missing = home.path("no\u{1b}[2J\u{7}.jsonl");
    let broken = home.write("broken\u{1b}[2J\u{7}.jsonl", "mission: tea\n");
    for log in [&cut, &odd, &missing, &broken] {
        let log = log.to_str().expect("a path");
        let verbs: [&[&str]; 8] = [
            &["trace", "--feedback", log],
            &["trace", "--json", log],
            &["trace", log, "--node", "\u{1b}[2J"],
            &["explain", log],
            &["explain", log, "*"],
            &["tree", log],
            &["timeline", log],
            &["status", "--log", log],
        ];
        // What is no log is a mission to `tree`, and told by whoever reads missions.
        let is_log = Path::new(log).exists() && !log.contains("broken");
        for verb in verbs.into_iter().filter(|verb| is_log || verb[0] != "tree") {
            let told = home.start(verb).wait();
            assert!(!speaks(&told.stdout) && !speaks(&told.stderr), "{verb:?}: {told:?}");
            assert!(!told.stdout.is_empty() || !told.stderr.is_empty(), "{verb:?}");
        }
    }
}
