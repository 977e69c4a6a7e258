//! A robot file as it is written, and as a robot that can be attached: every controller known, used once, and of the
//! fitting kind.

use std::collections::BTreeMap;
use std::time::Duration;

use nalgebra::Point3;

use crate::describe::{At, Custom, Described, Each, List, Map, Point, Word, described};
use crate::fault::Faults;
use crate::names::Register;
use crate::parameter::{PARAMETERS, Parameter, refuse_open_defaults};
use crate::quantity::{ACCELERATION, DURATION, EXTENT, GRACE, GRIP, LIFT, NEAR, SPEED, TURN_ACCELERATION, TURN_SPEED};
use crate::reader::{Item, Name, Written};
use crate::reports::Reported;
use crate::shape::Form;
use ambidex_model::{
    ArmSpec, BaseSpec, ControllerId, ControllerKind, ControllerSpec, HeadSpec, Names, Reportable, ResourceSpec,
    RobotSpec, TypeId,
};

/// The types that the behaviors of the paper know.
const GRIPPER: &str = "gripper";
const HEAD: &str = "head";
const BASE: &str = "base";

/// The key of the controllers.
pub(crate) const CONTROLLERS: &str = "controllers";
/// The key of the resources.
pub(crate) const RESOURCES: &str = "resources";
/// Most resources of a robot.
const MAX_RESOURCES: usize = 1000;
/// Longest name of a controller, bytes: it names shared memory and a log file.
const MAX_CONTROLLER_NAME_BYTES: usize = 32;

const POINT: Point = Point(&NEAR);

const CANCEL_GRACE: &str = "cancel_grace";
const CANCEL_GRACE_DOC: &str =
    "How long it may take to end what it was told to end, wall time; past that it counts as hung; 5 s.";
const CANCEL_GRACE_S: f64 = 5.0;

described! {
    /// A robot file.
    pub(crate) struct Robot: "a robot",
    "A robot as a set of resources, and the controllers that move them. Frame: x forward, y left, z up." {
        robot: Option<Name> = wanted("robot", "Its name.", Word("the name of the robot")),
        radius_m: Option<f64> =
            wanted("radius", "Of the smallest upright cylinder around base and tucked arms.", &EXTENT),
        resources: Vec<(Name, Option<Resource>)> = wanted_all(
            RESOURCES,
            "What behaviors claim, in resource order.",
            Each("a map of resources", Map::<Resource>::new())
        ),
        controllers: Vec<(Name, Option<Controller>)> = maybe_all(
            CONTROLLERS,
            "The processes that move resources.",
            Each("a map of controllers", Map::<Controller>::new())
        ),
    }
}

described! {
    /// An entry of `resources`.
    pub(crate) struct Resource: "a resource", "Something of the robot that a behavior uses." {
        ty: Name = required("type", "`gripper`, `head`, `base`, or any other word.", Word("a type")),
        controller: Option<Name> =
            optional("controller", "Who moves it; without one it only counts.", Word("a controller")),
        at: Option<Written<Point3<f64>>> = optional(
            "at",
            "Where what it holds is, base frame; for a slot of the robot, which has no controller.",
            At(POINT)
        ),
    }
}

described! {
    /// An entry of `controllers`.
    pub(crate) enum Controller: "a controller", "A process that moves one resource, or only reports what it sees." {
        Arm(ReachingArm) = ("arm", "An arm with a gripper.", REACHING_ARM),
        Base(Base) = ("base", "A base that drives in the plane.", Map::<Base>::new()),
        Head(Head) = ("head", "A head, or a camera, that pans and tilts.", Map::<Head>::new()),
        Device(Device) = (
            "device",
            "Anything else: a scanner, a centrifuge, a lamp.",
            Map::<Device>::new()
        ),
    }
}

/// The key of what a controller offers.
const CALLS: &str = "calls";
const CALLS_DOC: &str = "What else behaviors can call, by name.";
const OFFERS: Each<Map<OfferTerm>> = Each("a map of calls", Map::new());

/// Calls as they are written, by name.
type Offers = Vec<(Name, Option<OfferTerm>)>;

described! {
    /// An entry of `calls`.
    pub(crate) struct OfferTerm: "a call", "Something that a controller does when a behavior calls it." {
        parameters: Vec<Parameter> = maybe_all("parameters", "What it is told, by name.", PARAMETERS),
        takes_s: f64 = required("takes", "How long it takes; a simulated controller takes just that.", &DURATION),
    }
}

described! {
    /// `device` of a controller.
    pub(crate) struct Device: "a device", "A device that does what it is called for, and of whose motion nothing is known." {
        calls: Offers = maybe_all(CALLS, "What behaviors can call, by name.", OFFERS),
        cancel_grace_s: Option<f64> = optional(CANCEL_GRACE, CANCEL_GRACE_DOC, &GRACE),
        reports: Option<ReportsTerm> = optional(REPORTS, REPORTS_DOC, Map::<ReportsTerm>::new()),
    }
}

/// The key of what a controller may report.
const REPORTS: &str = "reports";
const REPORTS_DOC: &str = "What it may say of the world beyond what it moves.";

described! {
    /// `reports` of a controller.
    pub(crate) struct ReportsTerm: "reports", "Facts and objects that a controller sees; a mission without them has no use for it." {
        facts: Vec<Name> = maybe_all(
            "facts",
            "Facts that it may set and clear, if the mission declares them `outside`.",
            List("a list of facts", Word("a fact"))
        ),
        objects: Vec<Name> = maybe_all(
            "objects",
            "Objects that it may say the place of, as long as no gripper holds them.",
            List("a list of objects", Word("an object"))
        ),
    }
}

impl ReportsTerm {
    fn reportable(&self) -> Reportable {
        let names = |names: &[Name]| names.iter().map(|name| name.value.clone()).collect();
        Reportable { facts: names(&self.facts), objects: names(&self.objects) }
    }
}

/// How long a hand is of which nothing is told, meters.
const HAND_M: f64 = 0.15;

/// An arm, the radius of its links and the length of its hand, its grace, its calls, and what it may report.
type ReachingArm = (ArmSpec, (Option<f64>, f64), Option<f64>, Offers, Option<ReportsTerm>);

/// A call that a controller offers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Offer {
    pub(crate) name: String,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) takes: Duration,
}

impl Offer {
    /// Whether a behavior cannot tell the one from the other.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let parameters = |offer: &Self| {
            let plain = offer.parameters.iter().map(|parameter| {
                let default = parameter.plain_default().map(str::to_owned);
                (parameter.name.value.clone(), parameter.ty, parameter.defaults.is_some(), default)
            });
            plain.collect::<Vec<_>>()
        };
        (&self.name, self.takes) == (&other.name, other.takes) && parameters(self) == parameters(other)
    }
}

described! {
    /// `arm` of a controller; times in s, all else in m and s.
    struct Arm: "an arm", "An arm with a gripper; points in the base frame." {
        shoulder: Point3<f64> = required("shoulder", "Where the arm begins.", POINT),
        tuck: Written<Point3<f64>> = required("tuck", "Where the gripper rests.", At(POINT)),
        reach_m: f64 = required("reach", "How far the gripper comes from the shoulder.", &EXTENT),
        speed: f64 = required("speed", "Top speed of the gripper.", &SPEED),
        acceleration: f64 = required("acceleration", "Top acceleration of the gripper.", &ACCELERATION),
        grip_s: f64 = required("grip", "How long the gripper takes to close or open.", &GRIP),
        lift_m: f64 = required("lift", "How far it lifts after closing or opening.", &LIFT),
        radius_m: Option<f64> = optional(
            "radius",
            "Of its links: arms whose radius is told are not let cross each other.",
            &EXTENT
        ),
        hand_m: f64 = or(
            "hand",
            "From its wrist to what it takes, a part of `reach`: what may be grasped from some sides only needs the wrist \
             there; 0.15 m.",
            &EXTENT,
            HAND_M
        ),
        cancel_grace_s: Option<f64> = optional(CANCEL_GRACE, CANCEL_GRACE_DOC, &GRACE),
        reports: Option<ReportsTerm> = optional(REPORTS, REPORTS_DOC, Map::<ReportsTerm>::new()),
        calls: Offers = maybe_all(CALLS, CALLS_DOC, OFFERS),
    }
}

described! {
    /// `base` of a controller, in m, rad and s.
    pub(crate) struct Base: "a base", "A base that drives in any direction." {
        speed: f64 = required("speed", "Top speed.", &SPEED),
        acceleration: f64 = required("acceleration", "Top acceleration.", &ACCELERATION),
        turn_speed: f64 = required("turn_speed", "Top turning speed.", &TURN_SPEED),
        turn_acceleration: f64 = required("turn_acceleration", "Top turning acceleration.", &TURN_ACCELERATION),
        cancel_grace_s: Option<f64> = optional(CANCEL_GRACE, CANCEL_GRACE_DOC, &GRACE),
        reports: Option<ReportsTerm> = optional(REPORTS, REPORTS_DOC, Map::<ReportsTerm>::new()),
        calls: Offers = maybe_all(CALLS, CALLS_DOC, OFFERS),
    }
}

described! {
    /// `head` of a controller, in m, rad and s.
    pub(crate) struct Head: "a head", "A head that pans and tilts." {
        neck: Point3<f64> = required("neck", "The crossing of its axes, in the base frame.", POINT),
        speed: f64 = required("speed", "Top speed of each axis.", &TURN_SPEED),
        acceleration: f64 = required("acceleration", "Top acceleration of each axis.", &TURN_ACCELERATION),
        cancel_grace_s: Option<f64> = optional(CANCEL_GRACE, CANCEL_GRACE_DOC, &GRACE),
        reports: Option<ReportsTerm> = optional(REPORTS, REPORTS_DOC, Map::<ReportsTerm>::new()),
        calls: Offers = maybe_all(CALLS, CALLS_DOC, OFFERS),
    }
}

/// An arm that reaches where it rests.
const REACHING_ARM: Custom<ReachingArm> = Custom(
    || Form::Map(Arm::shape),
    |item, reading| {
        let written = Arm::read(item, reading)?;
        let Arm { shoulder, tuck, reach_m, speed, acceleration, grip_s, lift_m, .. } = written;
        if (tuck.value - shoulder).norm() > reach_m {
            reading.faults.push(&tuck, "farther from the shoulder than the arm reaches");
        }
        let arm = ArmSpec { shoulder, tuck: tuck.value, reach_m, speed, acceleration, grip_s, lift_m };
        let body = (written.radius_m, written.hand_m);
        Some((arm, body, written.cancel_grace_s, written.calls, written.reports))
    },
);

impl Controller {
    fn kind(&self) -> ControllerKind {
        match *self {
            Self::Arm((arm, ..)) => ControllerKind::Arm(arm),
            Self::Base(Base { speed, acceleration, turn_speed, turn_acceleration, .. }) => {
                ControllerKind::Base(BaseSpec { speed, acceleration, turn_speed, turn_acceleration })
            }
            Self::Head(Head { neck, speed, acceleration, .. }) => {
                ControllerKind::Head(HeadSpec { neck, speed, acceleration })
            }
            Self::Device(_) => ControllerKind::Device,
        }
    }
}

impl Controller {
    fn cancel_grace(&self) -> Duration {
        let grace_s = match self {
            Self::Arm((_, _, grace_s, ..)) => *grace_s,
            Self::Base(base) => base.cancel_grace_s,
            Self::Head(head) => head.cancel_grace_s,
            Self::Device(device) => device.cancel_grace_s,
        };
        Duration::from_secs_f64(grace_s.unwrap_or(CANCEL_GRACE_S))
    }

    /// Of an arm, the radius of its links.
    fn body(&self) -> (Option<f64>, f64) {
        match self {
            Self::Arm((_, body, ..)) => *body,
            Self::Base(_) | Self::Head(_) | Self::Device(_) => (None, 0.0),
        }
    }

    /// What it may report, as it is written.
    fn reports(&self) -> Option<&ReportsTerm> {
        let reports = match self {
            Self::Arm((.., reports)) => reports,
            Self::Base(base) => &base.reports,
            Self::Head(head) => &head.reports,
            Self::Device(device) => &device.reports,
        };
        reports.as_ref()
    }

    /// What it may report.
    fn reportable(&self) -> Reportable {
        self.reports().map(ReportsTerm::reportable).unwrap_or_default()
    }

    /// What it offers.
    fn offers(&self, faults: &mut Faults) -> Vec<Offer> {
        let calls = match self {
            Self::Arm((.., calls, _)) => calls,
            Self::Base(base) => &base.calls,
            Self::Head(head) => &head.calls,
            Self::Device(device) => &device.calls,
        };
        let offers = calls.iter().filter_map(|(name, term)| {
            let OfferTerm { parameters, takes_s } = term.as_ref()?;
            refuse_open_defaults("a call", parameters.iter(), faults);
            let (name, takes) = (name.value.clone(), Duration::from_secs_f64(*takes_s));
            Some(Offer { name, parameters: parameters.clone(), takes })
        });
        offers.collect()
    }
}

/// A robot and what its parts are called.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotFile {
    /// Resources and controllers by id.
    pub robot: RobotSpec,
    /// Names of resources, types and controllers; the other lists are empty.
    pub names: Names,
    /// What each controller offers beyond what its kind can do.
    pub(crate) offers: Vec<Vec<Offer>>,
    /// What controllers may report, as it is written.
    pub(crate) reported: Reported,
}

/// Reads and checks a robot file; `None` when it has faults.
pub(crate) fn read(file: Item<'_>, faults: &mut Faults) -> Option<RobotFile> {
    let before = faults.errors();
    let raw = Robot::take(file, faults)?;
    build(raw, faults).filter(|_| faults.errors() == before)
}

fn build(raw: Robot, faults: &mut Faults) -> Option<RobotFile> {
    let controllers = Register::of_entries("controller", &raw.controllers);
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
        if let (Some(at), Some(_)) = (&resource.at, &resource.controller) {
            let help = "leave it out: its controller knows where it is";
            faults.push_with(at, "only what has no controller has a fixed position", help);
        }
        let at = resource.at.as_ref().map(|at| at.value);
        resources.push(ResourceSpec { ty, controller, at });
    }
    check_limits(&raw, &users, faults);
    check_mixed(&raw, faults);

    let (mut specs, mut offers, mut reported) = (Vec::new(), Vec::new(), Reported::default());
    for (name, kind) in &raw.controllers {
        offers.extend(kind.as_ref().map(|kind| kind.offers(faults)));
        if let Some(term) = kind.as_ref().and_then(Controller::reports) {
            reported.facts.extend(term.facts.iter().cloned());
            reported.objects.extend(term.objects.iter().cloned());
        }
        specs.extend(kind.as_ref().map(|kind| ControllerSpec {
            name: name.value.clone(),
            kind: kind.kind(),
            cancel_grace: kind.cancel_grace(),
            radius_m: kind.body().0,
            hand_m: kind.body().1,
            reports: kind.reportable(),
        }));
    }
    let (name, radius_m) = (raw.robot?.value, raw.radius_m?);
    Some(RobotFile {
        offers,
        reported,
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
        faults.push(wanted, format!("controller `{}` moves `{other}` already", wanted.value));
    }
    Some(found)
}

/// The types that the kinds of behavior know are moved by what can do their commands.
fn check_kind(resource: &Resource, kind: &Option<Controller>, faults: &mut Faults) {
    let (Some(kind), Some(name)) = (kind, &resource.controller) else {
        return;
    };
    let (word, ty) = match kind {
        Controller::Arm(_) => ("an arm", Some(GRIPPER)),
        Controller::Base(_) => ("a base", Some(BASE)),
        Controller::Head(_) => ("a head", Some(HEAD)),
        Controller::Device(_) => ("a device", None),
    };
    let found = resource.ty.value.as_str();
    if [GRIPPER, BASE, HEAD].contains(&found) && Some(found) != ty {
        faults.push(name, format!("controller `{}` moves {word}, not a {found}", name.value));
    }
}

fn check_limits(raw: &Robot, users: &BTreeMap<ControllerId, String>, faults: &mut Faults) {
    if raw.resources.len() > MAX_RESOURCES
        && let Some((name, _)) = raw.resources.get(MAX_RESOURCES)
    {
        faults.push((name.span, RESOURCES), format!("more than {MAX_RESOURCES} resources"));
    }
    for (index, (name, kind)) in raw.controllers.iter().enumerate() {
        let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-".contains(letter);
        if name.value.len() > MAX_CONTROLLER_NAME_BYTES || !name.value.chars().all(is_plain) {
            let message = format!(
                "the name of a controller has at most {MAX_CONTROLLER_NAME_BYTES} letters, digits, `_` and `-`"
            );
            faults.push((name.span, &name.value), message);
        }
        let reports = kind.as_ref().is_some_and(|kind| kind.reports().is_some());
        if let Some(Controller::Device(device)) = kind
            && !reports
            && device.calls.is_empty()
        {
            let help = "what behaviors call it for stands in `calls`, what it sees in `reports`".to_owned();
            faults.push_with((name.span, &name.value), "a device that can do nothing and says nothing", help);
        }
        if !reports && !users.contains_key(&ControllerId::from(index)) {
            let help = "name it as the `controller` of what it moves, or leave it out".to_owned();
            faults.push_with((name.span, &name.value), "no resource has this controller", help);
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
            faults.push((name.span, &name.value), message);
        }
    }
}
