//! `ambidex status` beside real daemons and controllers, and on logs of any kind.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::thread;
use std::time::Duration;

use ambidex::link::Instance;
use ambidex::model::JOURNAL_VERSION;
use rustix::process::Signal;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};
use serde_json::Value;

use crate::fixtures::{HANDS_FULL, experiment_file, mission};
use crate::home::{Home, Process, within};

const CONTROLLERS: [&str; 4] = ["left_arm", "right_arm", "head", "base"];
/// Within which something that happened must be seen.
const SOON: Duration = Duration::from_secs(20);

fn daemon(home: &Home, speed: &str) -> Process {
    let mut daemon = home.daemon(&experiment_file(1), &["--json", "--speed", speed]);
    daemon.says("waiting for");
    daemon
}

fn controllers(home: &Home) -> Vec<Process> {
    CONTROLLERS.iter().map(|name| home.controller(name, &["--once"])).collect()
}

fn parse(line: &str) -> Value {
    serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))
}

/// What `status --json` says, which ends with this code.
fn told(home: &Home, code: i32) -> Value {
    let finished = home.status(&["--json"]).ends(code);
    assert_eq!(finished.stdout.lines().count(), 1, "{finished:#?}");
    parse(&finished.stdout)
}

fn row<'a>(told: &'a Value, list: &str, name: &str) -> &'a Value {
    let rows = told[list].as_array().expect("a list");
    rows.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("{name} in {list}"))
}

/// Names of nodes that are so.
fn nodes(told: &Value, state: &str) -> Vec<String> {
    let rows = told["nodes"].as_array().expect("a list").iter();
    rows.filter(|row| row["state"] == state).map(|row| row["name"].as_str().expect("a name").to_owned()).collect()
}

/// A status agrees with the report of the same run.
fn assert_agrees(told: &Value, report: &Value) {
    for key in ["mission", "outcome", "rounds", "messages", "makespan_s"] {
        assert_eq!(told[key], report[key], "{key}");
    }
    assert_eq!(told["step"].as_u64(), report["steps"].as_array().map(|steps| steps.len() as u64));
    let mut skipped: Vec<String> = serde_json::from_value(report["skipped"].clone()).expect("names");
    skipped.sort();
    let is_leaf = |name: &String| row(told, "nodes", name)["of"] == 1;
    let mut told: Vec<String> = nodes(told, "skipped").into_iter().filter(is_leaf).collect();
    told.sort();
    assert_eq!(told, skipped);
}

#[test]
fn a_daemon_that_waits_says_for_whom() {
    let home = Home::new();
    let daemon = daemon(&home, "100");
    let head = home.controller("head", &["--once"]);
    // Nothing happens after it attached, so what is seen was flushed.
    within(SOON, "the head is there", || row(&told(&home, 0), "controllers", "head")["health"] == "OK");
    let told = told(&home, 0);
    assert_eq!(told["daemon"], serde_json::json!({"state": "running", "pid": daemon.pid()}));
    assert_eq!((&told["phase"], &told["outcome"]), (&"waiting".into(), &Value::Null));
    let base = row(&told, "controllers", "base");
    assert_eq!((&base["health"], &base["why"]), (&"STALE".into(), &"not yet attached".into()));
    assert_eq!(told["world"]["objects"][0], serde_json::json!({"name": "1", "at": "shelf", "in": []}));
    let text = home.status(&[]).ends(0).stdout;
    assert!(text.starts_with("experiment-1  waiting for left_arm, right_arm, base"), "{text}");
    daemon.signal(Signal::TERM);
    daemon.ends(130);
    head.ends(0);
    home.is_empty();
}

#[test]
fn a_running_mission_is_told_and_not_disturbed() {
    let home = Home::new();
    let mut daemon = daemon(&home, "4");
    let controllers = controllers(&home);
    daemon.says("step 2");
    let now = told(&home, 0);
    assert_eq!(now["phase"], "running");
    assert!(now["step"].as_u64() >= Some(2), "{now}");
    assert!(nodes(&now, "active").contains(&"root".to_owned()), "{now}");
    let resources = now["resources"].as_array().expect("a list");
    for resource in resources {
        let owners = resource["owners"].as_u64().expect("a number");
        assert_eq!(resource["locked"], owners > 0, "{resource}");
        assert_eq!(resource["holders"].as_array().map(|holders| holders.len() as u64), Some(owners));
    }
    assert!(resources.iter().any(|resource| resource["locked"] == true), "{now}");
    assert_eq!(row(&now, "resources", "base")["controller"], "base");
    let text = home.status(&[]).ends(0).stdout;
    for said in ["running", "locked", "gripper", "its turn comes after"] {
        assert!(text.contains(said), "{said}: {text}");
    }
    daemon.signal(Signal::TERM);
    let finished = daemon.ends(130);
    controllers.into_iter().for_each(|controller| drop(controller.ends(0)));
    let over = told(&home, 0);
    assert_eq!((&over["phase"], &over["daemon"]["state"]), (&"ended".into(), &"gone".into()));
    assert_agrees(&over, &parse(&finished.stdout));
    home.is_empty();
}

#[test]
fn whoever_watches_sees_every_phase_and_ends_with_the_mission() {
    let home = Home::new();
    let daemon = daemon(&home, "50");
    let watch = home.status(&["--json", "--watch"]);
    let plain = home.status(&["--watch"]);
    within(SOON, "both watch", || [&watch, &plain].iter().all(|process| !process.stdout().is_empty()));
    let controllers = controllers(&home);
    let report = parse(&daemon.ends(0).stdout);
    controllers.into_iter().for_each(|controller| drop(controller.ends(0)));
    let seen: Vec<Value> = watch.ends(0).stdout.lines().map(parse).collect();
    let mut phases: Vec<&Value> = seen.iter().map(|told| &told["phase"]).collect();
    phases.dedup();
    assert_eq!(phases, ["waiting", "running", "ended"]);
    assert!(seen.is_sorted_by_key(|told| told["rounds"].as_u64()));
    assert!(seen.windows(2).all(|pair| pair[0] != pair[1]), "only changes are told");
    let last = seen.last().expect("at least one");
    assert_agrees(last, &report);
    assert_eq!(*last, told(&home, 0));
    let plain = plain.ends(0);
    assert!(!plain.stdout.contains('\u{1b}'), "{}", plain.stdout);
    assert_eq!(plain.stderr, "the mission ended: done\n");
    home.is_empty();
}

#[test]
fn whoever_watches_waits_for_a_daemon_that_is_not_there_yet() {
    let home = Home::new();
    let mut watch = home.status(&["--json", "--watch"]);
    watch.says("waiting for a daemon of instance");
    let log = home.path("later.jsonl");
    let mut other = home.start(["status", "--watch", "--log", log.to_str().expect("a path")]);
    other.says("waiting for");
    fs::write(&log, "mission: tea\n").expect("a file");
    assert!(other.ends(2).words().contains("is no journal"));
    let daemon = home.daemon(&experiment_file(1), &["--quiet", "--speed", "100"]);
    let controllers = controllers(&home);
    daemon.ends(0);
    controllers.into_iter().for_each(|controller| drop(controller.ends(0)));
    assert_eq!(watch.ends(0).stdout.lines().next_back().map(parse).expect("a line")["outcome"], "done");
    home.is_empty();
}

#[test]
fn a_killed_daemon_is_told_as_gone() {
    let home = Home::new();
    let mut daemon = daemon(&home, "2");
    let controllers = controllers(&home);
    daemon.says("step 2");
    let watch = home.status(&["--watch", "--json"]);
    within(SOON, "it watches", || !watch.stdout().is_empty());
    daemon.signal(Signal::KILL);
    assert_eq!(daemon.wait().code, None);
    let watched = watch.ends(4);
    let said = "error: the daemon is gone (crashed or killed) and its mission did not end\n";
    assert_eq!(watched.stderr, said);
    assert_eq!(watched.stdout.lines().next_back().map(parse).expect("a line")["phase"], "gone");
    let gone = told(&home, 4);
    assert_eq!((&gone["phase"], &gone["outcome"]), (&"gone".into(), &Value::Null));
    assert_eq!(row(&gone, "controllers", "base")["why"], "the daemon is gone");
    controllers.into_iter().for_each(|controller| drop(controller.ends(0)));
    // The journal of a daemon that logs elsewhere is not the one that lies there.
    let other = home.path("other.jsonl");
    let other = other.to_str().expect("a path in UTF-8");
    let mut next = home.daemon(&experiment_file(1), &["--log", other]);
    next.says("waiting for");
    assert_eq!(told(&home, 4)["daemon"]["state"], "gone");
    let named = home.status(&["--log", other, "--json"]).ends(0).stdout;
    assert_eq!(parse(&named)["daemon"]["pid"], next.pid());
    next.signal(Signal::TERM);
    next.ends(130);
    home.is_empty();
}

#[test]
fn a_lost_controller_is_told_with_the_end() {
    let home = Home::new();
    let mut daemon = daemon(&home, "2");
    let controllers = controllers(&home);
    daemon.says("step 1");
    controllers[3].signal(Signal::KILL);
    let report = parse(&daemon.ends(4).stdout);
    let told = told(&home, 0);
    assert_agrees(&told, &report);
    let base = row(&told, "controllers", "base");
    assert_eq!(base["health"], "ERROR");
    assert!(
        base["why"].as_str().is_some_and(|why| why.starts_with("lost at ") && why.ends_with(": its process ended")),
        "{base}"
    );
    assert!(told["why"].as_str().is_some_and(|why| why.starts_with("the controller base was lost")), "{told}");
}

#[test]
fn without_a_journal_it_is_said_who_has_one() {
    let home = Home::new();
    let nobody = home.start(["status"]).ends(2);
    assert!(nobody.words().contains("instance \"default\" has no journal, and no other has one"), "{nobody:#?}");
    let mut daemon = home.daemon(&experiment_file(1), &[]);
    daemon.says("waiting for");
    let name = home.instances()[0].name().to_owned();
    let misspelled = format!("{name}x");
    let refused = home.start(["status", "--instance", &misspelled]).ends(2);
    let said = format!("did you mean \"{name}\"?");
    assert!(refused.words().contains(&said) && refused.words().contains(&format!("{name} (running)")), "{refused:#?}");
    assert_eq!(refused.stdout, "");
    assert!(!Instance::new(&misspelled).expect("a name").has_left_anything());
    assert!(!home.path("ambidex").join(&misspelled).exists(), "asking makes nothing");
    daemon.signal(Signal::TERM);
    daemon.ends(130);
    home.is_empty();
}

#[test]
fn any_log_is_told_as_far_as_it_goes() {
    let home = Home::new();
    let file = home.write("mission.yaml", &mission(HANDS_FULL));
    let log = home.path("run.jsonl");
    let args = ["simulate", "--quiet", "--json", "--log"].map(AsRef::as_ref);
    let simulated = home.start(args.into_iter().chain([log.as_os_str(), file.as_os_str()])).ends(3);
    let status = |log: &str, code: i32| {
        let path = home.path(log);
        home.start([["status", "--json", "--log"].map(AsRef::as_ref).as_slice(), &[path.as_os_str()]].concat())
            .ends(code)
    };
    let stalled = parse(&status("run.jsonl", 0).stdout);
    assert_agrees(&stalled, &parse(&simulated.stdout));
    assert_eq!(stalled["daemon"]["state"], "gone");
    assert_eq!(row(&stalled, "nodes", "pick 3")["reason"], "was waiting: every gripper is held or full");
    let whole = fs::read_to_string(&log).expect("a log");
    home.write("cut.jsonl", &whole[..whole.len() / 2]);
    let cut = status("cut.jsonl", 4);
    assert!(cut.words().contains("the daemon is gone (crashed or killed)"), "{cut:?}");
    let cut = parse(&cut.stdout);
    assert_eq!((&cut["phase"], &cut["outcome"]), (&"gone".into(), &Value::Null));
    let writer = fs::File::open(home.path("cut.jsonl")).expect("a log");
    writer.lock().expect("the log is held");
    let written = parse(&status("cut.jsonl", 0).stdout);
    assert_eq!((&written["phase"], &written["daemon"]["state"]), (&"running".into(), &"running".into()));
    drop(writer);
    status("cut.jsonl", 4);
    let version = format!("\"version\":{JOURNAL_VERSION}");
    home.write("newer.jsonl", &whole.replacen(&version, "\"version\":77", 1));
    let said = status("newer.jsonl", 2).words();
    let both = format!("has version 77; this program reads version {JOURNAL_VERSION}");
    assert!(said.contains(&both), "{said}");
    home.write("none.jsonl", "mission: x\n");
    assert!(status("none.jsonl", 2).words().contains("is no journal"));
    home.write("empty.jsonl", "");
    assert!(status("empty.jsonl", 2).words().contains("is no journal"));
    assert!(status("missing.jsonl", 2).words().contains("missing.jsonl"));
    home.is_empty();
}

/// A terminal of 24 lines: whoever looks at it, and what a process gets as its own.
fn terminal() -> (File, File) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&master).and_then(|()| unlockpt(&master)).expect("a terminal");
    let path = ptsname(&master, Vec::new()).expect("a name");
    let slave = File::options().read(true).write(true).open(path.to_str().expect("a path")).expect("a terminal");
    tcsetwinsize(&slave, Winsize { ws_row: 24, ws_col: 100, ws_xpixel: 0, ws_ypixel: 0 }).expect("a size");
    (File::from(master), slave)
}

/// A mission is watched in a terminal until something is done to it; what the terminal then has shown.
fn watched(code: i32, act: impl FnOnce(&mut File, &Process)) -> String {
    let home = Home::new();
    let args = ["simulate", "--quiet", "--log"].map(AsRef::as_ref);
    let log = home.path("run.jsonl");
    home.start(args.into_iter().chain([log.as_os_str(), experiment_file(1).as_os_str()])).ends(0);
    let whole = fs::read_to_string(&log).expect("a log");
    let cut = home.write("cut.jsonl", &whole[..whole.len() / 2]);
    let writer = File::open(&cut).expect("a log");
    writer.lock().expect("the log is held");
    let (mut looks, own) = terminal();
    let before = tcgetattr(&own).expect("modes").local_modes;
    let args = ["status", "--watch", "--log"].map(AsRef::as_ref);
    let process = home.start_with(args.into_iter().chain([cut.as_os_str()]), |command| {
        let end = || own.try_clone().expect("a terminal");
        command.stdin(end()).stdout(end()).stderr(end());
    });
    let mut seen = Vec::new();
    while !String::from_utf8_lossy(&seen).contains("\u{1b}[J") {
        let mut some = [0; 4096];
        let count = looks.read(&mut some).expect("something is shown");
        seen.extend(&some[..count]);
    }
    let modes = tcgetattr(&own).expect("modes").local_modes;
    assert!(!modes.intersects(LocalModes::ECHO | LocalModes::ICANON), "{modes:?}");
    act(&mut looks, &process);
    process.ends(code);
    assert_eq!(tcgetattr(&own).expect("modes").local_modes, before, "the terminal is as it was");
    drop(own);
    let rest = thread::spawn(move || {
        let mut some = [0; 4096];
        // What is at the other end of a terminal that is closed is an error, not the end.
        while let Ok(count @ 1..) = looks.read(&mut some) {
            seen.extend(&some[..count]);
        }
        seen
    });
    String::from_utf8(rest.join().expect("all is read")).expect("a text")
}

#[test]
fn a_page_in_a_terminal_ends_with_q_and_is_gone_then() {
    let check = |code: i32, act: fn(&mut File, &Process)| {
        let shown = watched(code, act);
        assert!(shown.starts_with("\u{1b}[?1049h") && shown.trim_end().ends_with("\u{1b}[?1049l"), "{shown:?}");
        assert_eq!(shown.matches("\u{1b}[H").count(), 1, "what is typed changes nothing: {shown:?}");
    };
    check(0, |looks, _| looks.write_all(b"\n\nx q").expect("keys are taken"));
    check(130, |looks, _| looks.write_all(b"\x03").expect("keys are taken"));
    check(130, |_, process| process.signal(Signal::TERM));
}
