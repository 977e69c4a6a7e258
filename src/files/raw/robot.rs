//! A robot file: resources, the controller of each, and what a controller moves.

use nalgebra::Point3;

use super::super::fault::Faults;
use super::super::quantity::{ACCELERATION, EXTENT, GRIP, LIFT, NEAR, SPEED, TURN_ACCELERATION, TURN_SPEED};
use super::super::reader::{Fields, Item};
use super::super::shape::{Form, Shape, optional, required};
use super::{Resource, Robot, each};
use ambidex_model::{ArmSpec, BaseSpec, ControllerKind, HeadSpec};

/// A robot file.
pub(in super::super) static ROBOT: Shape = Shape::new(
    "a robot",
    "A robot as a set of resources, and the controllers that move them. Frame: x forward, y left, z up.",
    &[
        required("robot", "Its name.", Form::Word),
        required("radius", "Of the smallest upright cylinder around base and tucked arms.", Form::Quantity(&EXTENT)),
        required("resources", "What behaviors claim, in resource order.", Form::Each(&Form::Map(&RESOURCE))),
        optional("controllers", "The processes that move resources.", Form::Each(&Form::Map(&CONTROLLER))),
    ],
);

static RESOURCE: Shape = Shape::new(
    "a resource",
    "Something of the robot that a behavior uses.",
    &[
        required("type", "`gripper`, `head`, `base`, or any other word.", Form::Word),
        optional("controller", "Who moves it; without one it only counts.", Form::Word),
    ],
);

static CONTROLLER: Shape = Shape::new(
    "a controller",
    "A process that moves one resource.",
    &[
        optional("arm", "An arm with a gripper.", Form::Map(&ARM)),
        optional("base", "A base that drives in the plane.", Form::Map(&BASE)),
        optional("head", "A head, or a camera, that pans and tilts.", Form::Map(&HEAD)),
    ],
)
.with_one_of(&["arm", "base", "head"]);

const POINT: Form = Form::Vector(3, 3, &NEAR);

static ARM: Shape = Shape::new(
    "an arm",
    "An arm with a gripper; points in the base frame.",
    &[
        required("shoulder", "Where the arm begins.", POINT),
        required("tuck", "Where the gripper rests.", POINT),
        required("reach", "How far the gripper comes from the shoulder.", Form::Quantity(&EXTENT)),
        required("speed", "Top speed of the gripper.", Form::Quantity(&SPEED)),
        required("acceleration", "Top acceleration of the gripper.", Form::Quantity(&ACCELERATION)),
        required("grip", "How long the gripper takes to close or open.", Form::Quantity(&GRIP)),
        required("lift", "How far it lifts after closing or opening.", Form::Quantity(&LIFT)),
    ],
);

static BASE: Shape = Shape::new(
    "a base",
    "A base that drives in any direction.",
    &[
        required("speed", "Top speed.", Form::Quantity(&SPEED)),
        required("acceleration", "Top acceleration.", Form::Quantity(&ACCELERATION)),
        required("turn_speed", "Top turning speed.", Form::Quantity(&TURN_SPEED)),
        required("turn_acceleration", "Top turning acceleration.", Form::Quantity(&TURN_ACCELERATION)),
    ],
);

static HEAD: Shape = Shape::new(
    "a head",
    "A head that pans and tilts.",
    &[
        required("neck", "The crossing of its axes, in the base frame.", POINT),
        required("speed", "Top speed of each axis.", Form::Quantity(&TURN_SPEED)),
        required("acceleration", "Top acceleration of each axis.", Form::Quantity(&TURN_ACCELERATION)),
    ],
);

impl Robot {
    /// Reads a robot file.
    pub(in super::super) fn read(file: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = file.fields(&ROBOT, faults)?;
        let name = fields.get("robot");
        Some(Self {
            robot: name.and_then(|item| item.name("the name of the robot", faults)),
            radius_m: fields.number("radius", faults),
            resources: each(fields.get("resources"), "a map of resources", faults, Resource::read),
            controllers: each(fields.get("controllers"), "a map of controllers", faults, controller),
        })
    }
}

impl Resource {
    fn read(item: Item<'_>, faults: &mut Faults) -> Option<Self> {
        let fields = item.fields(&RESOURCE, faults)?;
        let controller = match fields.get("controller") {
            Some(item) => item.name("a controller", faults).map(Some),
            None => Some(None),
        };
        let ty = fields.get("type")?.name("a type", faults);
        Some(Self { ty: ty?, controller: controller? })
    }
}

fn controller(item: Item<'_>, faults: &mut Faults) -> Option<ControllerKind> {
    let fields = item.fields(&CONTROLLER, faults)?;
    let kind = fields.one()?;
    match kind.key {
        "arm" => arm(kind, faults).map(ControllerKind::Arm),
        "base" => base(kind, faults).map(ControllerKind::Base),
        _ => head(kind, faults).map(ControllerKind::Head),
    }
}

fn point(fields: &Fields<'_>, key: &str, faults: &mut Faults) -> Option<Point3<f64>> {
    Some(Point3::from_slice(&fields.vector(key, faults)?))
}

fn arm(item: Item<'_>, faults: &mut Faults) -> Option<ArmSpec> {
    let fields = item.fields(&ARM, faults)?;
    let shoulder = point(&fields, "shoulder", faults);
    let tuck = point(&fields, "tuck", faults);
    let reach_m = fields.number("reach", faults);
    let speed = fields.number("speed", faults);
    let acceleration = fields.number("acceleration", faults);
    let grip_s = fields.number("grip", faults);
    let lift_m = fields.number("lift", faults);
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
        let spot = fields.get("tuck").map_or(item.spot, |tuck| tuck.spot);
        faults.push(spot, "tuck", message, None);
    }
    Some(arm)
}

fn base(item: Item<'_>, faults: &mut Faults) -> Option<BaseSpec> {
    let fields = item.fields(&BASE, faults)?;
    let speed = fields.number("speed", faults);
    let acceleration = fields.number("acceleration", faults);
    let turn_speed = fields.number("turn_speed", faults);
    let turn_acceleration = fields.number("turn_acceleration", faults);
    Some(BaseSpec {
        speed: speed?,
        acceleration: acceleration?,
        turn_speed: turn_speed?,
        turn_acceleration: turn_acceleration?,
    })
}

fn head(item: Item<'_>, faults: &mut Faults) -> Option<HeadSpec> {
    let fields = item.fields(&HEAD, faults)?;
    let neck = point(&fields, "neck", faults);
    let speed = fields.number("speed", faults);
    let acceleration = fields.number("acceleration", faults);
    Some(HeadSpec { neck: neck?, speed: speed?, acceleration: acceleration? })
}
