//! A daemon and its controllers, each started by hand.

use rustix::process::Signal;

use crate::fixtures::{experiment_file, experiments};
use crate::home::{Home, Process};

use super::{CONTROLLERS, came_out};

const FAST: [&str; 3] = ["--json", "--speed", "100"];

fn daemon(home: &Home, number: u32) -> Process {
    home.daemon(&experiment_file(number), &FAST)
}

fn stop(home: &Home, controllers: Vec<Process>) {
    for controller in &controllers {
        controller.signal(Signal::TERM);
    }
    for controller in controllers {
        controller.ends(0);
    }
    home.is_empty();
}

/// Controllers in this order, the daemon once so many of them are there.
fn check(order: [usize; 4], before: usize) {
    let home = Home::new();
    let start = |index: &usize| home.controller(CONTROLLERS[*index], &[]);
    let mut controllers: Vec<_> = order[..before].iter().map(start).collect();
    let mut daemon = daemon(&home, 1);
    daemon.says("waiting for left_arm, right_arm, head, base");
    controllers.extend(order[before..].iter().map(start));
    came_out(&daemon.ends(0), &experiments()[&1]);
    stop(&home, controllers);
}

#[test]
fn controllers_before_the_daemon() {
    check([0, 1, 2, 3], 4);
}

#[test]
fn controllers_after_the_daemon() {
    check([3, 2, 1, 0], 0);
}

#[test]
fn controllers_around_the_daemon() {
    check([2, 0, 3, 1], 2);
}

#[test]
fn the_mission_waits_for_a_late_one() {
    let home = Home::new();
    let mut controllers: Vec<_> = CONTROLLERS[1..].iter().map(|name| home.controller(name, &[])).collect();
    let mut daemon = daemon(&home, 1);
    for name in &CONTROLLERS[1..] {
        daemon.says(&format!("attached {name}"));
    }
    assert!(!daemon.stderr().contains("step 1"), "it must not begin");
    controllers.push(home.controller(CONTROLLERS[0], &[]));
    came_out(&daemon.ends(0), &experiments()[&1]);
    stop(&home, controllers);
}

#[test]
fn controllers_stay_for_the_next_daemon() {
    let home = Home::new();
    let mut controllers: Vec<_> = CONTROLLERS.iter().map(|name| home.controller(name, &[])).collect();
    for (number, expected) in experiments() {
        came_out(&daemon(&home, number).ends(0), &expected);
        assert!(controllers.iter_mut().all(|controller| !controller.has_ended()));
    }
    stop(&home, controllers);
}

#[test]
fn told_to_serve_once_they_end_with_the_daemon() {
    let home = Home::new();
    let controllers: Vec<_> = CONTROLLERS.iter().map(|name| home.controller(name, &["--once"])).collect();
    came_out(&daemon(&home, 3).ends(0), &experiments()[&3]);
    for controller in controllers {
        controller.ends(0);
    }
    home.is_empty();
}

#[test]
fn a_place_is_taken_once() {
    let home = Home::new();
    let mut first = daemon(&home, 1);
    let head = home.controller("head", &[]);
    first.says("attached head");
    let refused = home.controller("head", &[]).ends(2).words();
    let said = format!("runs already (pid {})", head.pid());
    assert!(refused.contains("a controller `head` of instance") && refused.contains(&said), "{refused}");
    let second = daemon(&home, 2).ends(2);
    let said = format!("runs already (pid {})", first.pid());
    let refused = second.words();
    assert!(refused.contains("a daemon of instance") && refused.contains(&said), "{refused}");
    assert_eq!(second.stdout, "");
    // Neither refusal harmed those who have the places.
    let others = ["left_arm", "right_arm", "base"];
    let mut controllers: Vec<_> = others.iter().map(|name| home.controller(name, &[])).collect();
    came_out(&first.ends(0), &experiments()[&1]);
    controllers.push(head);
    stop(&home, controllers);
}
