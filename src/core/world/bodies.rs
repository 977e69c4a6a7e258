//! What the bodies of one robot can do at once: its base is at one place at a time, and its arms do not touch.

use parry3d::math::{Pose as ParryPose, Rotation, Vector as ParryVector};
use parry3d::query::intersection_test;
use parry3d::shape::{Capsule, Cuboid};

use nalgebra::Point3;

use super::view::{Compatible, Use, View};
use ambidex_model::{
    BehaviorSpec, Clash, CommandTerm, ControllerKind, EffectTerm, MissionSpec, NodeId, ObjectId, Obstacle, PlaceId,
    Pose, Reason, Request, ResourceId, RobotSpec, Task,
};

/// The bodies of the robot. Root asks it, who knows what runs; arms have a body where their `radius` is told.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bodies;

/// What one use wants of a body.
#[derive(Debug)]
struct Demand {
    leaf: NodeId,
    resource: ResourceId,
    is_running: bool,
    base: Option<BaseDemand>,
    /// Whether a base is told to drive.
    drives: bool,
    arm: Option<Capsule>,
    /// What it puts down, where that is told.
    put: Vec<(ObjectId, PlaceId, Point3<f64>)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum BaseDemand {
    /// It is brought here, map frame.
    At(Pose),
    Still,
}

impl Bodies {
    /// Whether a behavior may be in the way of others, or they in its: it moves an arm that has a body.
    pub fn matter_to(mission: &MissionSpec, spec: &BehaviorSpec) -> bool {
        let robot = &mission.robot;
        let has_body = |resource: &ResourceId| {
            let controller = robot.resources[resource.index()].controller;
            controller.is_some_and(|id| robot.controllers[id.index()].radius_m.is_some())
        };
        spec.commands.iter().any(|term| match term.task {
            Task::Grasp(_) | Task::GraspFrom(..) | Task::Put(..) | Task::PutInto(..) => {
                robot.could_serve(spec.claims[term.claim].selector).iter().any(has_body)
            }
            Task::DriveTo(..) | Task::Stand | Task::LookAt(_) | Task::Call(_) => false,
        })
    }
}

impl Compatible for Bodies {
    fn check(&self, view: &View, uses: &[Use<'_>]) -> Result<(), Reason> {
        let demands: Vec<_> = uses.iter().filter_map(|used| demand(view, used)).collect();
        let last = uses.last().map(|used| used.request.leaf);
        for (index, one) in demands.iter().enumerate() {
            for other in &demands[..index] {
                // What runs already was judged, one behavior is in its own way for a reason, and who may have one resource
                // after the other is the table's.
                let is_judged = one.is_running && other.is_running;
                if is_judged || one.leaf == other.leaf || one.resource == other.resource {
                    continue;
                }
                if let Some(over) = clash(view, one, other) {
                    let with = if Some(other.leaf) == last { one.leaf } else { other.leaf };
                    return Err(Reason::Clash { with, over });
                }
            }
        }
        Ok(())
    }

    fn is_for_root(&self) -> bool {
        true
    }
}

/// The request with those resources alone with which it can go on beside what runs: who cannot does not stand before
/// those who can.
///
/// # Errors
/// Why none is left of what it claims.
pub fn beside_running(view: &View, request: Request) -> Result<Request, Reason> {
    let spec = view.mission.tree.behavior(request.leaf);
    if view.state.running().is_empty() || !spec.is_some_and(|spec| Bodies::matter_to(&view.mission, spec)) {
        return Ok(request);
    }
    let mut uses: Vec<_> = view.uses().collect();
    let mut claims = request.claims.clone();
    for (claim, options) in claims.iter_mut().enumerate() {
        let mut refusal = None;
        options.candidates.retain(|candidate| {
            uses.push(Use { request: &request, claim: Some(claim), resource: candidate.resource, is_running: false });
            let checked = view.rules.check(view, &uses);
            uses.pop();
            let is_allowed = checked.is_ok();
            refusal = refusal.take().or(checked.err());
            is_allowed
        });
        if let Some(reason) = refusal.filter(|_| options.candidates.is_empty()) {
            return Err(reason);
        }
    }
    drop(uses);
    Ok(Request { claims, ..request })
}

fn clash(view: &View, one: &Demand, other: &Demand) -> Option<Clash> {
    let wants = [one.base, other.base];
    if let [Some(first), Some(second)] = wants {
        // Two bases that bring one body to one place come from two.
        let are_drives = [one, other].iter().all(|demand| demand.drives);
        if first != second || are_drives {
            return Some(Clash::Base);
        }
    }
    let meets = |&(object, place, at): &(ObjectId, PlaceId, Point3<f64>)| {
        let mut others = other.put.iter().filter(|(_, there, _)| *there == place);
        others.any(|&(other, _, point)| view.mission.world.meet((object, at), (other, point)))
    };
    if one.put.iter().any(meets) {
        return Some(Clash::Spot);
    }
    let (one, other) = (one.arm.as_ref()?, other.arm.as_ref()?);
    let here = ParryPose::IDENTITY;
    let meet = intersection_test(&here, one, &here, other).expect("parry tests capsules against capsules");
    meet.intersecting.then_some(Clash::Arms)
}

/// What a use wants of base or arm; none where it wants neither.
fn demand(view: &View, used: &Use<'_>) -> Option<Demand> {
    let (leaf, robot) = (used.request.leaf, &view.mission.robot);
    let spec = view.mission.tree.behavior(leaf)?.asked(used.request);
    let claim = used.claim?;
    let base = base_demand(spec, claim, used.resource, robot);
    let arm = arm_demand(view, spec, claim, used);
    let mut put = view.puts(used.request);
    put.retain(|(object, place, _)| view.mission.world.is_spot_told(*object, *place));
    (base.is_some() || arm.is_some() || !put.is_empty()).then_some(Demand {
        leaf,
        resource: used.resource,
        is_running: used.is_running,
        base,
        drives: matches!(base, Some(BaseDemand::At(_))) && is_base(used.resource, robot),
        arm,
        put,
    })
}

fn of_claim(spec: &BehaviorSpec, claim: usize) -> impl Iterator<Item = &CommandTerm> {
    spec.commands.iter().filter(move |term| term.claim == claim)
}

fn base_demand(spec: &BehaviorSpec, claim: usize, resource: ResourceId, robot: &RobotSpec) -> Option<BaseDemand> {
    let brought = spec.effects.iter().find_map(|effect| match effect {
        EffectTerm::Stands(pose) => Some(BaseDemand::At(*pose)),
        EffectTerm::Lies(..) | EffectTerm::Taken(..) | EffectTerm::LetGo(..) | EffectTerm::Fact(..) => None,
    });
    let told = of_claim(spec, claim).find_map(|term| match term.task {
        Task::DriveTo(_, stand) => Some(BaseDemand::At(stand)),
        Task::Stand if is_base(resource, robot) => Some(BaseDemand::Still),
        Task::Stand | Task::Grasp(_) | Task::GraspFrom(..) | Task::Put(..) | Task::PutInto(..) => None,
        Task::LookAt(_) | Task::Call(_) => None,
    });
    brought.or(told)
}

fn is_base(resource: ResourceId, robot: &RobotSpec) -> bool {
    let controller = robot.resources[resource.index()].controller;
    controller.is_some_and(|id| matches!(robot.controllers[id.index()].kind, ControllerKind::Base(_)))
}

/// The arm as it is stretched out, base frame: a straight one from the shoulder to what it reaches for.
fn arm_demand(view: &View, spec: &BehaviorSpec, claim: usize, used: &Use<'_>) -> Option<Capsule> {
    let robot = &view.mission.robot;
    let arm = robot.arm(used.resource)?;
    let controller = robot.resources[used.resource.index()].controller?;
    let radius_m = robot.controllers[controller.index()].radius_m?;
    let reached = of_claim(spec, claim).find_map(|term| reached(view, used, &term.task))?;
    Some(Capsule::new(vector(arm.shoulder), vector(reached), radius_m as f32))
}

/// What a hand reaches for, base frame, meters; none where that is a guess.
fn reached(view: &View, used: &Use<'_>, task: &Task) -> Option<Point3<f64>> {
    let (world, world_state) = (&view.mission.world, view.state.world());
    let (object, place, at) = match *task {
        Task::Grasp(object) => {
            let place = world_state.objects[object.index()].place()?;
            (object, place, world.object(world_state, object)?)
        }
        Task::Put(object, place) => (object, place, world.spot(object, place, used.request.spot(object))),
        // From hand to hand is one behavior's own.
        Task::GraspFrom(..) | Task::PutInto(..) => return view.mission.robot.carried_at(used.resource),
        Task::DriveTo(..) | Task::Stand | Task::LookAt(_) | Task::Call(_) => return None,
    };
    world.is_spot_told(object, place).then(|| world_state.base.to_local(at))
}

/// Whether two boxes are farther into each other than so much, meters.
pub fn overlap(one: &Obstacle, other: &Obstacle, slack_m: f64) -> bool {
    let cuboid = |solid: &Obstacle| {
        let half = (solid.size.add_scalar(-slack_m) / 2.0).map(|side| side.max(1e-3));
        Cuboid::new(vector(half.into()))
    };
    let pose = |solid: &Obstacle| {
        let at = vector(solid.middle);
        ParryPose::from_translation(at) * ParryPose::from_rotation(Rotation::from_rotation_z(solid.heading as f32))
    };
    let test = intersection_test(&pose(one), &cuboid(one), &pose(other), &cuboid(other));
    test.expect("parry tests boxes against boxes").intersecting
}

fn vector(point: Point3<f64>) -> ParryVector {
    ParryVector::new(point.x as f32, point.y as f32, point.z as f32)
}
