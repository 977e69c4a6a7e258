//! Others tell a running mission what is different: an operator over the socket of its instance, and a sensor.

use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use ambidex::link::{Exit, Instance, ServeError, ServeOptions, Stop, Stopper, serve};
use ambidex::motion::Report;
use rustix::process::Signal;
use serde_json::Value;

use crate::fixtures::file;
use crate::home::{Finished, Home, Process, within};
use crate::sensor::Sensor;

const OPEN: &str = "door open";
const WAITS: &str = "nothing can go on before others change \"door open\"";

fn door() -> PathBuf {
    file("config/missions/door.yaml")
}

fn world(home: &Home, args: &[&str]) -> Process {
    home.start(["world"].iter().chain(args).chain(&["--instance", home.instance()]))
}

fn socket(home: &Home) -> PathBuf {
    Instance::new(home.instance()).expect("a name").control_socket()
}

fn controller(home: &Home, name: &str) -> Process {
    let robot = file("config/robots/porter.yaml");
    home.controller(name, &["--robot", robot.to_str().expect("a path in UTF-8")])
}

fn refused(finished: &Finished, words: &[&str]) {
    assert_eq!(finished.stdout, "", "{finished:#?}");
    for word in words {
        assert!(finished.words().contains(word), "{finished:#?}");
    }
}

#[test]
fn an_operator_opens_the_door() {
    let home = Home::new();
    // Slow enough that it still runs when the door has been opened and that was asked about.
    let mut run = home.carry("run", &door(), &["--speed", "5"]);
    run.says(WAITS);
    let about = std::fs::symlink_metadata(socket(&home)).expect("a socket");
    assert!(about.file_type().is_socket() && about.mode() & 0o777 == 0o600, "{:o}", about.mode());
    let folder = std::fs::metadata(socket(&home).parent().expect("a folder")).expect("it is there");
    assert_eq!(folder.mode() & 0o777, 0o700);
    refused(&world(&home, &["set", "dor open"]).ends(2), &["has no fact `dor open`", "did you mean `door open`?"]);
    refused(&world(&home, &["move", "parcl", "hall"]).ends(2), &["no object `parcl`", "did you mean `parcel`?"]);
    refused(&world(&home, &["move", "parcel", "hal"]).ends(2), &["no place `hal`", "did you mean `hall`?"]);
    refused(&world(&home, &["move", "parcel", "hall"]).ends(1), &["parcel is held by gripper"]);
    assert_eq!(world(&home, &["clear", OPEN]).ends(0).stdout, "\"door open\" does not hold already\n");
    let answer = world(&home, &["set", OPEN, "--json"]).ends(0).stdout;
    let answer: Value = serde_json::from_str(&answer).expect("an object");
    assert_eq!((&answer["result"], &answer["said"]), (&"changed".into(), &"\"door open\" holds now".into()));
    assert_eq!(world(&home, &["set", OPEN]).ends(0).stdout, "\"door open\" holds already\n");
    let status = home.status(&[]).ends(0).stdout;
    assert!(status.contains("door open holds, set by an operator"), "{status}");
    run.says("\"door open\" holds now: set by an operator");
    run.ends(0);
    let told = |verb: &str| home.start([verb, home.instance()]).ends(0).stdout;
    let held = "an operator says that parcel is at hall now, which is refused: parcel is held by gripper";
    for (verb, words) in [
        ("explain", "From outside: \"door open\" holds now: set by an operator"),
        ("trace", "\"door open\" holds now: set by an operator"),
        ("trace", held),
        ("timeline", "\"door open\" holds now: set by an operator"),
        ("verify", "same: "),
    ] {
        let said = crate::home::flat(&told(verb));
        assert!(said.contains(words), "{verb}: {said}");
    }
    let story = home.start(["explain", home.instance(), "pass to office"]).ends(0).stdout;
    let story = crate::home::flat(&story);
    assert!(story.contains("From outside: \"door open\" holds now: set by an operator."), "{story}");
    refused(&world(&home, &["set", OPEN]).ends(4), &["no daemon of instance", "runs"]);
    home.is_empty();
}

#[test]
fn a_fact_that_is_not_declared_outside_is_refused_with_what_to_do() {
    let home = Home::new();
    let text = std::fs::read_to_string(door()).expect("a mission");
    let robot = file("config/robots/porter.yaml");
    let text = text.replace("../robots/porter.yaml", robot.to_str().expect("a path"));
    let text = text.replace("    door open:", "    dusty: true\n    door open:");
    let mut run = home.carry("run", &home.write("dusty.yaml", &text), &["--speed", "20"]);
    run.says(WAITS);
    let said = world(&home, &["clear", "dusty"]).ends(1);
    refused(&said, &["\"dusty\" is not declared `outside`", "facts: {dusty: {holds: true, outside: true}}"]);
    run.signal(Signal::INT);
    run.ends(130);
    home.is_empty();
}

#[test]
fn a_killed_daemon_does_not_hinder_the_next() {
    let home = Home::new();
    refused(&world(&home, &["set", OPEN]).ends(4), &["no daemon of instance"]);
    let mut first = home.daemon(&door(), &[]);
    first.says("waiting for base, arm, door");
    refused(&world(&home, &["set", OPEN]).ends(1), &["the mission has not begun yet"]);
    // A controller that lives on keeps the folder, and so the socket of the dead.
    let mut base = controller(&home, "base");
    first.says("attached base");
    home.daemon(&door(), &[]).ends(2);
    refused(&world(&home, &["set", OPEN]).ends(1), &["the mission has not begun yet"]);
    first.signal(Signal::KILL);
    first.wait();
    assert!(socket(&home).exists());
    refused(&world(&home, &["set", OPEN]).ends(4), &["no daemon of instance"]);
    let mut next = home.daemon(&door(), &[]);
    next.says("attached base");
    refused(&world(&home, &["set", OPEN]).ends(1), &["the mission has not begun yet"]);
    next.signal(Signal::INT);
    next.ends(130);
    assert!(!socket(&home).exists(), "it goes with its daemon");
    assert!(!base.has_ended());
    base.signal(Signal::TERM);
    base.ends(0);
    home.is_empty();
}

#[test]
fn what_was_set_survives_the_kill_of_the_runtime() {
    let home = Home::new();
    let log = home.path("door.jsonl");
    let log = log.to_str().expect("a path in UTF-8");
    let mut run = home.carry("run", &door(), &["--speed", "5", "--log", log]);
    run.says(WAITS);
    world(&home, &["set", OPEN]).ends(0);
    run.says("step 3");
    // What is said may be ahead of the log by what the disk takes.
    let is_written = || std::fs::read_to_string(log).is_ok_and(|text| text.contains("{\"record\":\"world\""));
    within(Duration::from_secs(10), "the log has it", is_written);
    run.signal(Signal::KILL);
    run.wait();
    let args = ["run", "--instance", home.instance(), "--speed", "20", "--resume", log];
    let finished = home.start(args).ends(0);
    assert!(!finished.stderr.contains(WAITS), "{}", finished.stderr);
    home.start(["verify", log]).ends(0);
    home.is_empty();
}

/// A sensor over shared memory, in a thread of this process: sees the door open or shut, and something that nobody asked
/// it for.
fn sensor(home: &Home, is_open: &Arc<AtomicBool>) -> (Stopper, JoinHandle<Result<Exit, ServeError>>) {
    let (stop, stopper) = Stop::by_hand().expect("a pair");
    let (instance, is_open) = (Instance::new(home.instance()).expect("a name"), Arc::clone(is_open));
    let sees = move || vec![Report::fact(OPEN, is_open.load(Ordering::Relaxed)), Report::fact("door shut", true)];
    let options = ServeOptions { stop: Some(stop), ..ServeOptions::default() };
    (stopper, thread::spawn(move || serve(&instance, "door", Sensor(sees), options)))
}

#[test]
fn a_sensor_opens_the_door_and_shuts_it() {
    let home = Home::new();
    let is_open = Arc::new(AtomicBool::new(false));
    let (stopper, serving) = sensor(&home, &is_open);
    let controllers = ["base", "arm"].map(|name| controller(&home, name));
    let mut daemon = home.daemon(&door(), &["--speed", "20"]);
    daemon
        .says("door reports that \"door shut\" holds, which is not heard: its robot file does not let it report that");
    daemon.says(WAITS);
    let fact = || {
        let status = home.status(&["--json"]).ends(0).stdout;
        let status: Value = serde_json::from_str(&status).expect("an object");
        status["world"]["facts"][0].clone()
    };
    assert_eq!(fact()["holds"], false);
    is_open.store(true, Ordering::Relaxed);
    daemon.says("\"door open\" holds now: reported by door");
    daemon.says("step 3");
    assert_eq!(fact()["how"], "reported by door");
    is_open.store(false, Ordering::Relaxed);
    daemon.says("\"door open\" holds no more: reported by door");
    daemon.ends(0);
    // The next daemon hears all of it anew.
    is_open.store(true, Ordering::Relaxed);
    let mut next = home.daemon(&door(), &["--speed", "20"]);
    next.says("\"door open\" holds now: reported by door");
    let finished = next.ends(0);
    assert!(!finished.stderr.contains(WAITS), "{}", finished.stderr);
    home.start(["verify", home.instance()]).ends(0);
    controllers.iter().for_each(|controller| controller.signal(Signal::TERM));
    controllers.into_iter().for_each(|controller| drop(controller.ends(0)));
    stopper.stop();
    assert_eq!(serving.join().expect("it does not panic").expect("it served"), Exit::Stopped);
    within(Duration::from_secs(5), "nothing is left", || home.processes().is_empty());
    home.is_empty();
}
