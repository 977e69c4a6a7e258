//! What the tests of files share: a mission and a robot without mistakes.

mod calls;
mod declared;
mod failures;
mod holding;
mod hostile;
mod keys;
mod lint;
mod live;
mod mistakes;
mod mutations;
mod parameters;
mod potentials;
mod reference;
mod reports;
mod shipped;
mod sources;

use super::{FilesError, InMemory, load_mission};
use ambidex_model::MissionSpec;

const PATH: &str = "mission.yaml";
const GOOD: &str = "\
mission: good
robot: robot.yaml
world:
  robot: {at: [0, 0], heading: 90 deg}
  places:
    shelf: {stand: [1 m, 200 cm]}
    table: {stand: [3, 2]}
  objects:
    cup: {at: shelf, offset: [0, 0.1]}
    pot: {at: shelf}
  facts: {door_open: true}
task:
  then:
    - move: shelf
    - pick: cup
    - move: {to: table, scale_by: gripper}
      timeout: 2 min
    - place: {object: cup}
      retries: 0
";
const ROBOT: &str = "\
robot: small
radius: 0.3 m
resources:
  hand: {type: gripper, controller: arm}
  base: {type: base}
controllers:
  arm:
    arm: {shoulder: [0, 0, 0.8], tuck: [0.3, 0, 0.9], reach: 0.9, speed: 0.5, acceleration: 1, grip: 1 s, lift: 10 cm}
";

fn load(mission: &str, robot: &str) -> Result<std::sync::Arc<MissionSpec>, FilesError> {
    load_mission(&written(mission, robot), PATH.as_ref(), None, &[]).map(|loaded| loaded.mission)
}

/// A mission at [`PATH`] and the robot beside it.
fn written(mission: impl Into<Vec<u8>>, robot: &str) -> InMemory {
    let mut files = InMemory::default();
    files.insert(PATH, mission);
    files.insert("robot.yaml", robot);
    files
}

/// The robot with so many hands.
fn robot(hands: usize) -> String {
    let hand = "  hand: {type: gripper, controller: arm}\n";
    let more: String = (1..hands).map(|n| format!("  hand{n}: {{type: gripper, controller: arm{n}}}\n")).collect();
    let arm = &ROBOT[ROBOT.find("  arm:\n").unwrap()..];
    let arms: String = (1..hands).map(|n| arm.replacen("  arm:", &format!("  arm{n}:"), 1)).collect();
    ROBOT.replace(hand, &format!("{hand}{more}")) + &arms
}
