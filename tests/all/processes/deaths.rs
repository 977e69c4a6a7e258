//! Processes that are killed or stopped in the midst of a mission.

use std::thread;
use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::fixtures::{experiment_file, experiments};
use crate::home::{Home, Process, signal, within};

use super::{CONTROLLERS, came_out, report};

/// The dead-man's time, and a second for a busy machine.
const NOTICED: Duration = Duration::from_millis(2200);
/// Within which nothing may be left of a run that was killed.
const GONE: Duration = Duration::from_secs(2);

fn run(home: &Home) -> Process {
    let mission = experiment_file(1);
    let args = ["run", "--json", "--speed", "5", "--reattach-timeout", "1"].map(AsRef::as_ref);
    home.start(args.into_iter().chain([mission.as_os_str()]))
}

fn daemon(home: &Home, speed: &str) -> Process {
    home.daemon(&experiment_file(1), &["--json", "--speed", speed, "--reattach-timeout", "1"])
}

fn controllers(home: &Home) -> Vec<Process> {
    CONTROLLERS.iter().map(|name| home.controller(name, &[])).collect()
}

/// The controller of a daemon, which nobody starts again.
fn check_controller(name: &str, with: Signal, when: &str) {
    let home = Home::new();
    let controllers = controllers(&home);
    let mut daemon = daemon(&home, "5");
    daemon.says(when);
    let index = CONTROLLERS.iter().position(|other| *other == name).expect("a controller");
    controllers[index].signal(with);
    let told = Instant::now();
    daemon.says(&format!("{name} is unavailable"));
    assert!(told.elapsed() < NOTICED, "{:?}", told.elapsed());
    let finished = daemon.ends(4);
    let said = format!("× the controller {name} is gone");
    assert!(finished.stderr.contains(&said), "{}", finished.stderr);
    assert_eq!(report(&finished)["outcome"], "failed");
    let log = home.log();
    assert!(log.contains("controller_lost") && log.contains("\"lost\""), "the log tells it");
    controllers[index].signal(Signal::CONT);
}

#[test]
fn a_killed_controller_ends_the_mission_with_its_name() {
    check_controller("base", Signal::KILL, "step 1");
}

#[test]
fn a_stopped_controller_ends_the_mission_with_its_name() {
    thread::scope(|scope| {
        scope.spawn(|| check_controller("base", Signal::STOP, "step 1"));
        scope.spawn(|| check_controller("head", Signal::STOP, "step 2"));
    });
}

/// The other arm goes on.
#[test]
fn an_arm_that_is_killed_is_not_missed() {
    let home = Home::new();
    let controllers = controllers(&home);
    let mut daemon = home.daemon(&experiment_file(1), &["--json", "--speed", "20"]);
    daemon.says("step 1");
    controllers[0].signal(Signal::KILL);
    let finished = daemon.ends(0);
    assert_eq!(report(&finished)["outcome"], "done");
    let log = home.log();
    assert!(log.contains("\"unavailable\"") && !log.contains("\"available\""), "it did not come back");
    let path = home.write("run.jsonl", &log);
    let verified = home.start(["verify".as_ref(), path.as_os_str()]).ends(0);
    assert!(verified.stdout.starts_with("same: "), "{}", verified.stdout);
}

/// A run starts its own again, with what they held.
#[test]
fn a_run_starts_its_controllers_again() {
    let home = Home::new();
    let mut run = run(&home);
    run.says("done pick 2");
    signal(home.process("controller left_arm"), Signal::KILL);
    run.says("the process of left_arm has ended and is started again");
    let finished = run.ends(0);
    assert_eq!(report(&finished)["outcome"], "done");
    assert!(home.log().contains("\"service\":\"available\""), "the log tells it");
    home.is_empty();
}

/// A controller of a daemon that dies and is started again serves the mission that goes on.
#[test]
fn a_controller_that_comes_back_is_used_again() {
    let home = Home::new();
    let mut controllers = controllers(&home);
    let mut daemon = home.daemon(&experiment_file(1), &["--json", "--speed", "10"]);
    daemon.says("step 1");
    controllers[3].signal(Signal::KILL);
    daemon.says("base is unavailable");
    controllers[3] = home.controller("base", &[]);
    let finished = daemon.ends(0);
    assert_eq!(report(&finished)["outcome"], "done");
    let log = home.log();
    assert!(log.contains("\"service\":\"available\""), "the log tells it");
}

#[test]
fn nothing_is_left_of_a_killed_run() {
    let home = Home::new();
    let mut run = run(&home);
    run.says("step 1");
    assert_eq!(home.processes().len(), 5);
    run.signal(Signal::KILL);
    assert_eq!(run.wait().code, None);
    within(GONE, "no process is left", || home.processes().is_empty());
    // The next start of any instance sweeps what was left.
    let other = Home::new();
    let args = ["--attach-timeout", "0"];
    other.daemon(&experiment_file(1), &args).ends(4);
    home.is_empty();
    other.is_empty();
}

#[test]
fn controllers_outlive_a_killed_daemon() {
    let home = Home::new();
    let mut controllers = controllers(&home);
    for when in ["step 1", "step 2"] {
        let mut killed = daemon(&home, "5");
        killed.says(when);
        killed.signal(Signal::KILL);
        assert_eq!(killed.wait().code, None);
    }
    came_out(&daemon(&home, "100").ends(0), &experiments()[&1]);
    assert!(controllers.iter_mut().all(|controller| !controller.has_ended()));
    for controller in controllers {
        controller.signal(Signal::TERM);
        controller.ends(0);
    }
    home.is_empty();
}

#[test]
fn a_stopped_controller_serves_again_when_it_goes_on() {
    let home = Home::new();
    let controllers = controllers(&home);
    let mut first = daemon(&home, "2");
    first.says("step 1");
    controllers[3].signal(Signal::STOP);
    let finished = first.ends(4);
    assert!(finished.stderr.contains("× the controller base is gone"), "{}", finished.stderr);
    controllers[3].signal(Signal::CONT);
    came_out(&daemon(&home, "100").ends(0), &experiments()[&1]);
}

#[test]
fn a_stopped_daemon_goes_on_when_it_does() {
    let home = Home::new();
    let _controllers = controllers(&home);
    let mut stopped = daemon(&home, "2");
    stopped.says("step 1");
    stopped.signal(Signal::STOP);
    thread::sleep(Duration::from_millis(1500));
    stopped.signal(Signal::CONT);
    // Its controllers have stopped the robot and given it up, and then serve it again.
    let finished = stopped.ends(0);
    assert_eq!(report(&finished)["outcome"], "done");
    assert!(home.log().contains("\"left\""), "the log tells it");
    came_out(&daemon(&home, "100").ends(0), &experiments()[&1]);
}
