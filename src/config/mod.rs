//! Files to checked specs: every fault with file, line and key, all at once. No tree is built here and nothing runs.

mod document;
mod fault;
mod kinds;
mod labels;
mod names;
mod quantity;
mod raw;
mod reader;
mod robot;
mod siblings;
mod task;
#[cfg(test)]
mod tests;
mod world;

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

pub use fault::{ConfigError, Fault};
pub use robot::RobotFile;

use crate::model::{MissionSpec, Names};
use document::{MAX_BYTES, Node};
use fault::Faults;
use reader::Item;
use world::WorldNames;

/// A mission with the file of its robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The mission.
    pub mission: MissionSpec,
    /// Where its robot stands, for the controllers to read it too.
    pub robot_path: PathBuf,
}

/// Loads a mission and the robot that it names, or `robot_override` instead.
///
/// # Errors
/// Every mistake in both files.
pub fn load_mission(path: &Path, robot_override: Option<&Path>) -> Result<Loaded, ConfigError> {
    let (mut faults, node) = read(path);
    let raw = node.and_then(|node| raw::Mission::read(Item::root(&node), &mut faults));
    let robot_path = robot_override.map(Path::to_owned).or_else(|| {
        let name = raw.as_ref()?.robot.as_ref()?;
        Some(beside(path, &name.value))
    });
    let (robot_faults, robot) = match &robot_path {
        Some(path) => read_robot(path),
        None => (Faults::new(path, String::new()), None),
    };
    let mission = raw.and_then(|raw| build(raw, robot, &mut faults));
    let loaded = mission.zip(robot_path).map(|(mission, robot_path)| Loaded { mission, robot_path });
    finish(loaded, [faults, robot_faults])
}

/// Loads a robot alone, as a controller process does.
///
/// # Errors
/// Every mistake in the file.
pub fn load_robot(path: &Path) -> Result<RobotFile, ConfigError> {
    let (faults, robot) = read_robot(path);
    finish(robot, [faults])
}

/// Where a path in a file leads.
fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}

fn read_robot(path: &Path) -> (Faults, Option<RobotFile>) {
    let (mut faults, node) = read(path);
    let raw = node.and_then(|node| raw::Robot::read(Item::root(&node), &mut faults));
    let robot = raw.and_then(|raw| robot::build(raw, &mut faults));
    (faults, robot)
}

fn read(path: &Path) -> (Faults, Option<Node>) {
    match text(path) {
        Ok(text) => {
            let parsed = document::parse(&text);
            let mut faults = Faults::new(path, text);
            match parsed {
                Ok(node) => (faults, Some(node)),
                Err(fault) => {
                    faults.push(fault.spot, "", fault.message, None);
                    (faults, None)
                }
            }
        }
        Err(error) => {
            let mut faults = Faults::new(path, String::new());
            faults.push_whole(format!("cannot read {}: {error}", path.display()));
            (faults, None)
        }
    }
}

fn text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(MAX_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_BYTES {
        let message = format!("it is larger than {MAX_BYTES} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    Ok(text)
}

fn build(raw: raw::Mission, robot: Option<RobotFile>, faults: &mut Faults) -> Option<MissionSpec> {
    let (raw_world, raw_task) = (raw.world?, raw.task);
    let world_names = WorldNames::of(&raw_world);
    let world = world::build(raw_world, &world_names, faults);
    let around = task::Surroundings { robot: robot.as_ref(), world: world.as_ref(), names: &world_names };
    let (tree, nodes) = task::build(raw_task?, &around, faults)?;
    let (world, robot) = (world?, robot?);
    let places = world_names.places.into_names();
    Some(MissionSpec {
        name: raw.mission?.value,
        robot: robot.robot,
        world: world.spec,
        start: world.start,
        tree,
        names: Names {
            nodes,
            channels: places.iter().map(|place| format!("at {place}")).collect(),
            places,
            objects: world_names.objects.into_names(),
            facts: world_names.facts.into_names(),
            ..robot.names
        },
    })
}

/// What was built, if no file has a fault.
fn finish<T>(built: Option<T>, files: impl IntoIterator<Item = Faults>) -> Result<T, ConfigError> {
    match (Faults::into_error(files), built) {
        (Some(error), _) => Err(error),
        (None, Some(built)) => Ok(built),
        (None, None) => Err(ConfigError::unexplained()),
    }
}
