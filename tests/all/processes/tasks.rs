//! Tasks that come and go, given to a running robot by processes of their own.

use std::fs;
use std::path::Path;
use std::time::Duration;

use rustix::process::Signal;
use serde_json::Value;

use super::CONTROLLERS;
use crate::fixtures::file;
use crate::home::{Finished, Home, Process, within};

/// What takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(40);

/// A robot in a kitchen, with nothing to do yet.
struct Robot {
    home: Home,
    daemon: Process,
    controllers: Vec<Process>,
}

impl Robot {
    fn new(more: &[&str]) -> Self {
        Self::of(Home::new(), &file("config/worlds/kitchen.yaml"), more)
    }

    /// In a room of its own.
    fn of(home: Home, world: &Path, more: &[&str]) -> Self {
        let mut robot = Self::alone(home, world, more);
        robot.attach();
        robot
    }

    /// Without its controllers.
    fn alone(home: Home, world: &Path, more: &[&str]) -> Self {
        let daemon = Self::daemon(&home, world, more);
        Self { home, daemon, controllers: Vec::new() }
    }

    fn attach(&mut self) {
        self.controllers = CONTROLLERS.iter().map(|name| self.home.controller(name, &[])).collect();
        self.attached();
    }

    /// Its runtime is killed, and another goes on in its log.
    fn killed(self, more: &[&str]) -> Self {
        self.daemon.signal(Signal::KILL);
        let Self { home, daemon, controllers } = self;
        assert_eq!(daemon.wait().code, None);
        let args = ["daemon", "--resume", home.instance(), "--instance", home.instance(), "--speed", "20"];
        let daemon = home.start(args.iter().chain(more));
        let mut robot = Self { home, daemon, controllers };
        robot.attached();
        robot
    }

    fn daemon(home: &Home, world: &Path, more: &[&str]) -> Process {
        let robot = file("config/robots/pr2.yaml");
        let (robot, world) = (robot.to_str().expect("UTF-8"), world.to_str().expect("UTF-8"));
        let args = ["daemon", "--robot", robot, "--world", world, "--instance", home.instance(), "--speed", "20"];
        home.start(args.iter().chain(more))
    }

    fn attached(&mut self) {
        CONTROLLERS.iter().for_each(|name| self.daemon.says(&format!("attached {name}")));
    }

    fn start(&self, args: &[&str]) -> Process {
        self.home.start(args.iter().chain(&["--instance", self.home.instance()]))
    }

    fn ask(&self, args: &[&str], code: i32) -> Finished {
        self.start(args).ends(code)
    }

    /// Submits a fetch, and gives its number.
    fn fetch(&self, object: &str, to: &str, more: &[&str]) -> u32 {
        let settings = [format!("object={object}"), format!("to={to}")];
        let args = ["submit", "fetch", "--json", "--set", &settings[0], "--set", &settings[1]];
        let said = self.ask(&[&args, more].concat(), 0).stdout;
        let said: Value = serde_json::from_str(&said).expect("an object");
        said["task"].as_u64().and_then(|task| u32::try_from(task).ok()).expect("a number")
    }

    /// What each task is.
    fn states(&self) -> Vec<String> {
        let listed = self.ask(&["list", "--json"], 0).stdout;
        let listed: Value = serde_json::from_str(&listed).expect("JSON");
        let tasks = listed["tasks"].as_array().expect("tasks").iter();
        tasks.map(|task| task["state"].as_str().expect("a word").to_owned()).collect()
    }

    /// What the terminal says is on its way to who lists tasks.
    fn are(&self, wanted: &[&str]) {
        within(PATIENCE, "tasks are as wanted", || self.states() == wanted);
    }

    /// Ends it, and has every log of it computed again and looked at.
    fn end(self) {
        self.ask(&["stop"], 0);
        self.daemon.ends(130);
        Self::look_at_logs(&self.home);
    }

    fn look_at_logs(home: &Home) {
        let folder = home.path("ambidex").join(home.instance());
        for entry in fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            let log = path.to_str().expect("UTF-8");
            home.start(["verify", log]).ends(0);
            home.start(["audit", log]).ends(0);
        }
    }
}

#[test]
fn two_terminals_share_a_step() {
    let robot = Robot::new(&[]);
    robot.ask(&["pause"], 0);
    let [spoon, fork] = ["spoon", "fork"].map(|object| {
        robot.start(&["submit", "fetch", "--wait", "--name", object, "--set", &format!("object={object}")])
    });
    robot.are(&["paused", "paused"]);
    robot.ask(&["resume"], 0);
    for finished in [spoon.ends(0), fork.ends(0)] {
        assert!(finished.stderr.contains("done, 4 of 4 done"), "{finished:#?}");
    }
    let said = robot.daemon.stderr();
    let drives = said.lines().filter(|line| line.contains(": go for ") && line.contains(" (base)")).count();
    assert!(drives == 1 && said.contains("skipped go for "), "{said}");
    robot.end();
}

#[test]
fn a_task_is_canceled_in_the_middle_of_a_pick_and_the_others_go_on() {
    let mut robot = Robot::new(&[]);
    let canceled = robot.start(&["submit", "fetch", "--wait", "--set", "object=mug"]);
    robot.daemon.says("pick mug");
    canceled.signal(Signal::INT);
    canceled.ends(130);
    robot.fetch("cup", "desk", &["--name", "other"]);
    robot.daemon.says("task other is over: done");
    robot.are(&["canceled", "done"]);
    robot.end();
}

#[test]
fn a_task_stalls_beside_one_that_goes_on() {
    let mut robot = Robot::new(&[]);
    // Who brings what it is to put down is paused.
    robot.fetch("plate", "desk", &["--pause"]);
    let text = "mission: place\ntask: {then: [{move: table}, {place: {object: plate, at: table}}]}\n";
    let place = robot.home.write("place.yaml", text);
    let text = "mission: rounds\ntask: {use: {patrol: {first: desk, second: rack}}, repeat: 2}\n";
    let patrol = robot.home.write("rounds.yaml", text);
    robot.ask(&["submit", place.to_str().expect("UTF-8"), "--name", "plate"], 0);
    robot.daemon.says("nothing of plate can go on: ");
    let listed = robot.ask(&["list"], 0).stdout;
    assert!(listed.lines().any(|line| line.contains("stalled") && line.contains("place plate: ")), "{listed}");
    robot.ask(&["submit", patrol.to_str().expect("UTF-8"), "--name", "rounds"], 0);
    robot.daemon.says("task rounds is over: done");
    robot.are(&["paused", "stalled", "done"]);
    robot.end();
}

#[test]
fn what_comes_to_stand_in_the_way_is_told_and_goes_again() {
    let mut robot = Robot::new(&[]);
    let told = robot.ask(&["world", "block", "2,4", "0.4,0.4"], 0);
    assert!(told.stdout.contains("something stands at (2.00, 4.00) now"), "{told:#?}");
    let again = robot.ask(&["world", "block", "2,4", "0.4,0.4"], 0);
    assert!(again.stdout.contains("something stands at (2.00, 4.00) already"), "{again:#?}");
    robot.fetch("mug", "desk", &["--name", "mug"]);
    robot.daemon.says("nothing of mug can go on: go for mug: no free path leads to cupboard");
    robot.ask(&["world", "unblock", "2.1,4.1"], 0);
    robot.daemon.says("task mug is over: done");
    for (wrong, words) in [
        (["block", "2", "0.4,0.4"], "two numbers such as 1.5,-2"),
        (["block", "2,4", "0,0.4"], "the size, 0 m, is not from 0.01 to 100 m"),
        (["block", "-2e4,4", "1,1"], "the position, -20000 m, is not from -10000 to 10000 m"),
    ] {
        let refused = robot.ask(&[&["world"], &wrong[..]].concat(), 2);
        assert!(refused.words().contains(words), "{refused:#?}");
    }
    robot.end();
}

/// A corridor with a small shelf at its end and a table that can be reached over from two sides.
const CORRIDOR: &str = "mission: corridor
world:
  robot: {at: [0, 0]}
  places:
    table: {table: {at: [3, 0], size: [0.6, 1.6, 0.75], stands: {near: {side: front}, far: {side: back}}}}
    shelf: {table: {at: [0, 2], heading: 90 deg, size: [0.2, 0.2, 0.75]}}
    end: {stand: [-6, 0]}
  objects: {cup: {at: table}, plate: {at: table, offset: [0, 0.3]}, pot: {at: shelf, offset: [0, 0]}}
  walls: [{from: [-1, -1], to: [-7, -1]}, {from: [-1, 1], to: [-7, 1]}, {from: [-7, -1], to: [-7, 1]}]
";

#[test]
fn a_room_that_changes_is_noticed_by_all_that_it_concerns() {
    let home = Home::new();
    let world = home.write("corridor.yaml", CORRIDOR);
    let mut robot = Robot::of(home, &world, &[]);
    let task = |robot: &Robot, name: &str, task: &str| {
        let path = robot.home.write(&format!("{name}.yaml"), &format!("mission: {name}\ntask: {task}\n"));
        robot.ask(&["submit", path.to_str().expect("UTF-8"), "--name", name, "--pause"], 0);
    };
    // A drive reads what stands behind it, which may go before it does.
    task(&robot, "both", "{then: [{move: table}, {pick: cup}, {pick: plate}]}");
    robot.ask(&["edit", "both", "remove", "pick plate"], 0);
    robot.ask(&["cancel", "both"], 0);
    robot.daemon.says("task both is over: canceled");
    robot.ask(&["world", "move", "plate", "table"], 0);
    robot.ask(&["world", "move", "plate", "shelf"], 0);
    robot.ask(&["world", "move", "plate", "table"], 0);
    // What came to stand in the room gives nothing up for good, whoever comes then.
    robot.ask(&["world", "block", "-3,0", "0.4,1.8"], 0);
    task(&robot, "rounds", "{then: [{move: end}]}");
    task(&robot, "more", "{then: [{move: end}]}");
    robot.ask(&["resume", "rounds"], 0);
    robot.daemon.says("nothing of rounds can go on: move to end: no free path leads to end");
    robot.ask(&["world", "unblock", "-3,0"], 0);
    robot.daemon.says("task rounds is over: done");
    robot.ask(&["cancel", "more"], 0);
    // A spot that becomes free is used.
    task(&robot, "lay", "{then: [{move: table}, {pick: cup}, {move: shelf}, {place: cup}]}");
    robot.ask(&["resume", "lay"], 0);
    robot.daemon.says("nothing of lay can go on: place cup: every spot of shelf within reach is taken");
    robot.ask(&["world", "remove", "pot"], 0);
    robot.daemon.says("task lay is over: done");
    // Where it is put, it stays, however often that is said.
    let again = robot.ask(&["world", "move", "cup", "shelf"], 0);
    assert!(again.stdout.contains("cup is at shelf already"), "{again:#?}");
    robot.end();
}

#[test]
fn nothing_submitted_is_lost_when_the_runtime_is_killed() {
    let small = ["--log-size", "0.03"];
    let robot = Robot::new(&small);
    let (objects, places) = (["mug", "cup", "plate", "spoon", "fork"], ["desk", "table", "cupboard", "rack"]);
    let numbers: Vec<u32> = (0..20).map(|task| robot.fetch(objects[task % 5], places[task % 4], &[])).collect();
    assert!(numbers.is_sorted(), "{numbers:?}");
    let robot = robot.killed(&small);
    let is_over = |state: &String| state == "done" || state == "canceled" || state == "failed";
    within(PATIENCE, "all are over", || robot.states().iter().all(is_over));
    assert!(robot.states().iter().all(|state| state == "done"), "{:?}", robot.states());
    let said = robot.daemon.stderr();
    // What was over before the kill is told by the log alone.
    assert!(said.contains("goes on after its runtime was gone"), "{said}");
    robot.end();
}

#[test]
fn what_cannot_be_is_refused_with_what_can() {
    let robot = Robot::new(&[]);
    let bad = robot.home.write("bad.yaml", "mission: bad\ntask:\n  move: nowhere\n");
    let finished = robot.ask(&["submit", bad.to_str().expect("UTF-8")], 2);
    assert!(finished.stderr.contains("bad.yaml:3:9") && finished.stderr.contains("cupboard"), "{finished:#?}");
    let finished = robot.ask(&["submit", "fetsh"], 2);
    assert!(finished.stderr.contains("fetch"), "{finished:#?}");
    robot.ask(&["cancel", "7"], 2);
    robot.ask(&["world", "add", "apple", "desk"], 0);
    robot.ask(&["world", "add", "apple", "rack"], 1);
    robot.ask(&["world", "move", "apple", "rack"], 0);
    let task = robot.fetch("apple", "table", &["--pause"]);
    robot.ask(&["world", "remove", "apple"], 1);
    let task = task.to_string();
    let apple = robot.home.write("more.yaml", "mission: more\ntask: {move: rack}\n");
    robot.ask(&["edit", &task, "add", &task, apple.to_str().expect("UTF-8")], 0);
    robot.ask(&["edit", &task, "remove", &task], 1);
    robot.ask(&["edit", &task, "remove", "move to rack"], 0);
    robot.ask(&["step", &task], 0);
    robot.ask(&["cancel", &task], 0);
    robot.end();
}

#[test]
fn what_came_into_the_room_is_fetched_by_its_name() {
    let mut robot = Robot::new(&[]);
    robot.ask(&["world", "add", "apple", "desk"], 0);
    robot.fetch("apple", "table", &["--wait"]);
    robot.ask(&["world", "add", "pear", "desk"], 0);
    robot.ask(&["world", "add", "plum", "rack"], 0);
    robot.fetch("pear", "rack", &["--name", "pear"]);
    robot.daemon.says("bring pear (base)");
    // By another runtime, too, whether it lies somewhere or is in a hand.
    let mut robot = robot.killed(&[]);
    robot.daemon.says("task pear is over: done");
    robot.fetch("plum", "desk", &["--wait"]);
    // What is gone is not told of any more.
    robot.ask(&["world", "remove", "plum"], 0);
    let status = robot.ask(&["status"], 0).stdout;
    assert!(status.contains("pear") && !status.contains("plum"), "{status}");
    let said = robot.daemon.stderr();
    assert!(!said.contains("refused") && !said.contains("rejected") && !said.contains("is empty now"), "{said}");
    robot.end();
}

/// Nobody needs to wait for the robot before it says what is to be done.
#[test]
fn work_may_come_before_the_controllers() {
    let mut robot = Robot::alone(Home::new(), &file("config/worlds/kitchen.yaml"), &[]);
    robot.daemon.says("waiting for left_arm, right_arm, head, base");
    robot.ask(&["world", "add", "apple", "desk"], 0);
    robot.fetch("apple", "table", &["--name", "apple"]);
    robot.fetch("mug", "desk", &["--name", "mug", "--pause"]);
    robot.ask(&["pause"], 0);
    robot.ask(&["resume"], 0);
    robot.ask(&["resume", "mug"], 0);
    robot.fetch("cup", "desk", &["--name", "cup"]);
    robot.ask(&["cancel", "cup"], 0);
    robot.are(&["waiting", "waiting", "ending"]);
    let log = fs::metadata(robot.home.path("ambidex").join(robot.home.instance()).join("journal.jsonl"));
    assert!(log.expect("a log").len() < 100_000, "it waits, and does nothing else");
    // Neither does one that goes on without its controllers.
    robot.daemon.signal(Signal::KILL);
    let Robot { home, daemon, controllers } = robot;
    assert_eq!(daemon.wait().code, None);
    let args = ["daemon", "--resume", home.instance(), "--instance", home.instance(), "--speed", "20"];
    let mut robot = Robot { daemon: home.start(args), home, controllers };
    robot.daemon.says("waiting for left_arm, right_arm, head, base");
    robot.attach();
    robot.daemon.says("task apple is over: done");
    robot.are(&["done", "done", "canceled"]);
    robot.end();
}
