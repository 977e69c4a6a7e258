//! A robot file: resources, the controller of each, and what a controller moves.

use nalgebra::Point3;

use super::super::fault::Faults;
use super::super::quantity::{ACCELERATION, EXTENT, GRIP, LIFT, NEAR, Quantity, SPEED, TURN_ACCELERATION, TURN_SPEED};
use super::super::reader::{Fields, Item};
use super::{Resource, Robot, each};
use crate::model::{ArmSpec, BaseSpec, ControllerKind, HeadSpec};

const KINDS: [&str; 3] = ["arm", "base", "head"];

impl Robot {
    /// Reads a robot file.
    pub(in super::super) fn read(file: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let keys = ["robot", "radius", "resources", "controllers"];
        let fields = file.fields("a robot", &keys, faults)?;
        let name = fields.required("robot", faults);
        let radius = fields.required("radius", faults);
        let resources = fields.required("resources", faults);
        let controllers = fields.optional("controllers");
        Some(Self {
            robot: name.and_then(|item| item.name("the name of the robot", faults)),
            radius_m: radius.and_then(|item| item.quantity(&EXTENT, faults)),
            resources: each(resources, "a map of resources", faults, Resource::read),
            controllers: each(controllers, "a map of controllers", faults, controller),
        })
    }
}

impl Resource {
    fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = item.fields("a resource", &["type", "controller"], faults)?;
        let controller = match fields.optional("controller") {
            Some(item) => item.name("a controller", faults).map(Some),
            None => Some(None),
        };
        let ty = fields.required("type", faults)?;
        Some(Self { ty: ty.name("a type", faults)?, controller: controller? })
    }
}

fn controller(item: Item<'_>, faults: &mut Faults) -> Option<ControllerKind> {
    let fields = item.fields("a controller", &KINDS, faults)?;
    match fields.among(&KINDS).as_slice() {
        [kind] if kind.key == "arm" => arm(*kind, faults).map(ControllerKind::Arm),
        [kind] if kind.key == "base" => base(*kind, faults).map(ControllerKind::Base),
        [kind] => head(*kind, faults).map(ControllerKind::Head),
        several => {
            let message = format!("a controller with {} kinds instead of one", several.len());
            let help = format!("write exactly one of: {}", KINDS.join(", "));
            faults.push(item.spot, item.key, message, Some(help));
            None
        }
    }
}

fn number(fields: &Fields<'_>, key: &str, quantity: &Quantity, faults: &mut Faults) -> Option<f64> {
    fields.required(key, faults)?.quantity(quantity, faults)
}

fn point(fields: &Fields<'_>, key: &str, faults: &mut Faults) -> Option<Point3<f64>> {
    let at = fields.required(key, faults)?.vector(3..=3, &NEAR, faults)?;
    Some(Point3::from_slice(&at))
}

fn arm(item: Item<'_>, faults: &mut Faults) -> Option<ArmSpec> {
    let keys = ["shoulder", "tuck", "reach", "speed", "acceleration", "grip", "lift"];
    let fields = item.fields("an arm", &keys, faults)?;
    let shoulder = point(&fields, "shoulder", faults);
    let tuck = point(&fields, "tuck", faults);
    let reach_m = number(&fields, "reach", &EXTENT, faults);
    let speed = number(&fields, "speed", &SPEED, faults);
    let acceleration = number(&fields, "acceleration", &ACCELERATION, faults);
    let grip_s = number(&fields, "grip", &GRIP, faults);
    let lift_m = number(&fields, "lift", &LIFT, faults);
    let arm = ArmSpec {
        shoulder: shoulder?,
        tuck: tuck?,
        reach_m: reach_m?,
        speed: speed?,
        acceleration: acceleration?,
        grip_s: grip_s?,
        lift_m: lift_m?,
    };
    if (arm.tuck - arm.shoulder).norm() > arm.reach_m {
        let message = "farther from the shoulder than the arm reaches".to_owned();
        let spot = fields.optional("tuck").map_or(item.spot, |tuck| tuck.spot);
        faults.push(spot, "tuck", message, None);
    }
    Some(arm)
}

fn base(item: Item<'_>, faults: &mut Faults) -> Option<BaseSpec> {
    let keys = ["speed", "acceleration", "turn_speed", "turn_acceleration"];
    let fields = item.fields("a base", &keys, faults)?;
    let speed = number(&fields, "speed", &SPEED, faults);
    let acceleration = number(&fields, "acceleration", &ACCELERATION, faults);
    let turn_speed = number(&fields, "turn_speed", &TURN_SPEED, faults);
    let turn_acceleration = number(&fields, "turn_acceleration", &TURN_ACCELERATION, faults);
    Some(BaseSpec {
        speed: speed?,
        acceleration: acceleration?,
        turn_speed: turn_speed?,
        turn_acceleration: turn_acceleration?,
    })
}

fn head(item: Item<'_>, faults: &mut Faults) -> Option<HeadSpec> {
    let fields = item.fields("a head", &["neck", "speed", "acceleration"], faults)?;
    let neck = point(&fields, "neck", faults);
    let speed = number(&fields, "speed", &TURN_SPEED, faults);
    let acceleration = number(&fields, "acceleration", &TURN_ACCELERATION, faults);
    Some(HeadSpec { neck: neck?, speed: speed?, acceleration: acceleration? })
}
