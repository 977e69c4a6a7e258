//! Missions built in code.

use std::time::Duration;

use ambidex::model::{
    BehaviorSpec, Claim, CommandTerm, Condition, ControllerSpec, Distance, MissionSpec, Names, NodeId, NodeKind,
    ObjectId, Pose, Potential, ResourceSpec, RobotSpec, Topology, TreeSpec, WorldSpec, WorldState,
};

/// A robot and a tree in an empty world; `nodes` are in preorder, each with its parent.
pub fn build(
    resources: Vec<ResourceSpec>,
    controllers: Vec<ControllerSpec>,
    nodes: Vec<(NodeId, NodeKind)>,
    facts: usize,
) -> MissionSpec {
    let (parents, nodes): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
    let names = Names {
        nodes: (0..nodes.len()).map(|id| format!("node {id}")).collect(),
        controllers: controllers.iter().map(|spec| spec.name.clone()).collect(),
        ..Names::default()
    };
    MissionSpec {
        name: "bench".into(),
        robot: RobotSpec { name: "bench".into(), resources, controllers, radius_m: 0.4 },
        world: WorldSpec {
            places: Vec::new(),
            objects: Vec::new(),
            obstacles: Vec::new(),
            distance: Distance::Straight,
            outside: vec![true; facts],
        },
        start: WorldState::new(Pose::new(0.0, 0.0, 0.0), Vec::new(), vec![false; facts]),
        tree: TreeSpec::new(nodes, Topology::new(parents)),
        names,
        source: None,
    }
}

/// A behavior that is done only by running.
pub fn behavior(
    claims: Vec<Claim>,
    commands: Vec<CommandTerm>,
    satisfied: Condition,
    precondition: Condition,
    potential: Potential,
) -> NodeKind {
    NodeKind::Behavior(Box::new(BehaviorSpec {
        kind: "bench".into(),
        claims,
        potential,
        satisfied,
        precondition,
        lasting: Condition::All(Vec::new()),
        is_interruptible: true,
        effects: Vec::new(),
        commands,
        changes: Vec::<ObjectId>::new(),
        takes: Duration::ZERO,
        timeout: Duration::from_secs(600),
        retries: 0,
        backoff: Duration::ZERO,
        elsewhere: None,
        stands: None,
    }))
}
