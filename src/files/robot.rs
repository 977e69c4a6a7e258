//! A robot file as read, to a robot that can be attached: every controller known, used once, and of the fitting kind.

use std::collections::BTreeMap;

use super::fault::Faults;
use super::names::Register;
use super::raw::{Resource, Robot};
use super::reader::{Item, Name};
use super::schema::Format;
use ambidex_model::{ControllerId, ControllerKind, ControllerSpec, Names, ResourceSpec, RobotSpec, TypeId};

/// The types that the behaviors of the paper know.
const GRIPPER: &str = "gripper";
const HEAD: &str = "head";
const BASE: &str = "base";

/// Most resources of a robot.
const MAX_RESOURCES: usize = 1000;
/// Longest name of a controller, bytes: it names shared memory and a log file.
const MAX_CONTROLLER_NAME_BYTES: usize = 32;

/// A robot and what its parts are called.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotFile {
    /// The robot.
    pub robot: RobotSpec,
    /// Names of resources, types and controllers; the other lists are empty.
    pub names: Names,
}

/// Reads and checks a robot file; `None` when it has faults.
pub(super) fn read(file: Item<'_>, faults: &mut Faults) -> Option<RobotFile> {
    if !Format::Robot.is_that_of(file, faults) {
        return None;
    }
    let before = faults.errors();
    let raw = Robot::read(file, faults)?;
    build(raw, faults).filter(|_| faults.errors() == before)
}

fn build(raw: Robot, faults: &mut Faults) -> Option<RobotFile> {
    let controllers = Register::of("controller", raw.controllers.iter().map(|(name, _)| name.value.as_str()));
    let mut types = Register::new("type of resource");
    let mut users = BTreeMap::new();
    let mut resources = Vec::new();
    for (name, resource) in &raw.resources {
        let Some(resource) = resource else { continue };
        let ty = TypeId::from(types.intern(&resource.ty.value));
        let controller = controller_of(name, resource, &controllers, &mut users, faults);
        if let Some(controller) = controller {
            check_kind(resource, &raw.controllers[controller.index()].1, faults);
        }
        resources.push(ResourceSpec { ty, controller });
    }
    check_limits(&raw, &users, faults);
    check_mixed(&raw, faults);

    let mut specs = Vec::new();
    for (name, kind) in &raw.controllers {
        specs.extend(kind.map(|kind| ControllerSpec { name: name.value.clone(), kind }));
    }
    let (name, radius_m) = (raw.robot?.value, raw.radius_m?);
    Some(RobotFile {
        robot: RobotSpec { name, resources, controllers: specs, radius_m },
        names: Names {
            resources: raw.resources.into_iter().map(|(name, _)| name.value).collect(),
            types: types.into_names(),
            controllers: controllers.into_names(),
            ..Names::default()
        },
    })
}

fn controller_of(
    name: &Name,
    resource: &Resource,
    controllers: &Register,
    users: &mut BTreeMap<ControllerId, String>,
    faults: &mut Faults,
) -> Option<ControllerId> {
    let wanted = resource.controller.as_ref()?;
    let found = ControllerId::from(controllers.find(wanted, faults)?);
    if let Some(other) = users.insert(found, name.value.clone()) {
        let message = format!("controller `{}` moves `{other}` already", wanted.value);
        faults.push(wanted.spot, "controller", message, None);
    }
    Some(found)
}

/// The types that the kinds of behavior know are moved by what can do their commands.
fn check_kind(resource: &Resource, kind: &Option<ControllerKind>, faults: &mut Faults) {
    let (Some(kind), Some(name)) = (kind, &resource.controller) else {
        return;
    };
    let (word, ty) = match kind {
        ControllerKind::Arm(_) => ("an arm", GRIPPER),
        ControllerKind::Base(_) => ("a base", BASE),
        ControllerKind::Head(_) => ("a head", HEAD),
    };
    let found = resource.ty.value.as_str();
    if [GRIPPER, BASE, HEAD].contains(&found) && found != ty {
        let message = format!("controller `{}` moves {word}, not a {found}", name.value);
        faults.push(name.spot, "controller", message, None);
    }
}

fn check_limits(raw: &Robot, users: &BTreeMap<ControllerId, String>, faults: &mut Faults) {
    if raw.resources.len() > MAX_RESOURCES
        && let Some((name, _)) = raw.resources.get(MAX_RESOURCES)
    {
        let message = format!("more than {MAX_RESOURCES} resources");
        faults.push(name.spot, "resources", message, None);
    }
    for (index, (name, _)) in raw.controllers.iter().enumerate() {
        let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-".contains(letter);
        if name.value.len() > MAX_CONTROLLER_NAME_BYTES || !name.value.chars().all(is_plain) {
            let message = format!(
                "the name of a controller has at most {MAX_CONTROLLER_NAME_BYTES} letters, digits, `_` and `-`"
            );
            faults.push(name.spot, &name.value, message, None);
        }
        if !users.contains_key(&ControllerId::from(index)) {
            let message = "no resource has this controller".to_owned();
            let help = "name it as the `controller` of what it moves, or leave it out".to_owned();
            faults.push(name.spot, &name.value, message, Some(help));
        }
    }
}

/// "Any of a type" is commanded or not as a whole.
fn check_mixed(raw: &Robot, faults: &mut Faults) {
    let mut driven = BTreeMap::new();
    for (name, resource) in &raw.resources {
        let Some(resource) = resource else { continue };
        let has_one = resource.controller.is_some();
        if *driven.entry(&resource.ty.value).or_insert(has_one) != has_one {
            let message = format!("of type `{}`, some have a controller and some have none", resource.ty.value);
            faults.push(name.spot, &name.value, message, None);
        }
    }
}
