//! Small missions for tests: a tree from nested values, a robot, a world.

use std::f64::consts::TAU;
use std::time::Duration;

use ambidex::model::{
    Access, ArmSpec, BaseSpec, BehaviorSpec, ChannelId, Claim, CommandTerm, Condition, ControllerId, ControllerKind,
    ControllerSpec, Distance, EffectTerm, FactId, HeadSpec, Location, MissionSpec, Mode, Names, NodeId, NodeKind,
    ObjectId, ObjectSpec, PlaceId, PlaceSpec, Pose, Potential, ResourceId, ResourceSpec, Retention, RobotSpec,
    Selector, Task, Topology, TreeSpec, TypeId, WorldSpec, WorldState,
};
use nalgebra::{Point3, Vector3};

pub const GRIPPER: TypeId = TypeId(0);
pub const HEAD: TypeId = TypeId(1);
pub const BASE: TypeId = TypeId(2);
pub const TOOL: TypeId = TypeId(3);
/// A type of which no robot here has any.
pub const WING: TypeId = TypeId(4);

/// Distance within which a move is satisfied, meters.
pub const TOLERANCE_M: f64 = 0.25;

/// A tree as a value.
#[derive(Debug, Clone)]
pub enum Tree {
    And(Vec<Tree>),
    Or(Vec<Tree>),
    Then(Vec<Tree>),
    /// A body, and what cleans up behind it.
    Cleanup(Box<[Tree; 2]>),
    Leaf(String, Box<BehaviorSpec>),
}

/// How many of each type the robot has, and how far its arms reach.
#[derive(Debug, Clone, Copy)]
pub struct Body {
    pub grippers: usize,
    pub heads: usize,
    pub bases: usize,
    pub tools: usize,
    pub reach_m: f64,
}

impl Body {
    pub fn spec(self) -> RobotSpec {
        let mut robot =
            RobotSpec { name: "tester".into(), resources: Vec::new(), controllers: Vec::new(), radius_m: 0.3 };
        let mut add = |ty, name: String, kind: Option<ControllerKind>| {
            let controller = kind.map(|kind| {
                robot.controllers.push(ControllerSpec {
                    name,
                    kind,
                    cancel_grace: Duration::from_secs(5),
                    radius_m: None,
                    hand_m: 0.0,
                    reports: Default::default(),
                });
                ControllerId::from(robot.controllers.len() - 1)
            });
            robot.resources.push(ResourceSpec { ty, controller, at: None });
        };
        for index in 0..self.grippers {
            let side = if index % 2 == 0 { 0.2 } else { -0.2 };
            let shoulder = Point3::new(0.1 + 0.013 * index as f64, side, 0.8);
            let arm = ArmSpec {
                shoulder,
                tuck: shoulder,
                reach_m: self.reach_m,
                speed: 1.0,
                acceleration: 1.0,
                grip_s: 0.5,
                lift_m: 0.1,
            };
            add(GRIPPER, format!("arm{index}"), Some(ControllerKind::Arm(arm)));
        }
        for index in 0..self.heads {
            let head = HeadSpec { neck: Point3::new(0.0, 0.0, 1.2), speed: 1.0, acceleration: 1.0 };
            add(HEAD, format!("neck{index}"), Some(ControllerKind::Head(head)));
        }
        for index in 0..self.bases {
            let base = BaseSpec { speed: 1.0, acceleration: 1.0, turn_speed: 1.0, turn_acceleration: 1.0 };
            add(BASE, format!("wheels{index}"), Some(ControllerKind::Base(base)));
        }
        for index in 0..self.tools {
            add(TOOL, format!("tool{index}"), None);
        }
        robot
    }

    /// The first resource of a type, if the robot has one.
    pub fn first(self, ty: TypeId) -> Option<ResourceId> {
        self.spec().of_type(ty).next()
    }
}

/// A place on a circle around the middle of the room, so that no two have a third between them.
pub fn place(index: usize, of: usize) -> PlaceSpec {
    let angle = TAU * index as f64 / of as f64;
    PlaceSpec {
        stand: Pose::new(4.0 * angle.cos(), 4.0 * angle.sin(), angle),
        others: Vec::new(),
        surface: Point3::new(0.6, 0.0, 0.8),
        is_surface_told: false,
        table: None,
        spots: Vec::new(),
    }
}

/// A mission around a tree: objects lie where `objects` says, facts are as `facts` says.
pub fn mission(body: Body, places: usize, objects: Vec<Location>, facts: Vec<bool>, tree: &Tree) -> MissionSpec {
    let robot = body.spec();
    let list = |word: &str, count: usize| (0..count).map(|index| format!("{word}{index}")).collect();
    let (tree, nodes) = tree_spec(tree);
    let names = Names {
        nodes: nodes.into(),
        resources: robot
            .resources
            .iter()
            .enumerate()
            .map(|(index, spec)| {
                let word = ["gripper", "head", "base", "tool", "wing"][spec.ty.index()];
                format!("{word}#{index}")
            })
            .collect(),
        types: ["gripper", "head", "base", "tool", "wing"].map(String::from).to_vec(),
        channels: list("channel", 16),
        stands: Vec::new(),
        objects: list("object", objects.len()),
        places: list("place", places),
        facts: list("fact", facts.len()),
        controllers: robot.controllers.iter().map(|spec| spec.name.clone()).collect(),
    };
    let offset = |index: usize| Vector3::new(0.0, 0.15 * index as f64 - 0.2, 0.0);
    MissionSpec {
        name: "test".into(),
        world: WorldSpec {
            places: (0..places).map(|index| place(index, places)).collect(),
            objects: (0..objects.len()).map(offset).map(ObjectSpec::at).collect(),
            obstacles: Vec::new(),
            distance: Distance::Straight,
            outside: Vec::new(),
        },
        start: WorldState::new(Pose::new(0.0, 0.0, 0.0), objects, facts),
        robot,
        tree,
        names,
        source: None,
    }
}

fn tree_spec(tree: &Tree) -> (TreeSpec, Vec<String>) {
    fn add(tree: &Tree, parent: NodeId, spec: &mut (Vec<NodeKind>, Vec<NodeId>, Vec<String>)) {
        let id = NodeId::from(spec.0.len());
        let (kind, name, children): (_, _, &[Tree]) = match tree {
            Tree::And(children) => (NodeKind::And, format!("and{}", id.0), children),
            Tree::Or(children) => (NodeKind::Or, format!("or{}", id.0), children),
            Tree::Then(children) => (NodeKind::Then, format!("then{}", id.0), children),
            Tree::Cleanup(children) => (NodeKind::Cleanup, format!("cleanup{}", id.0), children.as_slice()),
            Tree::Leaf(name, behavior) => (NodeKind::Behavior(behavior.clone()), name.clone(), &[]),
        };
        spec.0.push(kind);
        spec.1.push(parent);
        spec.2.push(name);
        children.iter().for_each(|child| add(child, id, spec));
    }
    let mut spec = (vec![NodeKind::Root], vec![NodeId(0)], vec!["root".into()]);
    add(tree, NodeId(0), &mut spec);
    let topology = Topology::new(spec.1);
    (TreeSpec::new(spec.0, topology), spec.2)
}

/// The tree, one node a line.
pub fn draw(mission: &MissionSpec) -> String {
    let tree = &mission.tree;
    let mut drawing = String::new();
    for index in 1..tree.nodes.len() {
        let mut depth = 0;
        let mut node = NodeId::from(index);
        while node.0 > 1 {
            node = tree.topology.parent(node);
            depth += 1;
        }
        drawing += &"  ".repeat(depth);
        drawing += &format!("{index} {}", mission.names.nodes[index]);
        if tree.has_priorities() {
            drawing += &format!(" !{}", tree.priority(NodeId::from(index)));
        }
        if let Some(spec) = tree.behavior(NodeId::from(index)) {
            drawing += &format!(
                ": claims {:?}, potential {:?}, satisfied {:?}, precondition {:?}, effects {:?}, changes {:?}, retries {}",
                spec.claims,
                spec.potential,
                spec.satisfied,
                spec.precondition,
                spec.effects,
                spec.changes,
                spec.retries
            );
            if spec.lasting != Condition::All(Vec::new()) {
                drawing += &format!(", lasting {:?}", spec.lasting);
            }
            drawing += if spec.is_interruptible { "" } else { ", not to be interrupted" };
        }
        drawing += "\n";
    }
    short(&drawing)
}

/// Debug text without what every reader knows.
pub fn short(text: &str) -> String {
    let mut text = text.to_owned();
    while let Some((before, rest)) = text.split_once("Pose {") {
        let rest = rest.split_once('}').map_or("", |(_, rest)| rest);
        text = format!("{before}..{rest}");
    }
    for (long, brief) in [("Id(", "("), ("Claim ", ""), ("stand: .., tolerance_m: 0.25", "..")] {
        text = text.replace(long, brief);
    }
    text
}

/// A behavior that needs nothing, and is done only by running.
pub fn blank(kind: &str) -> BehaviorSpec {
    BehaviorSpec {
        kind: kind.into(),
        claims: Vec::new(),
        potential: Potential::Constant(1.0),
        satisfied: Condition::Never,
        precondition: Condition::All(Vec::new()),
        lasting: Condition::All(Vec::new()),
        is_interruptible: true,
        effects: Vec::new(),
        commands: Vec::new(),
        changes: Vec::new(),
        takes: Duration::ZERO,
        timeout: Duration::from_secs(60),
        retries: 0,
        backoff: Duration::ZERO,
        elsewhere: None,
        stands: None,
    }
}

pub fn claim(selector: Selector, access: Access, keep: Retention) -> Claim {
    Claim { selector, access, keep }
}

/// Shared with whom does the same there.
pub fn at_channel(place: PlaceId) -> ChannelId {
    ChannelId(8 + place.0)
}

fn only(body: Body, ty: TypeId) -> Selector {
    body.first(ty).map_or(Selector::Any(ty), Selector::Named)
}

/// `move` of the paper; its place is one of `places` on the circle.
pub fn move_to(body: Body, to: PlaceId, places: usize) -> BehaviorSpec {
    let stand = place(to.index(), places).stand;
    let kept = Access::Shared(at_channel(to));
    BehaviorSpec {
        claims: vec![claim(only(body, BASE), Access::Exclusive, Retention::Intention(kept))],
        potential: Potential::Nearness { to: stand, floor_m: TOLERANCE_M, scale_by: Some(GRIPPER) },
        satisfied: Condition::At { place: to, stands: vec![stand], tolerance_m: TOLERANCE_M },
        precondition: Condition::Path { place: to, stands: vec![stand] },
        effects: vec![EffectTerm::Stands(stand)],
        commands: vec![CommandTerm { claim: 0, mode: Mode::Achieve, task: Task::DriveTo(to, stand) }],
        ..blank("move")
    }
}

fn there(body: Body, at: PlaceId) -> Vec<Claim> {
    let access = Access::Shared(at_channel(at));
    vec![claim(only(body, BASE), access, Retention::Release), claim(only(body, HEAD), access, Retention::Release)]
}

/// `pick` of the paper.
pub fn pick(body: Body, object: ObjectId, at: PlaceId, places: usize) -> BehaviorSpec {
    let stand = place(at.index(), places).stand;
    let mut claims = there(body, at);
    let wanted = Selector::AnyEmpty { of: GRIPPER, reaches: Some(object) };
    claims.push(claim(wanted, Access::Exclusive, Retention::Physical(Access::Exclusive)));
    BehaviorSpec {
        claims,
        potential: Potential::Constant(1.0 + body.grippers as f64 / TOLERANCE_M),
        satisfied: Condition::Held(object.into()),
        precondition: Condition::All(vec![
            Condition::At { place: at, stands: vec![stand], tolerance_m: TOLERANCE_M },
            Condition::Free(object),
            Condition::Lies(object, at),
        ]),
        effects: vec![EffectTerm::Taken(object, 2)],
        commands: vec![
            CommandTerm { claim: 0, mode: Mode::Maintain, task: Task::Stand },
            CommandTerm { claim: 1, mode: Mode::Maintain, task: Task::LookAt(at) },
            CommandTerm { claim: 2, mode: Mode::Achieve, task: Task::Grasp(object) },
        ],
        changes: vec![object],
        ..blank("pick")
    }
}

/// `place` of the paper.
pub fn put(body: Body, object: ObjectId, at: PlaceId, places: usize) -> BehaviorSpec {
    let stand = place(at.index(), places).stand;
    let mut claims = there(body, at);
    claims.push(claim(
        Selector::Holding { object, of: GRIPPER, resource: None },
        Access::Exclusive,
        Retention::Release,
    ));
    BehaviorSpec {
        claims,
        potential: Potential::Constant(1.0 + body.grippers as f64 / TOLERANCE_M),
        satisfied: Condition::Lies(object, at),
        precondition: Condition::All(vec![
            Condition::At { place: at, stands: vec![stand], tolerance_m: TOLERANCE_M },
            Condition::Held(object.into()),
        ]),
        effects: vec![EffectTerm::Lies(object, at)],
        commands: vec![
            CommandTerm { claim: 0, mode: Mode::Maintain, task: Task::Stand },
            CommandTerm { claim: 1, mode: Mode::Maintain, task: Task::LookAt(at) },
            CommandTerm { claim: 2, mode: Mode::Achieve, task: Task::Put(object, at) },
        ],
        changes: vec![object],
        ..blank("place")
    }
}

/// A behavior that sets a fact, is satisfied by it, and needs one resource alone.
pub fn fact(holds: FactId) -> BehaviorSpec {
    BehaviorSpec {
        satisfied: Condition::Fact(holds, true),
        effects: vec![EffectTerm::Fact(holds, true)],
        ..blank("fact")
    }
}
