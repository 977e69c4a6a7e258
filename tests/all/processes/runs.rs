//! Missions with a process per controller come out like simulated ones, and leave nothing behind.

use std::path::Path;

use crate::fixtures::{Expected, experiment_file, experiments, rooms};
use crate::home::{Finished, Home};

use super::{came_out, report};

const REPEAT: &str = "AMBIDEX_TEST_REPEAT";
/// Rooms that are tried with processes too.
const ROOMS: [u32; 4] = [1, 14, 27, 40];

fn run(home: &Home, mission: &Path) -> Finished {
    let args = ["run", "--json", "--quiet", "--speed", "100"].map(AsRef::as_ref);
    let finished = home.start(args.into_iter().chain([mission.as_os_str()])).ends(0);
    assert_eq!(finished.stderr, "", "quiet, and nothing went wrong");
    home.is_empty();
    finished
}

/// Rounds, messages and times differ, since what ends at one moment there ends at two here.
fn check(mission: &Path, expected: &Expected, times: u32) {
    let home = Home::new();
    let args = ["simulate", "--json", "--quiet"].map(AsRef::as_ref);
    let simulated = home.start(args.into_iter().chain([mission.as_os_str()])).ends(0);
    came_out(&simulated, expected);
    for _ in 0..times {
        let finished = run(&home, mission);
        came_out(&finished, expected);
        for key in ["mission", "outcome", "steps", "skipped"] {
            assert_eq!(report(&finished)[key], report(&simulated)[key]);
        }
    }
}

fn check_experiment(number: u32) {
    let times = std::env::var(REPEAT).ok().map_or(3, |times| times.parse().expect("a number"));
    check(&experiment_file(number), &experiments()[&number], times);
}

#[test]
fn experiment_1_comes_out_as_in_the_paper() {
    check_experiment(1);
}

#[test]
fn experiment_2_comes_out_as_in_the_paper() {
    check_experiment(2);
}

#[test]
fn experiment_3_comes_out_as_in_the_paper() {
    check_experiment(3);
}

#[test]
fn experiment_4_comes_out_as_in_the_paper() {
    check_experiment(4);
}

#[test]
fn four_rooms_come_out_as_foretold() {
    let home = Home::new();
    let rooms = rooms();
    for number in ROOMS {
        let room = &rooms[&number];
        let mission = home.write(&format!("room-{number}.yaml"), &room.mission(number));
        check(&mission, &room.expected, 1);
    }
}

#[test]
fn two_runs_side_by_side_do_not_meet() {
    let home = Home::new();
    let start = |number| {
        let args = ["run", "--json", "--quiet", "--speed", "50"].map(AsRef::as_ref);
        let mission = experiment_file(number);
        home.start(args.into_iter().chain([mission.as_os_str()]))
    };
    let running = [1, 2].map(start);
    for (process, expected) in running.into_iter().zip(experiments().into_values()) {
        came_out(&process.ends(0), &expected);
    }
    assert_eq!(home.instances().len(), 3);
    home.is_empty();
}
