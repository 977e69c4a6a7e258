//! The trace of messages on the terminal, and what else may stand there.

use serde_json::Value;

use crate::fixtures::experiment_file;
use crate::home::{Finished, Home};

const ESCAPE: char = '\u{1b}';

fn run(args: &[&str], environment: &[(&str, &str)]) -> Finished {
    let home = Home::new();
    let mission = experiment_file(1);
    let args = args.iter().map(AsRef::as_ref).chain([mission.as_os_str()]);
    let process = home.start_with(args, |command| {
        command.envs(environment.iter().copied());
    });
    let finished = process.ends(0);
    home.is_empty();
    finished
}

/// An event and the fields that it must have.
fn has_event(events: &[Value], message: &str, fields: &[&str]) {
    let found = events.iter().filter(|event| event["fields"]["message"] == message);
    let has_all = |event: &Value| fields.iter().all(|field| !event["fields"][*field].is_null());
    let found: Vec<_> = found.collect();
    assert!(
        found.iter().any(|event| has_all(event)),
        "no \"{message}\" with {fields:?} among {} like {:?}",
        found.len(),
        found.first()
    );
}

#[test]
fn every_message_is_an_event() {
    let args = ["run", "--quiet", "--speed", "20", "--log-format", "json"];
    let finished = run(&args, &[("RUST_LOG", "trace")]);
    let parse = |line: &str| match serde_json::from_str(line) {
        Ok(event) => event,
        Err(error) => panic!("{error}: {line}"),
    };
    let events: Vec<Value> = finished.stderr.lines().map(parse).collect();
    let edge = ["round", "from", "to"];
    let with = |more: &[&'static str]| [&edge[..], more].concat();
    has_event(&events, "activation", &edge);
    has_event(&events, "answer", &with(&["potential", "claims", "feasible"]));
    has_event(&events, "answer", &with(&["reason", "feasible"]));
    has_event(&events, "verdict", &with(&["granted"]));
    has_event(&events, "release", &with(&["leaf", "end"]));
    has_event(&events, "attached", &["controller"]);
    has_event(&events, "configure", &["controller", "generation", "speed"]);
    has_event(&events, "configured", &["controller", "generation"]);
    has_event(&events, "goal", &["controller", "goal", "leaf", "mode", "command"]);
    has_event(&events, "joined", &["controller", "goal", "leaf"]);
    has_event(&events, "accepted", &["controller", "goal"]);
    has_event(&events, "feedback", &["controller", "goal", "progress"]);
    has_event(&events, "cancel", &["controller", "goal"]);
    has_event(&events, "result", &["controller", "goal", "end"]);
    let sent = events.iter().filter(|event| event["target"] == "ambidex::tree");
    let report: Value = {
        let args = ["simulate", "--quiet", "--json"];
        serde_json::from_str(&run(&args, &[]).stdout).expect("a report")
    };
    assert!(sent.count() as u64 >= report["messages"].as_u64().expect("a number") / 2);
}

#[test]
fn quiet_says_nothing_and_no_log_line_is_asked_for() {
    let finished = run(&["run", "--quiet", "--speed", "100"], &[]);
    assert_eq!((finished.stdout.as_str(), finished.stderr.as_str()), ("", ""));
}

#[test]
fn without_a_terminal_there_are_plain_lines() {
    for (args, environment) in [
        (&["run", "--speed", "100"][..], ("TERM", "xterm-256color")),
        (&["simulate"], ("TERM", "xterm-256color")),
        (&["simulate"], ("NO_COLOR", "1")),
    ] {
        let finished = run(args, &[environment, ("RUST_LOG", "trace")]);
        assert!(!finished.stderr.contains(ESCAPE), "{}", finished.stderr);
        for said in ["step 1: move 2-1 (base)", "done in 10 steps", "log: "] {
            assert!(finished.stderr.contains(said), "{said}: {}", finished.stderr);
        }
        assert_eq!(finished.stdout, "");
    }
}

#[test]
fn color_can_be_forced_and_forbidden() {
    let args = ["simulate"];
    let forced = run(&args, &[("CLICOLOR_FORCE", "1")]);
    assert!(forced.stderr.contains(ESCAPE));
    let forbidden = run(&args, &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]);
    assert!(!forbidden.stderr.contains(ESCAPE));
}
